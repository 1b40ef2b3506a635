"""The codes and severities of all diagnostics. `diagnostics.toml` explains each code.

gyro prints the code, such as G454, so that users can search for it; a code never
changes. `messages.toml` contains the messages, each with its code.
"""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Literal

from msgspec import Struct, convert

Severity = Literal["error", "warning", "note"]


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
    """Read the texts about each code.

    Only ``explain``, ``schema`` and Gradescope's feedback need them.
    """
    texts = tomllib.loads(
        Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
    )
    # This example needs more runs than a file of texts should contain.
    runs = (
        f"{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1\n" for k in range(2600)
    )
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


_MESSAGES = Path(__file__).with_name("messages.toml").read_text(encoding="utf-8")


@cache
def message(name: str) -> Message:
    """Read one message without the rest of the file.

    To read the whole file takes a twentieth of the time of a run without figures.
    """
    section = _MESSAGES.partition(f"\n[{name}]\n")[2].partition("\n[")[0]
    return convert(tomllib.loads(section), Message)


@cache
def severities() -> dict[str, Severity]:
    """List the severity of every code, in the order of the codes."""
    named = {
        code: severity
        for severity, code in re.findall(
            r'^code = "(\w+) (\w+)"', _MESSAGES, re.MULTILINE
        )
    }
    return convert(
        dict(sorted({**dict.fromkeys(MADE_OF_PARTS, "error"), **named}.items())),
        dict[str, Severity],
    )


# Codes that the package compares with others.
COMPRESSED_FILE_DAMAGED, CODE_PAGE_GUESSED = "G107", "G109"
CELL_IS_NO_NUMBER, CELL_BECAME_A_DATE, UNIT_UNKNOWN, UNIT_MISSING = (
    "G203",
    "G204",
    "G205",
    "G206",
)
PER_SECOND_IS_AMBIGUOUS, NUMBER_IMPOSSIBLE = "G208", "G215"
VALUE_BELOW_ITS_FIRST_ROW, NOTE_MAY_CHANGE_READING = "G219", "G240"
DIGITS_TOO_FEW, OUTLIER, SINGLE_TORQUE, SIZE_NOT_USUAL = "G407", "G410", "G414", "G444"
TOO_FEW_RUNS, SPINS_TOO_CLOSE, NO_UNLOADED_RUN = "G452", "G453", "G454"
NOISE_CANNOT_BE_READ, ANSWER_ELSEWHERE = "G636", "G717"
(
    RUBRIC_NO_TOML,
    RUBRIC_KEY_UNKNOWN,
    RUBRIC_VALUE_CANNOT_BE_USED,
    CRITERION_KIND_UNKNOWN,
) = "G721", "G722", "G723", "G725"
MADE_OF_PARTS = (
    CELL_BECAME_A_DATE,
    PER_SECOND_IS_AMBIGUOUS,
    NUMBER_IMPOSSIBLE,
    RUBRIC_NO_TOML,
    CRITERION_KIND_UNKNOWN,
)
"""Codes of errors that `messages.toml` does not contain, because their messages are
made of parts."""
