"""Every diagnostic by name: its number, which stays for ever, its severity, what it means, and a log that raises it.

A number is printed and looked up; the name is what the code says. One record a diagnostic, nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

from msgspec import Struct

Severity = Literal["error", "warning", "note"]


class Code(Struct, frozen=True):
    """What a diagnostic code stands for."""

    severity: Severity
    title: str
    text: str | Callable[[], str]
    """The example; a long one is written when it is asked for."""
    remedy: str = ""
    """What to do; "" where the message that the example raises says it."""

    @property
    def example(self) -> str:
        """A short log (or command-line options, after ``gyro``) that raises it."""
        return self.text if isinstance(self.text, str) else self.text()


CODES: dict[str, Code] = {}
"""Every code that the tool can raise."""


def _code(severity: Severity, number: str, title: str, text: str | Callable[[], str], remedy: str = "") -> str:
    """Enter a diagnostic into `CODES`, and give its number for a name."""
    CODES[number] = Code(severity, title, text, remedy)
    return number


_error, _warning, _note = (partial(_code, severity) for severity in ("error", "warning", "note"))

G = "# g: 9.803 m/s^2\n"
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"
LOG = HEAD + "\n"
FALLING = "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n"
RUBRIC = "schema = 1\npoints = 2\n[[criterion]]\nid = 'log'\n"


def _many_readings() -> str:
    return G + LOG + "".join(f"{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1\n" for k in range(2600))


# the file
FILE_NOT_FOUND = _error(
    "G101", "there is no such file", "analyze no-such-file.csv", "check the name and the folder: ls shows what is there"
)
FILE_CANNOT_BE_OPENED = _error(
    "G102",
    "the file cannot be opened",
    "analyze .",
    "give a file that is a log, not a folder, and one that you may read",
)
LOG_IS_EMPTY = _error("G103", "the log is empty", "")
OTHER_KIND_OF_FILE = _error("G104", "another kind of file", "%PDF-1.7 a report, not a log")
NOT_TEXT = _error("G105", "not text", "mass [g]\x00position")
FILE_TOO_LARGE = _error(
    "G106",
    "the file is too large",
    "analyze eleven-megabytes.csv",
    "give the table alone: a lab's log has a few kilobytes",
)
COMPRESSED_FILE_DAMAGED = _error("G107", "a compressed file that is damaged", "\x1f\x8b\x08 and no more")
WORKBOOK_CANNOT_BE_READ = _error(
    "G108",
    "a workbook that cannot be read",
    "analyze log.xlsx",
    "save the sheet as CSV in the spreadsheet program, and give that file",
)
CODE_PAGE_GUESSED = _note("G109", "the file is not UTF-8; a code page was guessed", LOG + "20,15.0,206,7.06,1/3 ±\n")

# the sheet
SUMMARY_LEFT_OUT = _note("G140", "a row of means or sums is no run", LOG + "20,15,406,13.06,1/3\nMean,15,406,13.06,\n")
CAPTION_READ = _note(
    "G141",
    "a caption says what holds for the runs below it",
    "Weight: 20 g at 15.0 cm\nspin [rpm],time [s],turns\n406,13.06,1/3\n",
)
TABLES_JOINED = _note("G142", "several tables are read as one", LOG + f"20,15,406,13.06,1/3\n{LOG}40,15,406,6.6,1/3\n")
TABLE_LEFT_OUT = _note(
    "G143",
    "a table that holds no runs, or means only",
    LOG + "20,15,406,13.06,1/3\nmass [g],I_zz [kg m^2]\n20,0.0044\n",
)
TURNS_IN_HEADER = _note(
    "G145",
    "a header states the turns of its times",
    "mass [g],position [cm],spin [rpm],Time for 1/3 rev (s)\n20,15.0,406,13.06\n",
)
DATE_IS_A_FRACTION = _note("G146", "a date in a column of turns is a fraction", LOG + "20,15.0,406,13.06,3-Jan\n")

TABLE_IS_TURNED = _note(
    "G147",
    "the names of the quantities are at the side",
    "mass [g],20,20\nposition [cm],15,15\nspin [rpm],200,400\ntime [s],20.1,40.2\nturns,1,1\n",
)

# the table
NO_HEADER_ROW = _error("G201", "no header row", "20,15.0,406,13.06,1/3\n")
HEADER_WITHOUT_RUNS = _error("G202", "a header without runs", LOG)
CELL_IS_NO_NUMBER = _error("G203", "a cell is not a number", LOG + "20,15.0,56O,13.06,1/3\n")
CELL_BECAME_A_DATE = _error("G204", "a spreadsheet made a date of a cell", LOG + "20,15.0,03.Jan,13.06,1\n")
UNIT_UNKNOWN = _error(
    "G205",
    "a unit that is unknown, or of another kind",
    "mass [g],position [cm],spin [furlong],time [s],turns\n20,15,4,7.06,1\n",
)
UNIT_MISSING = _error(
    "G206", "a unit is missing", "mass [g],position [cm],spin,time [s],turns\n20,15.0,560,13.06,1/3\n"
)
HEADER_FITS_TWO_ROLES = _error(
    "G207", "a header fits two roles", "mass [g],position [cm],spin [rpm],T [s],turns\n20,15.0,406,39.2,1/3\n"
)
PER_SECOND_IS_AMBIGUOUS = _error(
    "G208",
    "1/s can mean revolutions or radians",
    "mass [g],position [cm],spin [1/s],time [s],turns\n20,15.0,9,13.06,1/3\n",
)
ROW_TOO_LONG = _error("G209", "a row has more cells than the header", LOG + "20,15,0,560,13,06,1/3\n")
HEADER_STANDS_TWICE = _error("G210", "two columns with the same header", "time [s],time [s]\n1,2\n")
BLOCKS_STACKED = _error(
    "G212",
    "blocks are stacked that do not go together",
    LOG + "20,15.0,406,13.06,1/3\nposition [cm],spin [rpm],time [s],turns\n15.0,406,6.61,1/3\n",
)
ROW_IS_ONLY_A_TITLE = _note(
    "G214",
    "a row that is only a title",
    "Task III\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)
NUMBER_IMPOSSIBLE = _error("G215", "a number that cannot be", LOG + "20,15.0,406,0,1/3\n")
ROW_WITHOUT_TIME = _warning(
    "G216",
    "a row without a time is no run",
    LOG + "20,15.0,406,13.06,1/3\n20,15.0,406,-,1/3\n",
    "write the time there, if the run was timed",
)
BLANK_TAKES_VALUE_ABOVE = _note(
    "G217",
    "blank cells take the value above",
    LOG + "20,15.0,406,13.06,1/3\n,,598,19.2,1/3\n",
    "write another value there if the one above is not meant",
)
VALUE_BELOW_ITS_FIRST_ROW = _error(
    "G219", "a value below the first row it belongs to", LOG + ",15.0,406,13.06,1/3\n20,15.0,406,13.06,1/3\n"
)
COLUMN_NOT_USED = _note(
    "G220",
    "a column is not used",
    HEAD + ",T [s],Ω [1/s]\n20,15.0,406,13.06,1/3,39.18,0.16\n",
    "nothing, if the column is not needed; else name it with --map",
)
HEADER_UNKNOWN = _note("G221", "headers that name nothing known", HEAD + ",moon\n20,15.0,406,13.06,1/3,full\n")
NO_DELIMITER = _error("G222", "no delimiter between the columns", "mass_position_spin_time\n20_15.0_560_13.06\n")
TOO_MANY_ROWS = _error(
    "G223",
    "more than 100 000 rows",
    "analyze hundred-thousand-rows.csv",
    "give one lab's log; a sensor's time series is no log of runs",
)
TOO_MANY_COLUMNS = _error("G224", "more than 200 columns", "a,b," * 120 + "c\n1,2\n")
CELL_TOO_LONG = _error(
    "G225",
    "a cell of more than 10 000 characters",
    LOG + "x" * 10_001 + ",1,1,1,1\n",
    "take the long text out of the table",
)
QUOTE_NEVER_CLOSED = _error("G226", "a quoted cell is never closed", LOG + '20,"15.0,560,13.06,1/3\n')
UNCERTAINTY_CANNOT_BE_READ = _error(
    "G227", "an uncertainty that cannot be read", HEAD + ",u_time [s]\n20,15.0,560,13.06,1/3,little\n"
)
ROW_TAKEN_OUT = _note(
    "G228",
    "a row that a # takes out",
    LOG + "20,15,406,13.06,1/3\n#,20,15,598,19.2,1/3\n",
    "take the # away if the run counts",
)
NOTE_IS_ONLY_A_NUMBER = _warning("G229", "a note that is only a number", HEAD + ",note\n20,15,5,206,7,1\n")
TURNS_FOR_ONE_PERIOD = _error(
    "G230",
    "turns are given for the time of one turn",
    "mass [g],position [cm],spin [rpm],precession period [s],turns\n20,15.0,406,39.2,3\n",
)
TIME_AND_PERIOD_EXCHANGED = _error(
    "G231",
    "the time and the period are exchanged",
    "mass [g],position [cm],spin [rpm],t [s],T [s],turns\n20,15.0,406,39.2,117.6,3\n",
)
HEADER_PARTED_BY_COMMA = _error(
    "G232",
    "a header that its own comma parts",
    "mass [g],position [cm],spin [rpm],period [s], 5 turns\n20,15.0,406,39.2\n",
)
HEADER_READ_AS = _note(
    "G236",
    "a header of two meanings is read with the help of the other columns",
    "mass [g],position [cm],spin [rpm],T [s]\n20,15.0,406,39.18\n40,15.0,404,19.6\n60,15.0,602,19.5\n",
)
LINE_READ_AS_KEY = _note(
    "G310", "a line that is read as a key with its value", "g = 9.81 m/s^2\n" + LOG + "20,15.0,406,13.06,1/3\n"
)
NOTE_MAY_CHANGE_READING = _warning(
    "G240",
    "a note that may change a reading",
    LOG + "20,15.0,812,13.06,1/3\n2 reflective strips: twice the real rpm\n",
)
LAPS_OF_ONE_CLOCK = _error(
    "G241",
    "times that are laps of one clock, not repeats",
    "mass [g],position [cm],spin [rpm],lap 1 [s],lap 2 [s],lap 3 [s]\n20,15.0,406,39.2,78.4,117.6\n",
)
COLON_BELOW_SECONDS = _error("G233", "a time with a colon, below a header in seconds", LOG + "20,15.0,406,13:06,1/3\n")
COLONS_ARE_POINTS = _note(
    "G234",
    "a stopwatch's colons are decimal points",
    LOG + "20,15.0,406,13:06,1/3\n20,15.0,206,06:90,1/3\n",
    'nothing, if that is meant; minutes and seconds belong below a header such as "time [min:s]"',
)
FLOATS_WITHOUT_DIGITS = _note(
    "G235",
    "a DataFrame's floats do not contain the digits that were read",
    "analyze table-of-pandas",
    "read the table as text, with pandas.read_csv(…, dtype=str), or state uncertainties such as u_position",
)

# what the log says
QUANTITY_MISSING = _error(
    "G301", "a quantity is missing", "mass [g],position [cm],spin [rpm],time [s]\n20,15.0,406,13.06\n"
)
RUN_LACKS_QUANTITY = _error(
    "G302", "a run lacks a quantity", LOG + "20,15,406,13.1,1/3\n20,15,407,13.1,1/3\n20,15,598,19.2,\n"
)
TURNS_CONTRADICT_ANGLE = _error(
    "G303", "turns and angle contradict each other", HEAD + ",angle [deg]\n20,15.0,406,13.06,1/3,90\n"
)
OPTION_REPLACES_COLUMN = _note(
    "G304",
    "an option takes the place of a column",
    'analyze log.csv --set spin="400 rpm"',
    "leave the option or the column away if that is not meant",
)
KEY_NEARLY_KNOWN = _warning(
    "G305", "a # key that is nearly one this tool knows", "# u_tme: 0.2 s\n" + LOG + "20,15.0,406,13.06,1/3\n"
)
KEY_VALUE_CANNOT_BE_READ = _error(
    "G306",
    "the value of a # line cannot be read",
    "# g: fast\n" + LOG + "20,15.0,406,13.06,1/3\n",
    'write a number with its unit, such as "# g: 9.803 m/s^2"',
)
KEY_GIVEN_TWICE = _error(
    "G307",
    "a # key is given twice, with two values",
    "# g: 9.8 m/s^2\n# g: 9.9 m/s^2\n" + LOG + "20,15.0,406,13.06,1/3\n",
)
REPORTED_VALUE_CANNOT_BE_READ = _note(
    "G308",
    "a reported value that cannot be read as it stands",
    "# reported_inertia: 4.4e-3\n" + LOG + "20,15.0,406,13.06,1/3\n",
)
G_WITHOUT_UNIT = _note("G309", "g has no unit and is read in m/s²", "# g: 9.803\n" + LOG + "20,15.0,406,13.06,1/3\n")
POSITION_ORIGIN_UNKNOWN = _error(
    "G340",
    "positions do not count from the centre of the ball, and how far off it is not given",
    "mass [g],distance from ball surface [cm],spin [rpm],time [s],turns\n20,9.9,406,13.06,1/3\n",
)
POSITION_MOVED = _note(
    "G341",
    "positions that count from elsewhere are made to count from the centre of the ball",
    "# position_from: surface\n# ball_diameter: 10.16 cm\n" + LOG + "20,9.9,406,13.06,1/3\n",
)
TURNS_ROUNDED = _warning("G342", "turns that may be a rounded third", LOG + "20,15.0,406,13.06,0.33\n")

# what the readings say
DERIVED_COLUMN_DISAGREES = _warning(
    "G401",
    "a derived column disagrees with the readings",
    HEAD + ",precession period [s]\n20.00,15.0,400,39.7,1,13.2\n",
)
SENSES_CONTRADICT_TORQUE = _warning(
    "G402",
    "the senses written contradict the sign of the torque",
    HEAD + ",spin_sense,precession_sense\n20.00,15.0,400,39.7,1,ccw,cw\n",
)
SPIN_RISES = _warning("G403", "the spin rises during the interval", FALLING + "20.00,15.0,400,450,39.7,1\n")
GRAVITY_NOT_GIVEN = _note("G404", "no acceleration of free fall is given", LOG + "20.00,15.0,400,39.7,1\n")
PRECESSION_FASTER_THAN_SPIN = _warning("G405", "the precession is faster than the spin", LOG + "20.00,15.0,4,0.397,1\n")

_UNCERTAINTY_NOT_USED_LOG = f"{G}# u_pitch: 1 deg\n{LOG}20.00,15.0,206,20.4,1\n"
UNCERTAINTY_NOT_USED = _warning("G406", "an uncertainty that changes nothing in this log", _UNCERTAINTY_NOT_USED_LOG)
DIGITS_TOO_FEW = _warning(
    "G407",
    "the digits written decide much of the uncertainty",
    G + LOG.replace("[g]", "[kg]") + "0.02,15.0,206,20.4,1\n0.04,15.0,407,20.1,1\n0.06,15.0,404,13.4,1\n",
)
ROWS_IDENTICAL = _warning(
    "G408", "rows are identical", G + LOG + "20.00,15.0,206,20.41,1\n40.00,15.0,407,20.1,1\n20.00,15.0,206,20.41,1\n"
)

# what the fit says
_ODD_RUN = f"""{G}{LOG}\
20.00,15.0,206,20.4,1
20.00,15.0,407,40.4,1
40.00,15.0,405,20.1,1
40.00,15.0,607,30.1,2
60.00,15.0,404,13.4,1
60.00,15.0,603,20.0,1
"""
OUTLIER = _warning("G410", "a run does not go with the others", _ODD_RUN)
_SCATTER_TOO_LARGE_LOG = f"""{G}\
# u_time: 0.01 s
{LOG}\
20.00,15.0,206,20.9,1
20.00,15.0,407,40.1,1
40.00,15.0,405,20.5,1
40.00,15.0,607,29.8,1
60.00,15.0,404,13.7,1
60.00,15.0,603,19.8,1
"""
SCATTER_TOO_LARGE = _warning(
    "G411", "the scatter is larger than the stated uncertainties allow", _SCATTER_TOO_LARGE_LOG
)
_BALANCE_TEST_CONTRADICTED_LOG = f"""{G}\
# u_imbalance: 0.00001 N*m
{LOG}\
20.00,15.0,206,16.0,1
20.00,15.0,407,31.6,1
40.00,15.0,405,18.0,1
40.00,15.0,607,27.0,1
60.00,15.0,404,12.5,1
60.00,15.0,603,18.6,1
"""
BALANCE_TEST_CONTRADICTED = _warning(
    "G412", "the data contradict the balance test in the log", _BALANCE_TEST_CONTRADICTED_LOG
)
NO_TORQUE = _error("G413", "no run has a torque", G + LOG + "0,,400,160.2,1/3\n0,,600,240.3,1/3\n")
SINGLE_TORQUE = _warning(
    "G414", "I_zz rests on a single torque", G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n"
)
_NO_STEADY_PRECESSION_LOG = f"""{G}\
# transverse_inertia: 0.02 kg*m^2
{HEAD},pitch [deg]
60.00,15.0,400,13.3,1,0
60.00,15.0,600,19.9,1,0
60.00,15.0,300,10.0,1,0
60.00,15.0,20,2.5,1,60
"""
NO_STEADY_PRECESSION = _error(
    "G415", "no steady precession is possible at this tilt and spin", _NO_STEADY_PRECESSION_LOG
)
TOO_MANY_SHARED_READINGS = _error("G416", "too many shared readings for one fit", _many_readings)
_TRANSVERSE_INERTIA_LOG = f"""{G}\
# u_time: 0.01 s
# u_time_bias: 0 s
# u_spin_delay: 0 s
# u_imbalance: 0 N*m
# u_position_zero: 0.1 mm
# u_mass: 0.05 %
# u_pitch: 0.5 deg
{HEAD},pitch [deg]
120.00,15.00,150,2.11,1,60
120.00,15.00,160,2.31,1,60
"""
TRANSVERSE_INERTIA_NOT_GIVEN = _warning(
    "G417", "the tilt matters, and the transverse moment of inertia is not given", _TRANSVERSE_INERTIA_LOG
)
_RELEASE_NOT_TOLD_LOG = f"""{G}{LOG}\
60.00,15.0,100.0,3.69,1
60.00,15.0,200.0,6.77,1
120.00,15.0,100.0,2.43,1
120.00,15.0,200.0,3.47,1
"""
RELEASE_NOT_TOLD = _note(
    "G418", "the log does not say whether the rod was let go from rest, and that matters", _RELEASE_NOT_TOLD_LOG
)
_RUNS_CONTRADICT_EACH_OTHER_LOG = f"""{G}{LOG}\
20.00,15.0,206,20.4,1
20.00,15.0,407,80,1
40.00,15.0,405,60,1
"""
RUNS_CONTRADICT_EACH_OTHER = _warning(
    "G419", "the runs contradict each other beyond all measure", _RUNS_CONTRADICT_EACH_OTHER_LOG
)
_TURNS_OF_WEIGHTS_WRONG_LOG = f"""{G}{LOG}\
20.00,15.0,206,6.76,1/3
20.00,15.0,407,13.4,1/3
40.00,15.0,405,13.3,1/3
40.00,15.0,607,19.9,1/3
60.00,15.0,404,13.2,1/3
60.00,15.0,603,19.8,1/3
"""
TURNS_OF_WEIGHTS_WRONG = _error("G420", "the turns of whole weights are wrong", _TURNS_OF_WEIGHTS_WRONG_LOG)
_NO_INERTIA_FITS_LOG = f"""{G}{LOG}\
20.00,15.0,206,20.4,1
20.00,15.0,407,0.0404,1
40.00,15.0,405,2010,1
"""
NO_INERTIA_FITS = _error("G421", "no moment of inertia goes with the runs", _NO_INERTIA_FITS_LOG)
_RELEASE_FALLS_LOG = f"""{G}\
# motion: released
{LOG}\
20.00,15.0,20,4.02,1
20.00,15.0,40,5.29,1
40.00,15.0,20,3.02,1
40.00,15.0,40,3.16,1
60.00,15.0,20,2.67,1
60.00,15.0,40,2.69,1
"""
RELEASE_FALLS = _error("G425", "a rod that is released falls too far", _RELEASE_FALLS_LOG)
_DIRECTION_MISSING_LOG = f"""{G}{LOG}\
20.00,15.00,200.0,19.80,1
20.00,15.00,600.0,59.40,1
40.00,15.00,400.0,19.85,1
60.00,15.00,200.0,6.62,1
60.00,15.00,600.0,19.87,1
0,,400.0,150,1/20
"""
DIRECTION_MISSING = _warning("G426", "the direction of a run without a weight is missing", _DIRECTION_MISSING_LOG)
ROD_STAYED = _note(
    "G427",
    "a run without a weight in which the rod did not move",
    f"""{G}{LOG}\
