"""The table: what each cell measures, and its bound. Classes of students, from drawing
to what is told of them.
"""

import itertools
import json
import math
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from grading.classes import make_folder
from grading.students_reports import reported_line
from msgspec import Struct
from msgspec.structs import replace
from typer.testing import CliRunner, Result

from classes import typed
from classes.disguises import JITTERED, KNOWN, plant
from classes.drawn import FITS, ROUTES, STATIONS, USUAL, Student, by_route, draw
from gyrodata.cli import app

OTHERWISE = 0.5
"""Points of the arithmetic (of 6) that steps of three digits, or a right fit that is
none of the accepted, may cost."""


class Number(Struct, frozen=True):
    """What was measured, out of how many, and its bounds."""

    value: int
    of: int
    low: float = -math.inf
    high: float = math.inf
    told: str = ""

    @property
    def holds(self) -> bool:
        return self.low <= self.value <= self.high

    @property
    def bound(self) -> str:
        return (
            f"<= {self.high:.0f}" if math.isfinite(self.high) else f">= {self.low:.0f}"
        )


Cell = Callable[[int, int], Number]
"""From the size of a class and a seed."""


def gyro(*arguments: str | Path) -> Result:
    """Run the command line; a traceback is raised."""
    done = CliRunner().invoke(
        app, [str(argument) for argument in arguments], prog_name="gyro"
    )
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def grade(files: Mapping[str, str | bytes], *arguments: str | Path) -> dict[str, Any]:
    """Grade a class of these files: the document of the grades, its students by key."""
    with tempfile.TemporaryDirectory() as folder:
        root = make_folder(Path(folder) / "class", files)
        done = gyro(
            "grade", root, "--format", "json", "--workers", "0", "--quiet", *arguments
        )
    assert done.exit_code <= 1, done.output
    document: dict[str, Any] = json.loads(done.stdout)
    document["students"] = {
        student["student"]: student for student in document["students"]
    }
    return document


def canvas(logs: Mapping[Student, str]) -> typed.Files:
    """Name the log of each student as Canvas does."""
    return {f"{student.stem}_lab.csv": log for student, log in logs.items()}


def with_answer(students: list[Student]) -> typed.Files:
    return canvas({one: one.log(reported_line(*one.answer())) for one in students})


def counted(counts: Mapping[str, int]) -> str:
    return ", ".join(
        f"{count} {what}" for what, count in Counter(counts).most_common() if count
    )


# --- honest classes ---


def careful(size: int, seed: int) -> dict[Student, str]:
    """A: told the format, one of three fits of the textbook."""
    students = [draw(i, seed) for i in range(size)]
    return {
        one: one.log("# g: 9.803 m/s^2", reported_line(*one.answer(fit=FITS[i % 3])))
        for i, one in enumerate(students)
    }


