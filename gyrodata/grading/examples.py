"""Logs that nobody measured for this class: simulated ones, and the examples of gyro.

`examples.json` contains the fingerprint of each example: the samples, the logs of the
README and of the pages of ``gyro explain``; a value that is the same in all rows of a
log is there once. ``python tests/make_examples.py`` writes it anew. A class is compared
with them as with the logs of earlier years.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from msgspec import convert, json

from gyrodata.grading.forensics import NOTHING, Fingerprint, Flag, Prints

# a class with so many of the examples, and more than half of all, is the sample class
CLASS_SIZE = 5

OF_ROWS = ("turns", "spin_step", "time_step")
"""Fields of a fingerprint that may be the same in all rows of a log."""


@cache
def examples() -> dict[str, Fingerprint]:
    """Read the fingerprints of the examples, by their names."""
    stored: dict[str, dict[str, Any]] = json.decode(
        Path(__file__).with_suffix(".json").read_bytes()
    )
    for fields in stored.values():
        count = len(fields["lines"])
        for name in OF_ROWS:
            if not isinstance(fields[name], list):
                fields[name] = [fields[name]] * count
    return convert(stored, dict[str, Fingerprint])


def examples_for(prints: Prints) -> Prints:
    """Return the examples that a class is compared with: none for the sample class."""
    known = {fingerprint.sha256 for fingerprint in examples().values()}
    count = sum(fingerprint.sha256 in known for fingerprint in prints.values())
    if count >= CLASS_SIZE and 2 * count > len(prints):
        return NOTHING
    return examples()


def flag_simulated(prints: Prints) -> list[Flag]:
    """Flag each log that says that it is simulated."""
    flags = []
    for student, fingerprint in prints.items():
        if fingerprint.simulated:
            words = f"line {fingerprint.simulated} of its log says that it is simulated"
            flags.append(Flag("simulated", (student,), words, 0.0, 0.0))
    return flags
