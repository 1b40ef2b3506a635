"""Flag logs that nobody measured for this class.

They are simulated logs, and copies of the examples that are part of gyro.

`examples.json` contains the fingerprint of each example: the samples, the logs of the
README and of the pages of ``gyro explain``. ``python tests/make_examples.py`` writes it
anew. A log is compared with them row by row, as with the logs of earlier years, but by
itself: the examples are no honest class, and must not change what is usual in this one.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
from msgspec import Struct, json
from numpy.typing import NDArray

from gyrodata.grading.forensics import (
    ALLOWED,
    FEWEST,
    WIDTH,
    Fingerprint,
    Flag,
    Logs,
    Prints,
    lines_in_words,
    period_chances,
    rare_events,
)
from gyrodata.physics import Floats, Integers

CLASS = "sample_data/class/"
"""Beginning of the names of examples that are a class."""

# a class with so many logs of the sample class, and more than half of all, is the
# sample class
CLASS_SIZE = 5

MISSED = 0.02
"""Standard deviation of a spin around the one that is aimed at, as a share: two people
seldom meet the same one."""

EXACT = 1e-3  # probability of a value that has no last digit


class _Match(Struct, frozen=True, order=True):
    """A log with rows of an example."""

    p: float  # probability that an honest log has so many
    example: str
    student: str
    words: str  # which rows it has


def flag_examples(prints: Prints) -> tuple[Flag, ...]:
    """Flag each log of a class that is simulated, or has the rows of an example of gyro."""
    flags = []
    for student, one in sorted(prints.items()):
        if one.simulated:
            words = f"line {one.simulated} of its log says that it is simulated"
            flags.append(Flag("simulated", (student,), words, 0.0, 0.0))
    pairs = len(prints) * len(examples())
    found = [one for one in _matches(prints) if one.p * pairs <= ALLOWED]
    students = {one.student for one in found if one.example.startswith(CLASS)}
    if len(students) >= CLASS_SIZE and 2 * len(students) > len(prints):
        # Its logs may have rows of another example.
        found = [one for one in found if one.student not in students]
    for student in sorted({one.student for one in found}):
        some = [one for one in found if one.student == student]
        best = min(some)
        names = tuple(sorted({one.example for one in some}))
        expected = best.p * pairs
        flags.append(
            Flag("shared rows", (student,), best.words, best.p, expected, names)
        )
    return tuple(flags)


@cache
def examples() -> dict[str, Fingerprint]:
    """Read the fingerprints of the examples, by their names."""
    return json.decode(
        Path(__file__).with_suffix(".json").read_bytes(), type=dict[str, Fingerprint]
    )


def _matches(prints: Prints) -> Iterator[_Match]:
    """Compare each log with each example."""
    logs = Logs(prints, (), examples())
    for log in range(logs.current):
        match = logs.near(log)
        same = logs.same("spin", match.mine, match.other)
        same &= logs.log[match.other] >= logs.current
        if not same.any():
            continue
        turns = np.array(logs.prints[log].turns)[match.mine - match.rows[0]]
        away = turns * (logs.period[match.mine] - logs.period[match.other])
        steps = logs.period_step[match.mine], logs.period_step[match.other]
        step = turns * np.maximum(*steps)
        tails = rare_events(_row_chances(logs, match.rows))
        for at in np.unique(match.at[same]).tolist():
            pairs = same & (match.at == at)
            # All times of a copy may be changed by the same amount.
            for shift in (0.0, float(np.median(away[pairs]))):
                near = pairs & (np.abs(away - shift) <= 0.5 * step + 1e-6)
                has = match.have(near)[at]
                if has.sum() < max(FEWEST, len(has) / 2):
                    continue
                # Any of the rows may be the one that the others are compared with.
                p = len(has) * tails[has.sum() - 1] if shift else tails[has.sum()]
                example = logs.keys[match.others[at]]
                words = _words(logs, log, has, example, bool(shift))
                yield _Match(float(p), example, logs.keys[log], words)


def _words(
    logs: Logs, log: int, has: NDArray[np.bool_], example: str, is_shifted: bool
) -> str:
    """Describe the rows of an example in a log."""
    times = "the same precession period"
    if is_shifted:
        times = "times that differ by the same amount"
    return (
        f"{has.sum()} of {len(has)} rows of {logs.keys[log]} "
        f"({lines_in_words(logs.prints[log], has)}) are in {example}, an example of "
        f"gyro, with the same torque and the same spin and {times}"
    )


def _row_chances(logs: Logs, rows: Integers) -> Floats:
    """Return the probability that another log has the rows of a log, shape (n,)."""
    return _spin_chances(logs, rows) * _period_chances(logs, rows)


def _period_chances(logs: Logs, rows: Integers) -> Floats:
    """Return the probability that another log has the periods of rows, shape (n,)."""
    return np.where(logs.period_step[rows] > 0, period_chances(logs, rows), EXACT)


def _spin_chances(logs: Logs, rows: Integers) -> Floats:
    """Return the probability that another log has the spins of rows, shape (n,).

    Round spins do not count, because many students aim at them.
    """
    width = WIDTH * MISSED * logs.spin[rows]
    step = logs.spin_step[rows]
    chance = np.where(step > 0, np.minimum(step / width, 1.0), EXACT)
    return np.where(logs.useful[rows], chance, 1.0)
