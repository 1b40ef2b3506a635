"""Flag logs that nobody measured for this class.

They are simulated logs, and copies of the examples that are part of gyro.

`examples.json` contains the fingerprint of each example: the samples, the logs of the
README and of the pages of ``gyro explain``. ``python tests/make_examples.py`` writes it
anew. A log is compared with them row by row, as with the logs of earlier years, but by
itself: the examples are no honest class, and must not change what is usual in this one.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache
from pathlib import Path

import numpy as np
from msgspec import Struct, json
from numpy.typing import NDArray

from gyrodata.grading.forensics import (
    ALLOWED,
    FEWEST,
    HAND,
    ROUND,
    SAME_TORQUE,
    Fingerprint,
    Flag,
    Prints,
    measure_scatter,
)
from gyrodata.grading.yardsticks import grouped
from gyrodata.physics import Floats, Integers

CLASS = "sample_data/class/"
"""Beginning of the names of examples that are a class."""

# a class with so many logs of the sample class, and more than half of all, is the
# sample class
CLASS_SIZE = 5

MISSED = 0.02
"""Standard deviation of a spin around the one that is aimed at, as a share: two people
seldom meet the same one."""


SAME_TIMES = " and the same precession period"
MOVED_TIMES = " and times that differ by the same amount"


class _Match(Struct, frozen=True):
    """A log with rows of an example."""

    example: str
    lines: tuple[int, ...]  # of the log, with a row of the example
    rows: int  # number of rows of the log
    p: float  # probability that an honest log has so many
    times: str  # in words, what the times have in common


def flag_examples(prints: Prints) -> tuple[Flag, ...]:
    """Flag each log of a class that is simulated, or has the rows of an example of gyro."""
    flags = [
        Flag(
            "simulated",
            (student,),
            f"line {one.simulated} of its log says that it is simulated",
            0.0,
            0.0,
        )
        for student, one in sorted(prints.items())
        if one.simulated
    ]
    pairs = len(prints) * len(examples())
    found = [
        (student, one)
        for student in sorted(prints)
        for one in _matches(prints[student])
    ]
    likely = [(student, one) for student, one in found if one.p * pairs <= ALLOWED]
    students = {student for student, one in likely if one.example.startswith(CLASS)}
    if len(students) >= CLASS_SIZE and 2 * len(students) > len(prints):
        # Its logs may have rows of another example.
        likely = [(student, one) for student, one in likely if student not in students]
    for student, some in grouped(likely).items():
        best = min(some, key=lambda one: (one.p, one.example))
        told = (
            f"{len(best.lines)} of {best.rows} rows of {student} (lines "
            f"{', '.join(map(str, best.lines))}) are in"
        )
        told += f" {best.example}, an example of gyro, with the same torque"
        told += " and the same spin"
        told += best.times
        names = tuple(sorted({one.example for one in some}))
        flags.append(
            Flag("shared rows", (student,), told, best.p, best.p * pairs, names)
        )
    return tuple(flags)


@cache
def examples() -> dict[str, Fingerprint]:
    """Read the fingerprints of the examples, by their names."""
    return json.decode(
        Path(__file__).with_suffix(".json").read_bytes(), type=dict[str, Fingerprint]
    )


class _Rows(Struct, frozen=True):
    """The n rows of one log, or of all examples."""

    log: Integers  # number of the log of each row, shape (n,)
    torque: Floats  # [N*m], shape (n,), without a sign
    spin: Floats  # [rad/s], shape (n,)
    spin_step: Floats  # [rad/s], shape (n,)
    period: Floats  # [s], shape (n,)
    period_step: Floats  # [s], shape (n,)


def _rows(*logs: Fingerprint) -> _Rows:
    def joined(name: str) -> Floats:
        return np.array(
            [value for log in logs for value in getattr(log, name)], dtype=float
        )

    turns = joined("turns")
    return _Rows(
        log=np.repeat(np.arange(len(logs)), [len(log.time) for log in logs]),
        torque=np.abs(joined("torque")),
        spin=joined("spin"),
        spin_step=joined("spin_step"),
        period=joined("time") / turns,
        period_step=joined("time_step") / turns,
    )


@cache
def _example_rows() -> _Rows:
    return _rows(*examples().values())


@lru_cache(maxsize=100)
def _matches(log: Fingerprint) -> tuple[_Match, ...]:
    """Compare a log with each example; a class may have many equal logs."""
    mine, theirs = _rows(log), _example_rows()
    torques = np.maximum.outer(mine.torque, theirs.torque)
    same = (
        np.abs(np.subtract.outer(mine.torque, theirs.torque)) <= SAME_TORQUE * torques
    )
    same &= _alike(mine.spin, theirs.spin, mine.spin_step, theirs.spin_step)
    if not same.any():
        return ()
    away = np.subtract.outer(mine.period, theirs.period)
    step = np.maximum.outer(mine.period_step, theirs.period_step)
    turns = np.array(log.turns)[:, None]
    chances = _spin_chances(mine) * _period_chances(log, mine)
    found = []
    for number, name in enumerate(examples()):
        rows = theirs.log == number
        # All times of a copy may be changed by the same amount.
        late = (away * turns)[:, rows][same[:, rows]]
        shift = float(np.median(late)) if late.size else 0.0
        for by, words in ((0.0, SAME_TIMES), (shift, MOVED_TIMES)):
            left = np.abs(away - by / turns) - 1e-9 * mine.period[:, None]
            shared = (same & (left <= 0.5 * step))[:, rows]
            found += _match(name, log, shared, chances, words)
    return tuple(found)


def _match(
    name: str,
    log: Fingerprint,
    same: NDArray[np.bool_],
    chances: Floats,
    times: str,
) -> list[_Match]:
    """Return the match of a log with an example, if half of its rows have one of it.

    `same`: Whether a row of the log is one of the example, shape (n, m).
    """
    shared = same.any(axis=1)
    if shared.sum() < max(FEWEST, len(chances) / 2):
        return []
    lines = tuple(sorted(np.array(log.lines)[shared].tolist()))
    # Any of the rows may be the one that the others are compared with.
    free = times == MOVED_TIMES
    p = _tail(chances, int(shared.sum()) - free) * (len(chances) if free else 1)
    return [_Match(name, lines, len(chances), p, times)]


def _alike(
    one: Floats, other: Floats, step: Floats, other_step: Floats
) -> NDArray[np.bool_]:
    """Return which values are the same to the last digit of the coarser one, shape (n, m)."""
    coarser = np.maximum.outer(step, other_step)
    return np.abs(np.subtract.outer(one, other)) <= 0.5 * coarser + 1e-9 * one[:, None]


_WIDTH = math.sqrt(4 * math.pi)
"""No interval of this width contains more of a normal distribution [sigma]."""


def _period_chances(log: Fingerprint, rows: _Rows) -> Floats:
    """Return the probability that another log has the period of a row, shape (n,)."""
    noise = max(measure_scatter(log)[1], HAND * log.by_hand) / np.array(log.turns)
    period = rows.period_step / np.maximum(_WIDTH * noise, rows.period_step)
    return np.where(rows.period_step > 0, period, 1e-3)


def _spin_chances(rows: _Rows) -> Floats:
    """Return the probability that another log has the spin of a row, shape (n,)."""
    is_round = (
        np.abs(rows.spin - ROUND * np.round(rows.spin / ROUND))
        <= 0.5 * rows.spin_step + 1e-9 * rows.spin
    )
    spin = np.where(
        is_round, 1.0, np.minimum(rows.spin_step / (_WIDTH * MISSED * rows.spin), 1.0)
    )
    return np.where(rows.spin_step > 0, spin, 1e-3)


def _tail(chances: Floats, least: int) -> float:
    """Return the probability that this many of independent events occur, or more."""
    numbers = np.eye(1, len(chances) + 1)[0]
    for chance in chances.tolist():
        numbers[1:] = (1 - chance) * numbers[1:] + chance * numbers[:-1]
        numbers[0] *= 1 - chance
    return float(numbers[least:].sum())
