"""Copies, and what is done to them so that nobody sees it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from grading.reports import Sheet
from msgspec.structs import replace

from classes.drawn import STATIONS, Student, draw, with_rows

Disguise = Callable[[np.random.Generator, Sheet, Sheet], Sheet]
"""From the one copied, and the copier's own, to what is handed in."""


def _some(rows: Sheet, which: np.ndarray) -> Sheet:
    return Sheet(rows.mass[which], rows.position[which], rows.spin[which], rows.time[which], rows.turns[which])


def _half(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    """Half of the rows, the rest measured."""
    taken = np.zeros(len(rows.mass), dtype=bool)
    taken[random.permutation(len(taken))[: (len(taken) + 1) // 2]] = True
    return replace(own, spin=np.where(taken, rows.spin, own.spin), time=np.where(taken, rows.time, own.time))


def _three_times(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    changed = np.zeros(len(rows.time))
    changed[random.permutation(len(changed))[:3]] = random.uniform(0.2, 0.5, 3)
    return replace(rows, time=rows.time + changed)


def _jitter(width: float) -> Disguise:
    def change(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
        return replace(rows, time=rows.time + random.uniform(-width, width, len(rows.time)))

    return change


def _scaled(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    return replace(rows, time=rows.time * random.choice([0.98, 1.02]))


def _shifted(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    return replace(rows, time=rows.time + random.choice([0.1, 0.2, 0.3]))


def _both(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    """Spins and times each by up to 1 %."""
    n = len(rows.time)
    spin = np.round(rows.spin * (1 + random.uniform(-0.01, 0.01, n)))
    return replace(rows, spin=spin, time=rows.time * (1 + random.uniform(-0.01, 0.01, n)))


def _mean(random: np.random.Generator, rows: Sheet, own: Sheet) -> Sheet:
    """The mean of another's rows and one's own."""
    return replace(rows, spin=np.round((rows.spin + own.spin) / 2), time=(rows.time + own.time) / 2)


JITTERED = {f"times by {width} s": _jitter(width) for width in (0.03, 0.1, 0.3)}
KNOWN: dict[str, Disguise] = {
    "exact": lambda random, rows, own: rows,
    "shuffled": lambda random, rows, own: _some(rows, random.permutation(len(rows.mass))),
    "half the rows": _half,
    "three times": _three_times,
    "scaled": _scaled,
    "shifted": _shifted,
}
HARD: dict[str, Disguise] = {"both columns by 1 %": _both, "mean of two": _mean}
DISGUISES = {**JITTERED, **KNOWN, **HARD}


def plant(honest: list[Student], seed: int, each: int) -> tuple[list[Student], dict[str, list[frozenset[str]]]]:
    """Add copiers to a class, so many of each disguise: all students, and the pairs by disguise.

    A copier sits at the station of the one copied, and never are two copies made of one log.
    """
    students, pairs = list(honest), {}
    for kind, change in DISGUISES.items():
        pairs[kind] = []
        for _ in range(each):
            source = honest[len(students) - len(honest)]
            number = STATIONS * (1000 + len(students)) + source.number % STATIONS
            random = np.random.default_rng([seed, 13, len(students)])
            # Whoever copies has measured something too, at the same station.
            own = draw(number, seed, source.bench)
            copier = with_rows(source, change(random, source.rows, own.rows), number)
            students.append(copier)
            pairs[kind].append(frozenset((source.key, copier.key)))
    return students, pairs
