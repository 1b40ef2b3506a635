"""The messages of all rooms, and what `gyro explain` shows about their codes.

Each room has its messages in a file `messages.toml`. A message is one record, with its
code, such as G454. gyro prints the code, so that users can search for it; a code never
changes. If several messages have the same code, the first of them explains it.
"""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Literal

from msgspec import Struct, convert
from msgspec.structs import replace

Severity = Literal["error", "warning", "note"]

HEADER = "mass [g],position [cm],spin [rpm],time [s],turns"
"""The header of most examples."""


class Message(Struct, frozen=True, forbid_unknown_fields=True):
    """One message; names in braces are values that are filled in.

    Python's `str.format` fills them in: "{time:.1f}" is the value `time` as 20.4.
    """

    code: str
    severity: Severity = "error"
    text: str = ""
    """What happened; "" if the text is made of parts, in the code."""
    hint: str = ""
    """What to do."""
    doubt: str = ""
    """Kind of doubt if the answer is not safe to quote: "ball", "size", …; else ""."""
    title: str = ""
    """What gyro found, as a statement; "" if another message explains it."""
    meaning: str = ""
    """What the text and the title do not say: a cause, or how much I_zz changes.
    Numbers are those of the sample log with this one change, or of the example."""
    example: str = ""
    """A short log that raises the code, or a command after ``gyro``. {header} stands
    for `HEADER`."""
    remedy: str = ""
    """What to do, the most common cause first; lines that begin with two blanks are
    text to copy. "" if it is the hint."""


_FILES = sorted(Path(__file__).parents[1].glob("*/messages.toml"))

_TEXTS = "\n".join(path.read_text(encoding="utf-8") for path in _FILES)


@cache
def message(name: str) -> Message:
    """Read one message without the others.

    To read all of them takes a twentieth of the time of a run without figures. So the
    text of the record is cut out first: it is between its head, a line ``[name]`` below
    an empty line, and the next head.
    """
    _, _, from_record = _TEXTS.partition(f"\n\n[{name}]\n")
    record, _, _ = from_record.partition("\n\n[")
    return convert(tomllib.loads(record), Message)


@cache
def messages() -> dict[str, Message]:
    """Read all messages, by name."""
    return convert(tomllib.loads(_TEXTS), dict[str, Message])


@cache
def explanations() -> dict[str, Message]:
    """Return the message that explains each code, in the order of the codes."""
    explained = {}
    for message in messages().values():
        if message.title:
            example = message.example.replace("{header}", HEADER)
            hint = f"{message.hint[:1].upper()}{message.hint[1:]}\n"
            remedy = message.remedy or hint
            explained[message.code] = replace(message, example=example, remedy=remedy)
    return dict(sorted(explained.items()))


# Codes that the package compares with others.
CELL_IS_NO_NUMBER = "G203"
CELL_BECAME_A_DATE = "G204"
UNIT_UNKNOWN = "G205"
UNIT_MISSING = "G206"
PER_SECOND_IS_AMBIGUOUS = "G208"
NUMBER_IMPOSSIBLE = "G215"
VALUE_BELOW_ITS_FIRST_ROW = "G219"
NOTE_MAY_CHANGE_READING = "G240"
REMARK = "G305"
OUTLIER = "G410"
ANSWER_ELSEWHERE = "G717"