20.00,15.0,400,39.7,1
40.00,15.0,400,19.8,1
60.00,15.0,400,13.2,1
0,,400,120,0
""",
)

_PATTERN_LOG = f"""{G}\
# u_time: 0.14 s
{LOG}\
20.00,15.0,400,41.49,1
60.00,15.0,400,13.36,1
40.00,15.0,600,30.25,1
20.00,15.0,600,60.24,1
60.00,15.0,200,6.63,1
40.00,15.0,400,19.80,1
20.00,15.0,200,19.42,1
60.00,15.0,600,19.63,1
40.00,15.0,200,9.68,1
20.00,15.0,400,37.80,1
"""
PATTERN_IN_RESIDUALS = _warning("G431", "what the fit leaves over is no accident", _PATTERN_LOG)
_AGREES_TOO_WELL_LOG = f"""{G}\
# u_time: 0.5 s
{LOG}\
20.00,15.0,206,20.33,1
20.00,15.0,407,40.17,1
20.00,15.0,605,59.72,1
40.00,15.0,206,10.17,1
40.00,15.0,407,20.09,1
40.00,15.0,605,29.86,1
60.00,15.0,206,6.78,1
60.00,15.0,407,13.39,1
60.00,15.0,605,19.91,1
"""
AGREES_TOO_WELL = _note("G432", "the runs agree better than the stated uncertainties", _AGREES_TOO_WELL_LOG)
_BALANCE_POOR_LOG = f"""{G}{LOG}\
20.00,15.0,206,15.64,1
20.00,15.0,407,30.90,1
40.00,15.0,405,17.57,1
40.00,15.0,607,26.34,1
60.00,15.0,404,12.27,1
60.00,15.0,603,18.32,1
"""
BALANCE_POOR = _warning("G433", "the residual torque is over a fifth of the lightest torque", _BALANCE_POOR_LOG)
_SPIN_FELL_ALONE_LOG = f"""{G}{FALLING}\
20.00,15.0,410,402,40.0,1
40.00,15.0,410,406,20.1,1
60.00,15.0,410,360,12.7,1
20.00,15.0,610,598,59.6,1
40.00,15.0,610,604,29.9,1
60.00,15.0,610,606,20.0,1
"""
SPIN_FELL_ALONE = _warning("G434", "the spin of one run falls faster than that of the others", _SPIN_FELL_ALONE_LOG)
NOT_MEASURED = _error(
    "G435",
    "the interval of I_zz holds zero or less",
    G + "# u_time: 100 s\n" + LOG + "20.00,15.0,206,20.4,1\n40.00,15.0,407,20.2,1\n60.00,15.0,407,13.4,1\n",
)

# what is not of this lab
_KILOGRAMS_LOG = _ODD_RUN.replace("[g]", "[kg]")
SIZE_UNUSUAL = _warning("G440", "a reading that is not of this lab: is this the unit?", _KILOGRAMS_LOG)
_EXCHANGED_LOG = f"""{G}\
mass [g],position [cm],time [s],spin [rpm],turns
20.1,14.8,212,7.02,1/3
20.1,14.8,398,12.96,1/3
40.3,14.8,398,6.51,1/3
40.3,14.8,604,9.94,1/3
60.2,14.8,398,13.26,1
60.2,14.8,604,19.97,1
"""
COLUMNS_EXCHANGED = _warning("G441", "the columns of spin and time are exchanged", _EXCHANGED_LOG)
_HUGE_LOG = f"""{G}\
torque [N*m],spin [rpm],time [s],turns
10,200,12.3,1/100
20,400,12.1,1/100
30,600,12.2,1/100
"""
INERTIA_UNUSUAL = _warning("G442", "a moment of inertia that is not of this lab", _HUGE_LOG)
_SURFACE_LOG = f"""{G}\
# ball_mass: 4.3 kg
# ball_diameter: 10.16 cm
{LOG}\
20.00,9.92,206,20.4,1
20.00,9.92,407,40.4,1
40.00,9.92,405,20.1,1
60.00,9.92,404,13.4,1
60.00,9.92,603,20.0,1
"""
BALL_DISAGREES = _warning("G443", "I_zz is not that of the ball or disk in the log", _SURFACE_LOG)
SIZE_NOT_USUAL = _warning(
    "G444", "a column is possible but not usual: is its unit right?", _ODD_RUN.replace("rpm", "Hz")
)
_EITHER_LOG = f"""{G}{LOG}\
20.00,15.0,206,102.3,5
20.00,15.0,407,202.2,5
20.00,15.0,605,300.5,5
40.00,15.0,206,61.4,5
40.00,15.0,407,101.1,5
40.00,15.0,605,180.3,5
"""
EITHER_RUN_WRONG = _warning("G445", "one of two runs is wrong, and the others do not say which", _EITHER_LOG)
_NO_PROPORTION_LOG = f"""{G}{LOG}\
20.00,15.0,206,21.6,1
20.00,15.0,407,39.8,1
20.00,15.0,605,56.8,1
40.00,15.0,206,10.8,1
40.00,15.0,407,19.9,1
40.00,15.0,605,28.4,1
60.00,15.0,206,7.2,1
60.00,15.0,407,13.3,1
60.00,15.0,605,18.9,1
"""
PERIOD_NOT_IN_PROPORTION = _warning("G446", "the period is not in proportion to the spin", _NO_PROPORTION_LOG)

# the procedure
_TOO_FEW_WEIGHTS_LOG = f"""{G}{LOG}\
20.00,15.0,206,20.4,1
20.00,15.0,407,40.4,1
20.00,15.0,605,60.1,1
"""
TOO_FEW_WEIGHTS = _warning("G451", "fewer than three weights", _TOO_FEW_WEIGHTS_LOG)
TOO_FEW_RUNS = _warning("G452", "fewer than three runs with a weight", G + LOG + "20.00,15.0,206,20.4,1\n")
_SPINS_TOO_CLOSE_LOG = f"""{G}{LOG}\
20.00,15.0,400,39.7,1
20.00,15.0,410,40.7,1
20.00,15.0,420,41.7,1
"""
SPINS_TOO_CLOSE = _warning("G453", "the spins of a weight are close together", _SPINS_TOO_CLOSE_LOG)
_NO_UNLOADED_RUN_LOG = f"""{G}{LOG}\
20.00,15.0,206,20.4,1
20.00,15.0,407,40.4,1
20.00,15.0,605,60.1,1
40.00,15.0,405,20.1,1
"""
NO_UNLOADED_RUN = _warning("G454", "no run without a weight", _NO_UNLOADED_RUN_LOG)
TIMES_TOO_SHORT = _warning("G455", "times under 6 s", G + LOG + "60.00,15.0,206,2.26,1/3\n")
SPIN_FALLS_TOO_MUCH = _warning(
    "G456", "the spin falls by more than 10 % in a run", G + FALLING + "20.00,15.0,400,330,36.0,1\n"
)

# options that go with a log
OPTION_KEY_UNKNOWN = _error(
    "G501",
    "--set or --config: there is no such key",
    "analyze log.csv --set trns=1",
    "take the key that the message proposes, or one that it lists, such as turns",
)
MAPPED_HEADER_UNKNOWN = _error(
    "G502",
    "--map: there is no such header",
    'analyze log.csv --map time="Zeitpunkt"',
    "copy the header from the file, in quotes",
)
MAPPED_ROLE_UNKNOWN = _error(
    "G503",
    "--map: there is no such role",
    'analyze log.csv --map tme="time [s]"',
    "take the role that the message proposes, or one that it lists, such as time",
)
OPTION_VALUE_CANNOT_BE_READ = _error(
    "G504",
    "--set or --config: the value cannot be read",
    "analyze log.csv --set g=fast",
    'write it as the message says; a number has its unit, such as --set g="9.803 m/s^2"',
)
CONFIG_CANNOT_BE_READ = _error(
    "G505",
    "--config: the file cannot be read",
    "analyze log.csv --config no-such-file.toml",
    'check its name, and give a TOML file with lines such as g = "9.803 m/s^2"',
)
TEMPLATE_VALUE_CANNOT_BE_READ = _error(
    "G506",
    "template: a value cannot be read",
    "template --weights 20 --spins fast",
    "write numbers with units, such as --spins 200,400,600rpm",
)

# options of a command
OPTION_IS_NO_PAIR = _error(
    "G601",
    "an option is not of the form KEY=VALUE",
    "analyze log.csv --set turns",
    "write the option as KEY=VALUE, such as --set turns=1/3",
)
FORMAT_FOR_ONE_LOG = _error(
    "G602",
    "a form that is for one log",
    "analyze a.csv b.csv --format json",
    "give one log; or for several --format ndjson in the place of json, markdown in that of latex",
)
REPORT_CANNOT_BE_WRITTEN = _error(
    "G603",
    "the report cannot be written",
    "analyze log.csv --out /dev/null",
    "choose a folder that can be written to with --out",
)
OPTION_NOT_FOR_FORMAT = _error(
    "G604",
    "an option for another form",
    "analyze log.csv --format json --table logs",
    "--table is for --format csv: add --format csv, or leave --table out",
)
CANNOT_BE_WATCHED = _error(
    "G605",
    "what cannot be watched",
    "analyze a.csv b.csv --watch",
    "watch one file in the terminal: gyro analyze log.csv --watch",
)
STREAM_CANNOT_BE_USED = _error(
    "G606",
    "standard output or input cannot be used",
    "analyze log.csv > /dev/full",
    "make room on the disk, or write to another file",
)
EXPLAINED_CODE_UNKNOWN = _error(
    "G607",
    "explain: there is no such code",
    "explain G999",
    "take a code as a message shows it, such as G454; gyro schema diagnostics lists all",
)
HAND_IN_AS_IT_IS = _error(
    "G608",
    "--hand-in with an option that gyro grade does not know",
    "check log.csv --hand-in --set turns=1",
    "leave the option out, and write what it says into the log: # turns: 1",
)
FOLDER_IN_USE = _error(
    "G609",
    "another gyro writes into the same folder",
    "grade class, twice at the same time",
    "wait until the other is done, then run it again; or choose another folder with --out",
)

# gyro predict
OPTION_IS_NO_QUANTITY = _error(
    "G621",
    "an option is not a number with a unit that fits",
    'predict tip --force 0.5N --length 20cm --inertia "4.44e-3 kg m^2" --spin 400',
    "write a number with its unit in quotes, such as --spin 400rpm",
)
OPTION_NUMBER_IMPOSSIBLE = _error(
    "G622",
    "an option's number cannot be",
    'predict tip --force 0.5N --length 20cm --inertia "-4.44e-3 kg m^2" --spin 400rpm',
    "correct the number's sign or size",
)
TORQUE_MISSING_OR_TWICE = _error(
    "G623",
    "the torque is not given, or twice",
    'predict precession --inertia "4.44e-3 kg m^2" --spin 400rpm',
    "give either --torque, or --mass with --position",
)
OPTION_NOR_LOG_GIVEN = _error(
    "G624",
    "a number is given neither by an option nor by a log",
    "predict twist",
    "give the option that the message names, or a log to take it from: --log data.csv",
)

# gyro simulate
SIMULATED_VALUE_IMPOSSIBLE = _error(
    "G631", "simulate: a value that cannot be", "simulate --pitch 90deg", "correct the value that the message names"
)
SIMULATED_WITHOUT_TORQUE = _error(
    "G632",
    "simulate: a run without a torque",
    "simulate --weights 0g",
    "give a weight above zero, such as --weights 20g,40g",
)
SIMULATED_NO_STEADY_PRECESSION = _error(
    "G633",
    "simulate: no steady precession at this tilt and spin",
    "simulate --pitch 60deg --spins 20rpm",
    "take a faster spin or a smaller pitch",
)
TURNS_NEVER_COMPLETED = _error(
    "G634",
    "simulate: the turns are never completed",
    'simulate --spin-decay "0.5 s" --turns 3',
    "take a slower decay, or fewer turns",
)
SIMULATED_OPTIONS_CONTRADICT = _error(
    "G635",
    "simulate: two options contradict each other",
    "simulate --motion horizontal --pitch 10deg",
    "do what the message says, or leave one of the two options out",
)
NOISE_CANNOT_BE_READ = _error(
    "G636",
    "simulate: the noise cannot be read",
    "simulate --noise no-such-file.toml",
    "give a TOML file with sizes of noise, as gyro simulate --help says",
)
TRUTH_CANNOT_BE_WRITTEN = _error(
    "G637",
    "simulate: the truth cannot be written",
    "simulate --truth no-such-folder/truth.json",
    "give a file in a folder that is there",
)
FIXED_LOG_CANNOT_BE_WRITTEN = _error(
    "G639",
    "check --fix: the log cannot be written as gyro understood it",
    "check - --fix",
    "give the name of a log in a folder that can be written to: gyro check --fix log.csv writes log-fixed.csv",
)
OUT_IS_NO_FOLDER = _error(
    "G638",
    "--out is the name of a file that is not written",
    "analyze log.csv --out report.pdf",
    "give a folder: --out report; or a file for data: --format json --out report.json",
)

# a class
CLASS_IS_NO_FOLDER_OR_ZIP = _error(
    "G701", "the class is neither a folder nor a zip", "grade no-such-class", "give the folder of the class, or its zip"
)
ZIP_DAMAGED = _error("G702", "a zip that is damaged", "grade damaged.zip", "download the zip again")
ZIP_NOT_SAFE = _error(
    "G703",
    "a zip that is not safe to read",
    "grade evil.zip",
    "unpack it by hand where it can do no harm, look at it, and give the folder",
)
TOO_MANY_FILES = _error(
    "G704", "too many files for a class", "grade million-files.zip", "give the submissions of one class only"
)
NO_SUBMISSION = _error(
    "G705",
    "no submission is found",
    "grade class --lms canvas",
    "leave --lms out, or give a --pattern that fits the names of the files",
)
PATTERN_CANNOT_BE_USED = _error(
    "G706",
    "--pattern cannot be used",
    "grade class --pattern '(\\w+)_lab.csv'",
    "write a pattern with one named group for the student, (?P<student>...)",
)
FILES_OF_NO_STUDENT = _warning(
    "G707",
    "files of no student",
    "grade class, with a file of another kind of name",
    "rename them as the message says, or give a --pattern that fits them",
)
ONE_OF_SEVERAL_GRADED = _note(
    "G708",
    "one of several files or attempts is graded",
    "grade class, with two attempts",
    "nothing, unless another one should count: then take the others out",
)
GRADESCOPE_METADATA_CANNOT_BE_READ = _warning(
    "G709",
    "Gradescope's metadata cannot be read",
    "grade class, with a broken metadata file",
    "download the export again; the files are graded without it",
)
SUBMITTED_FILE_CANNOT_BE_READ = _error(
    "G713",
    "a submitted file cannot be read",
    "grade class, with a file that is cut off",
    "ask the student for the file again",
)
FILE_LEFT_OUT = _warning(
    "G714",
    "a file or folder of the class is left out",
    "grade class, with a link",
    "put a copy of the file itself in its place, if it belongs there; or do what the message says",
)
ANSWER_ELSEWHERE = _note(
    "G717",
    "the answer stands in a text beside the log",
    "grade class, with report.txt: I_zz = 4.4e-3 kg m^2",
    "nothing, if that is the answer; write it into the log, # I_zz = 4.4e-3 kg m^2, to have it read there",
)
ANSWER_READ = _note(
    "G718",
    "what is read as the answer",
    "check log.csv report.txt --hand-in, with report.txt: I_zz = 4.4e-3 ± 0.1e-3 kg m^2",
    "nothing, if it is the answer that is meant",
)
ANSWER_MISSING = _warning(
    "G719",
    "there is no answer that can be read",
    "check log.csv --hand-in, with no I_zz in it",
    "write it above the table of the log, and nowhere else: # reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2",
)

# a rubric
RUBRIC_NO_TOML = _error(
    "G721",
    "a rubric is no TOML file",
    "schema = 1\npoints = \n",
    "correct the line that the message names; a value stands right of the =",
)
RUBRIC_KEY_UNKNOWN = _error(
    "G722",
    "a rubric has a key that is not known",
    RUBRIC + "check = 'log'\npoints = 2\nponits = 3\n",
    "write the key that the message proposes, or take it out",
)
RUBRIC_VALUE_CANNOT_BE_USED = _error(
    "G723",
    "a value of a rubric is missing or cannot be used",
    RUBRIC + "check = 'log'\npoints = 'two'\n",
    "write the value in the form that the message shows",
)
_POINTS_DO_NOT_ADD_UP_RUBRIC = """schema = 1
points = 3
[[criterion]]
id = 'log'
points = 2
check = 'log'
"""
RUBRIC_POINTS_DO_NOT_ADD_UP = _error(
    "G724",
    "the points of a rubric do not add up",
    _POINTS_DO_NOT_ADD_UP_RUBRIC,
    "make the points of the criteria add up to the points at the top",
)
CRITERION_KIND_UNKNOWN = _error(
    "G725",
    "a criterion is of a kind that is not known",
    RUBRIC + "points = 2\ncheck = 'lgo'\n",
    "take one of the kinds that the message lists",
)
_CONDITION_RUBRIC = f"""{RUBRIC}\
points = 2
check = 'log'
full = 'warnings < 1'
zero = 'warnings >= 4'
"""
CONDITION_CANNOT_BE_USED = _error(
    "G726",
    "a condition cannot be used",
    _CONDITION_RUBRIC,
    "write a condition as the message says, such as warnings <= 0",
)
_PARTS_CONTRADICT_RUBRIC = f"""{RUBRIC}\
check = 'log'
points = 2
[reference]
from = 'class'
[reference.3]
inertia = '4e-3 kg m^2'
u = '1 %'
"""
RUBRIC_PARTS_CONTRADICT = _error(
    "G727",
    "two parts of a rubric do not go together",
    _PARTS_CONTRADICT_RUBRIC,
    "leave one of the two parts out, or write the one that is missing, as the message says",
)

# roster
ROSTER_CANNOT_BE_READ = _error(
    "G744",
    "a roster has no column that says who is who",
    "grade class --roster log.csv",
    "give the platform's gradebook, or a CSV with a column student",
)

# gradebooks
GRADEBOOK_CANNOT_BE_READ = _error(
    "G751",
    "a gradebook cannot be read",
    "grade class --gradebook picture.png",
    "export the gradebook as CSV from the platform, and give that file",
)
NO_CANVAS_GRADEBOOK = _error(
    "G752",
    "this is no Canvas gradebook",
    "grade class --gradebook grades.csv",
    "export the gradebook from Canvas anew, with its own header rows",
)
GRADEBOOK_COLUMN_NOT_CLEAR = _error(
    "G753",
    "which column of the gradebook to fill is not clear",
    "grade class --gradebook two.csv",
    "name the column with --assignment and the number behind its title",
)
GRADEBOOK_COLUMN_CANNOT_BE_FILLED = _error(
    "G754",
    "the column of the gradebook cannot be filled",
    "grade class --gradebook locked.csv",
    "do what the message says: unlock it, make the points the same, or name another with --assignment",
)
NO_MOODLE_WORKSHEET = _error(
    "G755",
    "this is no Moodle grading worksheet",
    "grade class --worksheet grades.csv",
    "download the worksheet from the assignment in Moodle, and give that file",
)
WORKSHEET_CANNOT_TAKE_POINTS = _error(
    "G756",
    "the worksheet cannot take these points",
    "grade class --worksheet ten-points.csv",
    "give the rubric as many points as the worksheet takes, or change the maximum grade in Moodle",
)
NO_BLACKBOARD_GRADE_CENTER = _error(
    "G757",
    "this is no Blackboard Grade Center",
    "grade class --grade-center grades.csv",
    "download the Grade Center from Blackboard in English, and give that file",
)

# the run of a class
JOURNAL_LINES_LOST = _note(
    "G762",
    "lines of the journal cannot be read",
    "grade class, after a power cut",
    "nothing: what is lost is graded anew",
)
GRADES_FOLDER_CANNOT_BE_WRITTEN = _error(
    "G763",
    "the folder of the grades cannot be written",
    "grade class --out /dev/null",
    "choose a folder that can be written to with --out",
)
NOTHING_TO_GRADE = _error(
    "G764", "there is nothing to grade", "grade", "give the folder or the zip of a class: gyro grade class"
)
OPTION_FILE_CANNOT_BE_READ = _error(
    "G765",
    "a file given with an option cannot be read",
    "grade class --rubric no-such-file.toml",
    "check the name of the file, or for --previous that of the folder of the grades",
)
GRADES_WITHIN_CLASS = _error(
    "G766",
    "the grades would be written into the class itself",
    "grade class --out class/grades",
    "write the grades elsewhere, with --out",
)
OPTION_NEEDS_A_FOLDER = _error(
    "G767",
    "an option needs a folder to write to",
    "grade class --format json --figures",
    "give --out FOLDER as well, or leave the option away",
)
AUTOGRADER_CANNOT_BE_MADE = _error(
    "G768",
    "an autograder cannot be made",
    "grade --gradescope autograder",
    "give a rubric whose points need no other student's log, as the message says; and install gyro",
)
CLUSTER_CANNOT_BE_USED = _error(
    "G769",
    "the cluster cannot be used",
    "grade class --cluster tcp://localhost:1",
    "install Dask with gyrodata[cluster], start a scheduler and workers, and give the address of the scheduler",
)

# the desk
DESK_CANNOT_BE_READ = _error(
    "G771",
    "desk.csv is no table with its columns",
    "desk.csv: doejane,total,12",
    "begin it with the line student,what,value,by,why",
)
DESK_STUDENT_UNKNOWN = _error(
    "G772",
    "a line of desk.csv is about nobody in this class",
    "desk.csv: dojane,total,12",
    "write the student as grades.csv does, or take the line out",
)
DESK_LINE_CANNOT_BE_USED = _error(
    "G773",
    "a line of desk.csv cannot be used",
    "desk.csv: doejane,totl,12",
    "correct the name or the value, as the message says",
)
DESK_LINES_CONTRADICT = _error(
    "G774",
    "two lines of desk.csv contradict each other",
    "desk.csv: doejane,total,12 and doejane,total,13",
    "keep the one that is meant, and take the other out",
)
LOG_CONTRADICTS_RIGHT_ANSWER = _warning(
    "G776",
    "the answer agrees with the reference, and the log does not",
    "mass [kg] above masses in grams, and # reported_inertia: 4.4e-3 kg m^2",
    "correct the log as the message says",
)
DESK_NAME_SHARED = _error(
    "G775",
    "a name in desk.csv belongs to several students",
    "desk.csv: Jane Doe,total,12",
    "write one of the ids in the message, instead of the name",
)

# gyro itself
FAULT_OF_GYRO = _error(
    "G901",
    "a fault of gyro itself",
    "no log should ever raise it",
    "report it, with the log and the line that names the place",
)
