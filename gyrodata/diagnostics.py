"""Every diagnostic by name: its number, which stays for ever, its severity, what it means, and a log that raises it.

A number is printed and looked up; the name is what the code says. One record a diagnostic, nowhere else.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

Severity = Literal["error", "warning", "note"]


class Code(NamedTuple):
    """What a diagnostic code stands for."""

    severity: Severity
    title: str
    example: str
    """A short log (or command-line options, after ``gyro``) that raises it."""


CODES: dict[str, Code] = {}
"""Every code that the tool can raise."""

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"
G = "# g: 9.803 m/s^2\n"


def _code(number: str, severity: Severity, title: str, example: str) -> str:
    """Enter a diagnostic into `CODES`, and give its number for a name."""
    CODES[number] = Code(severity, title, example)
    return number


FILE_NOT_FOUND = _code(
    "G101",
    "error",
    "there is no such file",
    "analyze no-such-file.csv",
)

FILE_CANNOT_BE_OPENED = _code(
    "G102",
    "error",
    "the file cannot be opened",
    "analyze .",
)

LOG_IS_EMPTY = _code(
    "G103",
    "error",
    "the log is empty",
    "",
)

OTHER_KIND_OF_FILE = _code(
    "G104",
    "error",
    "another kind of file",
    "%PDF-1.7 a report, not a log",
)

NOT_TEXT = _code(
    "G105",
    "error",
    "not text",
    "mass [g]\x00position",
)

FILE_TOO_LARGE = _code(
    "G106",
    "error",
    "the file is too large",
    "analyze eleven-megabytes.csv",
)

COMPRESSED_FILE_DAMAGED = _code(
    "G107",
    "error",
    "a compressed file that is damaged",
    "\x1f\x8b\x08 and no more",
)

WORKBOOK_CANNOT_BE_READ = _code(
    "G108",
    "error",
    "a workbook that cannot be read",
    "analyze log.xlsx",
)

CODE_PAGE_GUESSED = _code(
    "G109",
    "note",
    "the file is not UTF-8; a code page was guessed",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,206,7.06,1/3 ±\n",
)

NO_HEADER_ROW = _code(
    "G201",
    "error",
    "no header row",
    "20,15.0,406,13.06,1/3\n",
)

HEADER_WITHOUT_RUNS = _code(
    "G202",
    "error",
    "a header without runs",
    "mass [g],position [cm],spin [rpm],time [s],turns\n",
)

CELL_IS_NO_NUMBER = _code(
    "G203",
    "error",
    "a cell is not a number",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,56O,13.06,1/3\n",
)

CELL_BECAME_A_DATE = _code(
    "G204",
    "error",
    "a spreadsheet made a date of a cell",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,560,13.06,03.Jan\n",
)

UNIT_UNKNOWN = _code(
    "G205",
    "error",
    "a unit that is unknown, or of another kind",
    "mass [g],position [cm],spin [furlong],time [s],turns\n20,15,4,7.06,1\n",
)

UNIT_MISSING = _code(
    "G206",
    "error",
    "a unit is missing",
    "mass [g],position [cm],spin,time [s],turns\n20,15.0,560,13.06,1/3\n",
)

HEADER_FITS_TWO_ROLES = _code(
    "G207",
    "error",
    "a header fits two roles",
    "mass [g],position [cm],spin [rpm],T [s]\n20,15.0,406,39.2\n",
)

PER_SECOND_IS_AMBIGUOUS = _code(
    "G208",
    "error",
    "1/s can mean revolutions or radians",
    "mass [g],position [cm],spin [1/s],time [s],turns\n20,15.0,9,13.06,1/3\n",
)

ROW_TOO_LONG = _code(
    "G209",
    "error",
    "a row has more cells than the header",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,0,560,13,06,1/3\n",
)

HEADER_STANDS_TWICE = _code(
    "G210",
    "error",
    "two columns with the same header",
    "time [s],time [s]\n1,2\n",
)

BLOCKS_SIDE_BY_SIDE = _code(
    "G211",
    "error",
    "blocks stand side by side",
    'N,"t, s",N,"t, s"\n1,7.3,1,8.2\n',
)

BLOCKS_STACKED = _code(
    "G212",
    "error",
    "blocks are stacked",
    LOG + "20,15.0,406,13.06,1/3\n" + LOG + "20,15.0,406,13.06,1/3\n",
)

TABLE_TRANSPOSED = _code(
    "G213",
    "error",
    "the table is transposed",
    "mass [g],20,40\ntime [s],7.06,6.90\n",
)

ROW_IS_ONLY_A_TITLE = _code(
    "G214",
    "error",
    "a row that is only a title",
    "Task III\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

NUMBER_IMPOSSIBLE = _code(
    "G215",
    "error",
    "a number that cannot be",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,0,1/3\n",
)

ROW_WITHOUT_TIME = _code(
    "G216",
    "warning",
    "a row without a time is no run",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n20,15.0,406,-,1/3\n",
)

BLANK_TAKES_VALUE_ABOVE = _code(
    "G217",
    "note",
    "blank cells take the value above",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n,,598,19.2,1/3\n",
)

BLANK_SPIN = _code(
    "G218",
    "warning",
    "a blank spin that may be forgotten",
    LOG + "20,15.0,406,13.06,1/3\n20,15.0,406,13.06,1/3\n20,15.0,,13.1,1/3\n",
)

VALUE_BELOW_ITS_FIRST_ROW = _code(
    "G219",
    "error",
    "a value below the first row it belongs to",
    "mass [g],position [cm],spin [rpm],time [s],turns\n,15.0,406,13.06,1/3\n20,15.0,406,13.06,1/3\n",
)

COLUMN_NOT_USED = _code(
    "G220",
    "note",
    "a column is not used",
    "mass [g],position [cm],spin [rpm],time [s],turns,T [s],Ω [1/s]\n20,15.0,406,13.06,1/3,39.18,0.16\n",
)

HEADER_UNKNOWN = _code(
    "G221",
    "note",
    "headers that name nothing known",
    "mass [g],position [cm],spin [rpm],time [s],turns,moon\n20,15.0,406,13.06,1/3,full\n",
)

NO_DELIMITER = _code(
    "G222",
    "error",
    "no delimiter between the columns",
    "mass position spin time\n20 15.0 560 13.06\n",
)

TOO_MANY_ROWS = _code(
    "G223",
    "error",
    "more than 100 000 rows",
    "analyze hundred-thousand-rows.csv",
)

TOO_MANY_COLUMNS = _code(
    "G224",
    "error",
    "more than 200 columns",
    "a,b," * 120 + "c\n1,2\n",
)

CELL_TOO_LONG = _code(
    "G225",
    "error",
    "a cell of more than 10 000 characters",
    LOG + "x" * 10_001 + ",1,1,1,1\n",
)

QUOTE_NEVER_CLOSED = _code(
    "G226",
    "error",
    "a quoted cell is never closed",
    'mass [g],position [cm],spin [rpm],time [s],turns\n20,"15.0,560,13.06,1/3\n',
)

UNCERTAINTY_CANNOT_BE_READ = _code(
    "G227",
    "error",
    "an uncertainty that cannot be read",
    "mass [g],position [cm],spin [rpm],time [s],turns,u_time [s]\n20,15.0,560,13.06,1/3,little\n",
)

ROW_TAKEN_OUT = _code(
    "G228",
    "note",
    "a row that a # takes out",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,406,13.06,1/3\n#20,15,598,19.2,1/3\n",
)

NOTE_IS_ONLY_A_NUMBER = _code(
    "G229",
    "warning",
    "a note that is only a number",
    "mass [g],position [cm],spin [rpm],time [s],turns,note\n20,15,5,206,7,1\n",
)

TURNS_FOR_ONE_PERIOD = _code(
    "G230",
    "error",
    "turns are given for the time of one turn",
    "mass [g],position [cm],spin [rpm],precession period [s],turns\n20,15.0,406,39.2,3\n",
)

TIME_AND_PERIOD_EXCHANGED = _code(
    "G231",
    "error",
    "the time and the period are exchanged",
    "mass [g],position [cm],spin [rpm],t [s],T [s],turns\n20,15.0,406,39.2,117.6,3\n",
)

HEADER_PARTED_BY_COMMA = _code(
    "G232",
    "error",
    "a header that its own comma parts",
    "m, g,x [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

QUANTITY_MISSING = _code(
    "G301",
    "error",
    "a quantity is missing",
    "mass [g],position [cm],spin [rpm],time [s]\n20,15.0,406,13.06\n",
)

RUN_LACKS_QUANTITY = _code(
    "G302",
    "error",
    "a run lacks a quantity",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n20,15.0,598,19.2,\n",
)

TURNS_CONTRADICT_ANGLE = _code(
    "G303",
    "error",
    "turns and angle contradict each other",
    "mass [g],position [cm],spin [rpm],time [s],turns,angle [deg]\n20,15.0,406,13.06,1/3,90\n",
)

OPTION_REPLACES_COLUMN = _code(
    "G304",
    "note",
    "an option takes the place of a column",
    'analyze log.csv --set spin="400 rpm"',
)

KEY_NEARLY_KNOWN = _code(
    "G305",
    "warning",
    "a # key that is nearly one this tool knows",
    "# u_tme: 0.2 s\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

KEY_VALUE_CANNOT_BE_READ = _code(
    "G306",
    "error",
    "the value of a # line cannot be read",
    "# g: fast\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

KEY_GIVEN_TWICE = _code(
    "G307",
    "error",
    "a # key is given twice, with two values",
    "# g: 9.8 m/s^2\n# g: 9.9 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

REPORTED_VALUE_CANNOT_BE_READ = _code(
    "G308",
    "note",
    "a reported value that cannot be read as it stands",
    "# reported_inertia: 4.4e-3\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n",
)

DERIVED_COLUMN_DISAGREES = _code(
    "G401",
    "warning",
    "a derived column disagrees with the readings",
    "mass [g],position [cm],spin [rpm],time [s],turns,precession period [s]\n20.00,15.0,400,39.7,1,13.2\n",
)

SENSES_CONTRADICT_TORQUE = _code(
    "G402",
    "warning",
    "the senses written contradict the sign of the torque",
    "mass [g],position [cm],spin [rpm],time [s],turns,spin_sense,precession_sense\n20.00,15.0,400,39.7,1,ccw,cw\n",
)

SPIN_RISES = _code(
    "G403",
    "warning",
    "the spin rises during the interval",
    "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20.00,15.0,400,450,39.7,1\n",
)

GRAVITY_NOT_GIVEN = _code(
    "G404",
    "note",
    "no acceleration of free fall is given",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,400,39.7,1\n",
)

PRECESSION_FASTER_THAN_SPIN = _code(
    "G405",
    "warning",
    "the precession is faster than the spin",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,4,0.397,1\n",
)

OUTLIER = _code(
    "G410",
    "warning",
    "a run does not go with the others",
    G + LOG + "20.00,15.0,206,20.4,1\n"
    "20.00,15.0,407,40.4,1\n"
    "40.00,15.0,405,20.1,1\n"
    "40.00,15.0,607,30.1,2\n"
    "60.00,15.0,404,13.4,1\n"
    "60.00,15.0,603,20.0,1\n",
)

SCATTER_TOO_LARGE = _code(
    "G411",
    "warning",
    "the scatter is larger than the stated uncertainties allow",
    G + "# u_time: 0.01 s\n" + LOG + "20.00,15.0,206,20.9,1\n"
    "20.00,15.0,407,40.1,1\n"
    "40.00,15.0,405,20.5,1\n"
    "40.00,15.0,607,29.8,1\n"
    "60.00,15.0,404,13.7,1\n"
    "60.00,15.0,603,19.8,1\n",
)

BALANCE_TEST_CONTRADICTED = _code(
    "G412",
    "warning",
    "the data contradict the balance test in the log",
    G + "# u_imbalance: 0.00001 N*m\n" + LOG + "20.00,15.0,206,16.0,1\n"
    "20.00,15.0,407,31.6,1\n"
    "40.00,15.0,405,18.0,1\n"
    "40.00,15.0,607,27.0,1\n"
    "60.00,15.0,404,12.5,1\n"
    "60.00,15.0,603,18.6,1\n",
)

NO_TORQUE = _code(
    "G413",
    "error",
    "no run has a torque",
    "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n0,,400,160.2,1/3\n0,,600,240.3,1/3\n",
)

SINGLE_TORQUE = _code(
    "G414",
    "warning",
    "I_zz rests on a single torque",
    G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n",
)

NO_STEADY_PRECESSION = _code(
    "G415",
    "error",
    "no steady precession is possible at this tilt and spin",
    G + "# transverse_inertia: 0.02 kg*m^2\n"
    "mass [g],position [cm],spin [rpm],time [s],turns,pitch [deg]\n"
    "60.00,15.0,400,13.3,1,0\n"
    "60.00,15.0,600,19.9,1,0\n"
    "60.00,15.0,300,10.0,1,0\n"
    "60.00,15.0,20,2.5,1,60\n",
)

TOO_MANY_SHARED_READINGS = _code(
    "G416",
    "error",
    "too many shared readings for one fit",
    G + LOG + "".join(f"{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1\n" for k in range(2600)),
)

TRANSVERSE_INERTIA_NOT_GIVEN = _code(
    "G417",
    "warning",
    "the tilt matters, and the transverse moment of inertia is not given",
    G + "mass [g],position [cm],spin [rpm],time [s],turns,pitch [deg]\n"
    "60.00,15.0,150,4.71,1,60\n"
    "60.00,15.0,300,9.74,1,60\n"
    "40.00,15.0,150,7.23,1,60\n"
    "40.00,15.0,300,14.69,1,60\n",
)

RELEASE_NOT_TOLD = _code(
    "G418",
    "note",
    "the log does not say whether the rod was let go from rest, and that matters",
    G + "# u_time: 0.02 s\n"
    "# u_position_zero: 0.1 mm\n" + LOG + "60.00,15.0,200.0,6.62,1\n"
    "60.00,15.0,400.0,13.24,1\n"
    "120.0,15.0,200.0,3.31,1\n"
    "120.0,15.0,400.0,6.62,1\n",
)

RUNS_CONTRADICT_EACH_OTHER = _code(
    "G419",
    "warning",
    "the runs contradict each other beyond all measure",
    G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,80,1\n40.00,15.0,405,60,1\n",
)

TURNS_OF_WEIGHTS_WRONG = _code(
    "G420",
    "error",
    "the turns of whole weights are wrong",
    G + LOG + "20.00,15.0,206,6.76,1/3\n"
    "20.00,15.0,407,13.4,1/3\n"
    "40.00,15.0,405,13.3,1/3\n"
    "40.00,15.0,607,19.9,1/3\n"
    "60.00,15.0,404,13.2,1/3\n"
    "60.00,15.0,603,19.8,1/3\n",
)

NO_INERTIA_FITS = _code(
    "G421",
    "error",
    "no moment of inertia goes with the runs",
    G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,0.0404,1\n40.00,15.0,405,2010,1\n",
)

TOO_FEW_WEIGHTS = _code(
    "G451",
    "warning",
    "fewer than three weights",
    G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n20.00,15.0,605,60.1,1\n",
)

TOO_FEW_RUNS = _code(
    "G452",
    "warning",
    "fewer than three runs with a weight",
    "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,206,20.4,1\n",
)

SPINS_TOO_CLOSE = _code(
    "G453",
    "warning",
    "the spins of a weight are close together",
    G + LOG + "20.00,15.0,400,39.7,1\n20.00,15.0,410,40.7,1\n20.00,15.0,420,41.7,1\n",
)

NO_UNLOADED_RUN = _code(
    "G454",
    "warning",
    "no run without a weight",
    G + LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n20.00,15.0,605,60.1,1\n40.00,15.0,405,20.1,1\n",
)

TIMES_TOO_SHORT = _code(
    "G455",
    "warning",
    "times under 6 s",
    "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n60.00,15.0,206,2.26,1/3\n",
)

SPIN_FALLS_TOO_MUCH = _code(
    "G456",
    "warning",
    "the spin falls by more than 10 % in a run",
    G + "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20.00,15.0,400,330,36.0,1\n",
)

OUTLIER_BEFORE_LEAVING = _code(
    "G457",
    "warning",
    "a run does not go with the others",
    G + LOG + "20.00,15.0,206,20.4,1\n"
    "20.00,15.0,407,40.4,1\n"
    "40.00,15.0,405,20.1,1\n"
    "40.00,15.0,607,30.1,2\n"
    "60.00,15.0,404,13.4,1\n"
    "60.00,15.0,603,20.0,1\n",
)

OPTION_KEY_UNKNOWN = _code(
    "G501",
    "error",
    "--set or --config: there is no such key",
    "analyze log.csv --set trns=1",
)

MAPPED_HEADER_UNKNOWN = _code(
    "G502",
    "error",
    "--map: there is no such header",
    'analyze log.csv --map time="Zeitpunkt"',
)

MAPPED_ROLE_UNKNOWN = _code(
    "G503",
    "error",
    "--map: there is no such role",
    'analyze log.csv --map tme="time [s]"',
)

OPTION_VALUE_CANNOT_BE_READ = _code(
    "G504",
    "error",
    "--set or --config: the value cannot be read",
    "analyze log.csv --set g=fast",
)

CONFIG_CANNOT_BE_READ = _code(
    "G505",
    "error",
    "--config: the file cannot be read",
    "analyze log.csv --config no-such-file.toml",
)

TEMPLATE_VALUE_CANNOT_BE_READ = _code(
    "G506",
    "error",
    "template: a value cannot be read",
    "template --weights 20 --spins fast",
)

OPTION_IS_NO_PAIR = _code(
    "G601",
    "error",
    "an option is not of the form KEY=VALUE",
    "analyze log.csv --set turns",
)

FORMAT_FOR_ONE_LOG = _code(
    "G602",
    "error",
    "a form that is for one log",
    "analyze a.csv b.csv --format json",
)

REPORT_CANNOT_BE_WRITTEN = _code(
    "G603",
    "error",
    "the report cannot be written",
    "analyze log.csv --out /dev/null",
)

VALUES_NOT_FOR_FORMAT = _code(
    "G604",
    "error",
    "values are not words in this form",
    "analyze log.csv --format csv --values short",
)

CANNOT_BE_WATCHED = _code(
    "G605",
    "error",
    "what cannot be watched",
    "analyze a.csv b.csv --watch",
)

STREAM_CANNOT_BE_USED = _code(
    "G606",
    "error",
    "standard output or input cannot be used",
    "analyze log.csv > /dev/full",
)

OPTION_IS_NO_QUANTITY = _code(
    "G621",
    "error",
    "an option is not a number with a unit that fits",
    'predict tip --force 0.5N --length 20cm --inertia "4.44e-3 kg m^2" --spin 400',
)

OPTION_NUMBER_IMPOSSIBLE = _code(
    "G622",
    "error",
    "an option's number cannot be",
    'predict tip --force 0.5N --length 20cm --inertia "-4.44e-3 kg m^2" --spin 400rpm',
)

TORQUE_MISSING_OR_TWICE = _code(
    "G623",
    "error",
    "the torque is not given, or twice",
    'predict precession --inertia "4.44e-3 kg m^2" --spin 400rpm',
)

SIMULATED_VALUE_IMPOSSIBLE = _code(
    "G631",
    "error",
    "simulate: a value that cannot be",
    "simulate --pitch 90deg",
)

SIMULATED_WITHOUT_TORQUE = _code(
    "G632",
    "error",
    "simulate: a run without a torque",
    "simulate --weights 0g",
)

SIMULATED_NO_STEADY_PRECESSION = _code(
    "G633",
    "error",
    "simulate: no steady precession at this tilt and spin",
    'simulate --pitch 60deg --spins 50rpm --transverse "0.02 kg m^2"',
)

TURNS_NEVER_COMPLETED = _code(
    "G634",
    "error",
    "simulate: the turns are never completed",
    'simulate --spin-decay "1 s"',
)

SIMULATED_OPTIONS_CONTRADICT = _code(
    "G635",
    "error",
    "simulate: two options contradict each other",
    "simulate --motion horizontal --pitch 10deg",
)

NOISE_CANNOT_BE_READ = _code(
    "G636",
    "error",
    "simulate: the noise cannot be read",
    "simulate --noise no-such-file.toml",
)

TRUTH_CANNOT_BE_WRITTEN = _code(
    "G637",
    "error",
    "simulate: the truth cannot be written",
    "simulate --truth no-such-folder/truth.json",
)

CLASS_IS_NO_FOLDER_OR_ZIP = _code(
    "G701",
    "error",
    "the class is neither a folder nor a zip",
    "grade no-such-class",
)

ZIP_DAMAGED = _code(
    "G702",
    "error",
    "a zip that is damaged",
    "grade damaged.zip",
)

ZIP_NOT_SAFE = _code(
    "G703",
    "error",
    "a zip that is not safe to read",
    "grade evil.zip",
)

TOO_MANY_FILES = _code(
    "G704",
    "error",
    "too many files for a class",
    "grade million-files.zip",
)

NO_SUBMISSION = _code(
    "G705",
    "error",
    "no submission is found",
    "grade class --lms canvas",
)

PATTERN_CANNOT_BE_USED = _code(
    "G706",
    "error",
    "--pattern cannot be used",
    "grade class --pattern '(\\w+)_lab.csv'",
)

FILES_OF_NO_STUDENT = _code(
    "G707",
    "warning",
    "files of no student",
    "grade class, with a file of another kind of name",
)

ONE_OF_SEVERAL_GRADED = _code(
    "G708",
    "note",
    "one of several files or attempts is graded",
    "grade class, with two attempts",
)

GRADESCOPE_METADATA_CANNOT_BE_READ = _code(
    "G709",
    "warning",
    "Gradescope's metadata cannot be read",
    "grade class, with a broken metadata file",
)

ANSWERS_NO_TOML = _code(
    "G711",
    "warning",
    "an answers file that is no TOML",
    "answers.toml: inertia = 4.4e-3 ± 0.1e-3 kg m^2",
)

ANSWERS_CONTRADICT_LOG = _code(
    "G712",
    "warning",
    "log and answers file report two values",
    "answers.toml: inertia = '4.4 g m^2'",
)

SUBMITTED_FILE_CANNOT_BE_READ = _code(
    "G713",
    "error",
    "a submitted file cannot be read",
    "grade class, with a file that is cut off",
)

FILE_LEFT_OUT = _code(
    "G714",
    "warning",
    "a file or folder of the class is left out",
    "grade class, with a link",
)

ANSWER_NOT_ASKED_FOR = _code(
    "G715",
    "warning",
    "an answer under a name that is not asked for",
    "answers.toml: inertai = '4.4 g m^2'",
)

ANSWERS_CANNOT_BE_READ = _code(
    "G716",
    "warning",
    "an answers file that cannot be read",
    "answers.toml: a picture",
)

RUBRIC_NO_TOML = _code(
    "G721",
    "error",
    "a rubric is no TOML file",
    "schema = 1\npoints = \n",
)

RUBRIC_KEY_UNKNOWN = _code(
    "G722",
    "error",
    "a rubric has a key that is not known",
    "schema = 1\npoints = 2\n[[criterion]]\nid = 'log'\ncheck = 'log'\npoints = 2\nponits = 3\n",
)

RUBRIC_VALUE_CANNOT_BE_USED = _code(
    "G723",
    "error",
    "a value of a rubric is missing or cannot be used",
    "schema = 1\npoints = 2\n[[criterion]]\nid = 'log'\ncheck = 'log'\npoints = 'two'\n",
)

RUBRIC_POINTS_DO_NOT_ADD_UP = _code(
    "G724",
    "error",
    "the points of a rubric do not add up",
    "schema = 1\npoints = 3\n[[criterion]]\nid = 'log'\npoints = 2\ncheck = 'log'\n",
)

CRITERION_KIND_UNKNOWN = _code(
    "G725",
    "error",
    "a criterion is of a kind that is not known",
    "schema = 1\npoints = 2\n[[criterion]]\nid = 'log'\npoints = 2\ncheck = 'lgo'\n",
)

CONDITION_CANNOT_BE_USED = _code(
    "G726",
    "error",
    "a condition cannot be used",
    "schema = 1\n"
    "points = 2\n"
    "[[criterion]]\n"
    "id = 'log'\n"
    "points = 2\n"
    "check = 'log'\n"
    "full = 'warnings < 1'\n"
    "zero = 'warnings >= 4'\n",
)

RUBRIC_PARTS_CONTRADICT = _code(
    "G727",
    "error",
    "two parts of a rubric do not go together",
    "schema = 1\n"
    "points = 2\n"
    "[[criterion]]\n"
    "id = 'log'\n"
    "check = 'log'\n"
    "points = 2\n"
    "[reference]\n"
    "from = 'class'\n"
    "[reference.3]\n"
    "inertia = '4e-3 kg m^2'\n"
    "u = '1 %'\n",
)

PARTNERS_CANNOT_BE_READ = _code(
    "G741",
    "error",
    "the file of partners cannot be read",
    "grade class --partners no-such-file.csv",
)

PARTNER_UNKNOWN = _code(
    "G742",
    "warning",
    "a name in the file of partners is nobody in this class",
    "alice, bbo\n",
)

PARTNER_ALONE = _code(
    "G743",
    "warning",
    "a line of the file of partners names one student only",
    "alice\n",
)

GRADEBOOK_CANNOT_BE_READ = _code(
    "G751",
    "error",
    "a gradebook cannot be read",
    "grade class --gradebook picture.png",
)

NO_CANVAS_GRADEBOOK = _code(
    "G752",
    "error",
    "this is no Canvas gradebook",
    "grade class --gradebook grades.csv",
)

GRADEBOOK_COLUMN_NOT_CLEAR = _code(
    "G753",
    "error",
    "which column of the gradebook to fill is not clear",
    "grade class --gradebook two.csv",
)

GRADEBOOK_COLUMN_CANNOT_BE_FILLED = _code(
    "G754",
    "error",
    "the column of the gradebook cannot be filled",
    "grade class --gradebook locked.csv",
)

NO_MOODLE_WORKSHEET = _code(
    "G755",
    "error",
    "this is no Moodle grading worksheet",
    "grade class --worksheet grades.csv",
)

WORKSHEET_CANNOT_TAKE_POINTS = _code(
    "G756",
    "error",
    "the worksheet cannot take these points",
    "grade class --worksheet ten-points.csv",
)

NO_PROCESS_CAN_BE_STARTED = _code(
    "G761",
    "error",
    "no process can be started to work in",
    "grade class, with no process left",
)

JOURNAL_LINES_LOST = _code(
    "G762",
    "note",
    "lines of the journal cannot be read",
    "grade class, after a power cut",
)

GRADES_FOLDER_CANNOT_BE_WRITTEN = _code(
    "G763",
    "error",
    "the folder of the grades cannot be written",
    "grade class --out /dev/null",
)

NOTHING_TO_GRADE = _code(
    "G764",
    "error",
    "there is nothing to grade",
    "grade",
)

OPTION_FILE_CANNOT_BE_READ = _code(
    "G765",
    "error",
    "a file given with an option cannot be read",
    "grade class --rubric no-such-file.toml",
)

GRADES_WITHIN_CLASS = _code(
    "G766",
    "error",
    "the grades would be written into the class itself",
    "grade class --out class/grades",
)

OPTION_NEEDS_A_FOLDER = _code(
    "G767",
    "error",
    "an option needs a folder to write to",
    "grade class --format json --figures",
)

FAULT_OF_GYRO = _code(
    "G901",
    "error",
    "a fault of gyro itself",
    "no log should ever raise it",
)
