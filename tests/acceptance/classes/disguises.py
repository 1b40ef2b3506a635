"""Copies, and what is done to them so that nobody sees it."""

from collections.abc import Callable

import numpy as np
from grading.students_reports import Sheet
from msgspec.structs import replace

from classes.drawn import STATIONS, Student, draw, with_rows

Disguise = Callable[[np.random.Generator, Sheet, Sheet], Sheet]
"""From the one copied, and the copier's own, to what is handed in."""


def rows_of(rows: Sheet, which: np.ndarray | list[int]) -> Sheet:
    """Take some of the rows, in this order."""
    return Sheet(
        rows.mass[which],
        rows.position[which],
        rows.spin[which],
        rows.time[which],
        rows.turns[which],
    )


def _half(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    """Half of the rows; the rest is measured."""
    taken = np.zeros(len(rows.mass), dtype=bool)
    taken[random.permutation(len(taken))[: (len(taken) + 1) // 2]] = True
    return replace(
        own,
        spin=np.where(taken, rows.spin, own.spin),
        time=np.where(taken, rows.time, own.time),
    )


def _three_times(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    changed = np.zeros(len(rows.time))
    changed[random.permutation(len(changed))[:3]] = random.uniform(0.2, 0.5, 3)
    return replace(rows, time=rows.time + changed)


def _jitter(width: float) -> Disguise:
    return lambda random, rows, own: replace(
        rows, time=rows.time + random.uniform(-width, width, len(rows.time))
    )


JITTERED = {f"times by {width} s": _jitter(width) for width in (0.03, 0.1, 0.3)}
KNOWN: dict[str, Disguise] = {
    "exact": lambda random, rows, own: rows,
    "shuffled": lambda random, rows, own: rows_of(
        rows, random.permutation(len(rows.mass))
    ),
    "half the rows": _half,
    "three times": _three_times,
    "scaled": lambda random, rows, own: replace(
        rows, time=rows.time * random.choice([0.98, 1.02])
    ),
    "shifted": lambda random, rows, own: replace(
        rows, time=rows.time + random.choice([0.1, 0.2, 0.3])
    ),
}
DISGUISES = {**JITTERED, **KNOWN}


def plant(
    honest: list[Student], seed: int, each: int
) -> tuple[list[Student], dict[str, list[frozenset[str]]]]:
    """Add copiers to a class, so many of each disguise: all students, and the pairs by
    disguise.

    A copier works at the station of the one copied, and never are two copies made of
    one log."""
    students, pairs = list(honest), {kind: [] for kind in DISGUISES}
    for at, kind in enumerate(np.repeat(list(DISGUISES), each).tolist()):
        source = honest[at]
        number = STATIONS * (1000 + len(students)) + source.number % STATIONS
        random = np.random.default_rng([seed, 13, len(students)])
        # Whoever copies has measured something too, at the same station.
        own = draw(number, seed, source.bench)
        copier = with_rows(
            source, DISGUISES[kind](random, source.rows, own.rows), number
        )
        students.append(copier)
        pairs[kind].append(frozenset((source.key, copier.key)))
    return students, pairs