def any_route(size: int, seed: int) -> dict[Student, str]:
    """B: any right route, g, unit, steps, and idea of u."""
    logs = {}
    for i, student in enumerate(draw(i, seed + 1) for i in range(size)):
        random = np.random.default_rng([seed, 17, i])
        value, u = by_route(
            student, ROUTES[i % len(ROUTES)], random.choice([9.8, 9.81]), i % 2 == 0
        )
        u = random.choice([u, u, 1.5 * u, 0.01 * value])
        answer = typed.in_unit(
            value,
            u,
            list(typed.UNITS)[i // 7 % len(typed.UNITS)],
            random.choice([1, 2]),
        )
        logs[student] = student.log(f"# reported_inertia: {answer}")
    return logs


BENCHES = {
    "0.3 s hand": replace(USUAL, hand=0.3),
    "wobble": replace(USUAL, wobble=0.02),
    "5 % imbalance": replace(USUAL, imbalance=0.05),
    "six runs": replace(USUAL, spins=(200, 500)),
}


def other_benches(size: int, seed: int) -> dict[Student, str]:
    """G: right work at benches that are not the usual one, each at stations of its own."""
    benches = list(itertools.islice(itertools.cycle(BENCHES.values()), STATIONS))
    students = [draw(i, seed + 2, benches[i % STATIONS]) for i in range(size)]
    return {
        one: one.log(reported_line(*one.answer(fit=FITS[i % 3])))
        for i, one in enumerate(students)
    }


HONEST = {
    "A careful": careful,
    "B any right route": any_route,
    "G other benches": other_benches,
}
LOSSES = ("unjust loss", "loss for the bench's scatter", "slips or flags")


def lost(student: Mapping[str, Any]) -> dict[str, float]:
    """Points that a student did not get, by criterion; those that nobody judged are
    left out.
    """
    marks = [mark for mark in student["marks"] if mark.get("points") is not None]
    return {mark["criterion"]: mark["out_of"] - mark["points"] for mark in marks}


def judge(
    students: list[Student], document: Mapping[str, Any]
) -> tuple[Number, Number, Number]:
    """Count the `LOSSES` of a class of right work."""
    unjust, other, rough = Counter[str](), Counter[str](), Counter[str]()
    bench_names = {bench: name for name, bench in BENCHES.items()}
    flagged = {key for flag in document["flags"] for key in flag["students"]}
    accused = 0
    for student in students:
        got = document["students"][student.key]
        points = lost(got)
        needed = (
            ("log", "units")
            if len(student.rows.mass) < 9
            else ("log", "procedure", "units")
        )
        unfair = [what for what in needed if points.get(what, 0) > 0]
        unfair += ["inertia"] * (points.get("inertia", 0) > OTHERWISE)
        if got["status"] != "graded" or unfair:
            unjust[
                " and ".join(unfair) if got["status"] == "graded" else "not graded"
            ] += 1
        other.update(
            what
            for what in ("inertia", "reference", "uncertainty")
            if points.get(what, 0) > 0.005
        )
        rough.update(
            [bench_names.get(student.bench, "usual")]
            * (points.get("constancy", 0) > 0.005)
        )
        accused += bool(got["slips"]) or student.key in flagged
    size = len(students)
    words = f"{counted(unjust)}; any loss: {counted(other)}"
    return (
        Number(unjust.total(), size, high=0, told=words),
        # One in a thousand has such a scatter by chance.
        Number(rough.total(), size, high=max(1, size // 100), told=counted(rough)),
        Number(accused, size, high=0),
    )


@cache
def honest(name: str, size: int, seed: int) -> tuple[Number, Number, Number]:
    logs = HONEST[name](size, seed)
    return judge(list(logs), grade(canvas(logs)))


# --- copies ---


@cache
def searched(
    size: int, seed: int, step: float
) -> tuple[Mapping[str, list[frozenset[str]]], list[frozenset[str]]]:
    """D: a class with a tachometer read to so many rpm, with copies: the pairs by
    disguise, and what is flagged.
    """
    students, pairs = plant(
        [draw(i, seed + 5, replace(USUAL, rpm_step=step)) for i in range(size)],
        seed,
        max(1, size // 25),
    )
    return pairs, [
        frozenset(flag["students"]) for flag in grade(with_answer(students))["flags"]
    ]


def copied(kinds: Mapping[str, object], least: float, size: int, seed: int) -> Number:
    """Count the copies found of some disguises; least [1]."""
    both = [searched(size, seed, step) for step in (1, 5)]
    found = {
        kind: sum(
            any(p <= f for f in flags) for pairs, flags in both for p in pairs[kind]
        )
        for kind in kinds
    }
    of = sum(len(pairs[kind]) for pairs, _ in both for kind in kinds)
    return Number(
        sum(found.values()), of, low=math.ceil(least * of - 1e-9), told=counted(found)
    )


def false_beside(size: int, seed: int) -> Number:
    """Count the flags that name somebody beside a pair of whom one did copy."""
    false = 0
    for pairs, flags in (searched(size, seed, step) for step in (1, 5)):
        planted = {pair for kind in pairs.values() for pair in kind}
        false += sum(not any(flag <= pair for pair in planted) for flag in flags)
    return Number(false, 2 * size, high=0)


def false_pairs(size: int, seed: int) -> Number:
    """Count the flags of five times as many honest logs."""
    flags = grade(
        with_answer(
            [
                draw(i, seed + 6, replace(USUAL, rpm_step=(5, 1, 1, 10)[i // 10 % 4]))
                for i in range(5 * size)
            ]
        )
    )["flags"]
    return Number(
        len(flags),
        5 * size,
        high=0,
        told=counted(Counter(flag["kind"] for flag in flags)),
    )


# --- the table ---


CELLS: dict[str, Cell] = {
    **{
        f"{name}: {what}": lambda size, seed, name=name, at=at: honest(
            name, size, seed
        )[at]
        for name in HONEST
        for at, what in enumerate(LOSSES)
    },
    "D every time changed: found": partial(copied, JITTERED, 40 / 48),
    "D other copies: found": partial(copied, KNOWN, 1.0),
    "D beside copies: false flags": false_beside,
    "D honest: false flags": false_pairs,
}
"""In the order of the table."""
