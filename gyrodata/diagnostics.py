"""The codes and severities of all diagnostics. `diagnostics.toml` explains each code.

gyro prints the code, such as G454, so that users can search for it; a code never changes. `messages.toml` contains the
messages about a log, each with its code; other messages use the names below.
"""

from __future__ import annotations

import tomllib
from functools import cache, partial
from pathlib import Path
from typing import Literal

from msgspec import Struct, convert

Severity = Literal["error", "warning", "note"]

SEVERITIES: dict[str, Severity] = {}
"""Severity of each code with a name below."""


class Code(Struct, frozen=True):
    """The texts about a diagnostic code."""

    title: str
    """A statement: what gyro found."""
    example: str
    """A short log that raises the code, or a command after ``gyro``."""
    remedy: str
    """What to do."""
    means: str = ""
    """What the title says, in more words."""
    why: str = ""
    """How large the effect on I_zz or its uncertainty is."""


@cache
def explanations() -> dict[str, Code]:
    """Read the texts about each code. Only ``explain``, ``schema`` and Gradescope's feedback need them."""
    texts = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    # This example needs more runs than a file of texts should contain.
    runs = (f"{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1\n" for k in range(2600))
    texts["G416"]["example"] += "".join(runs)
    return convert(texts, dict[str, Code])


class Message(Struct, frozen=True):
    """One message of `messages.toml`; names in braces are values that are filled in."""

    code: str
    """Severity and code: "warning G410"."""
    message: str
    hint: str = ""
    doubt: str = ""
    """Kind of doubt if the answer is not safe to quote: "ball", "size", …; else ""."""


@cache
def messages() -> dict[str, Message]:
    """Read the messages about logs, by name."""
    text = Path(__file__).with_name("messages.toml").read_text(encoding="utf-8")
    return convert(tomllib.loads(text), dict[str, Message])


@cache
def severities() -> dict[str, Severity]:
    """List the severity of every code, in the order of the codes."""
    of_logs = {one.code.split()[1]: one.code.split()[0] for one in messages().values()}
    return convert(dict(sorted({**SEVERITIES, **of_logs}.items())), dict[str, Severity])


def _code(severity: Severity, code: str) -> str:
    """Add a code to `SEVERITIES` and return it."""
    SEVERITIES[code] = severity
    return code


_error, _warning, _note = (partial(_code, severity) for severity in ("error", "warning", "note"))

# the file
COMPRESSED_FILE_DAMAGED = _error("G107")
CODE_PAGE_GUESSED = _note("G109")

# the table
CELL_IS_NO_NUMBER = _error("G203")
CELL_BECAME_A_DATE = _error("G204")
UNIT_UNKNOWN = _error("G205")
UNIT_MISSING = _error("G206")
PER_SECOND_IS_AMBIGUOUS = _error("G208")
NUMBER_IMPOSSIBLE = _error("G215")
VALUE_BELOW_ITS_FIRST_ROW = _error("G219")
NOTE_MAY_CHANGE_READING = _warning("G240")

# options that go with a log
TEMPLATE_VALUE_CANNOT_BE_READ = _error("G506")

# options of a command
OPTION_IS_NO_PAIR = _error("G601")
FORMAT_FOR_ONE_LOG = _error("G602")
REPORT_CANNOT_BE_WRITTEN = _error("G603")
OPTION_NOT_FOR_FORMAT = _error("G604")
CANNOT_BE_WATCHED = _error("G605")
STREAM_CANNOT_BE_USED = _error("G606")
EXPLAINED_CODE_UNKNOWN = _error("G607")
HAND_IN_AS_IT_IS = _error("G608")
FOLDER_IN_USE = _error("G609")
COMMAND_LINE_WRONG = _error("G610")

# gyro predict
OPTION_IS_NO_QUANTITY = _error("G621")
OPTION_NUMBER_IMPOSSIBLE = _error("G622")

# gyro simulate
SIMULATED_VALUE_IMPOSSIBLE = _error("G631")
SIMULATED_WITHOUT_TORQUE = _error("G632")
SIMULATED_NO_STEADY_PRECESSION = _error("G633")
TURNS_NEVER_COMPLETED = _error("G634")
NOISE_CANNOT_BE_READ = _error("G636")
OUT_IS_NO_FOLDER = _error("G638")
FIXED_LOG_CANNOT_BE_WRITTEN = _error("G639")

# a class
NO_SUBMISSION = _error("G705")
ANSWER_ELSEWHERE = _note("G717")
ANSWER_READ = _note("G718")
ANSWER_MISSING = _warning("G719")

# a rubric
RUBRIC_NO_TOML = _error("G721")
RUBRIC_KEY_UNKNOWN = _error("G722")
RUBRIC_VALUE_CANNOT_BE_USED = _error("G723")
CRITERION_KIND_UNKNOWN = _error("G725")

# the roster
ROSTER_CANNOT_BE_READ = _error("G744")
EXCEPTION_FOR_NOBODY = _warning("G745")

# the gradebook
GRADEBOOK_CANNOT_BE_READ = _error("G751")
NO_CANVAS_GRADEBOOK = _error("G752")
GRADEBOOK_COLUMN_NOT_CLEAR = _error("G753")
GRADEBOOK_COLUMN_CANNOT_BE_FILLED = _error("G754")
NO_MOODLE_WORKSHEET = _error("G755")
WORKSHEET_CANNOT_TAKE_POINTS = _error("G756")
NO_BLACKBOARD_GRADE_CENTER = _error("G757")

# the run of a class
JOURNAL_LINES_LOST = _note("G762")
GRADES_FOLDER_CANNOT_BE_WRITTEN = _error("G763")
NOTHING_TO_GRADE = _error("G764")
OPTION_FILE_CANNOT_BE_READ = _error("G765")
GRADES_WITHIN_CLASS = _error("G766")
OPTION_NEEDS_A_FOLDER = _error("G767")
AUTOGRADER_CANNOT_BE_MADE = _error("G768")
CLUSTER_CANNOT_BE_USED = _error("G769")

# the desk
DESK_CANNOT_BE_READ = _error("G771")
DESK_STUDENT_UNKNOWN = _error("G772")
DESK_LINE_CANNOT_BE_USED = _error("G773")
DESK_LINES_CONTRADICT = _error("G774")
DESK_NAME_SHARED = _error("G775")
LOG_CONTRADICTS_RIGHT_ANSWER = _warning("G776")

# of a log, for grading and the report
DIGITS_TOO_FEW = "G407"
OUTLIER = "G410"
SINGLE_TORQUE = "G414"
SIZE_NOT_USUAL = "G444"
TOO_FEW_RUNS = "G452"
SPINS_TOO_CLOSE = "G453"
NO_UNLOADED_RUN = "G454"

# gyro itself
FAULT_OF_GYRO = _error("G901")
