"""The table: what each cell measures, and what must hold. Classes of students, from drawing to what is told of them."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
from grading.reports import reported_line
from msgspec import Struct
from msgspec.structs import replace

from classes import cost, desk, rubrics, typed
from classes.disguises import HARD, JITTERED, KNOWN, plant
from classes.drawn import FITS, ROUTES, STATIONS, USUAL, Bench, Student, by_route, draw
from classes.graded import Number, grade, lost, total
from classes.planted import PLANTED, named, pick, told

OTHERWISE = 0.5
"""Points of the arithmetic (of 6) that steps of three digits, or a right fit that is none of the accepted, may cost."""


class Cell(Struct, frozen=True):
    """One line of the table."""

    name: str
    measure: Callable[[int, int], Number]
    """From the size of a class and a seed."""


def canvas(logs: Mapping[Student, str]) -> typed.Files:
    """Name the log of each student as Canvas does."""
    return {f"{student.stem}_lab.csv": log for student, log in logs.items()}


def counted(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {what}" for what, count in counts.most_common() if count)


# --- honest classes -----------------------------------------------------------------------------------------


class Class(Struct, frozen=True):
    """A class of right work, graded."""

    students: tuple[Student, ...]
    document: Mapping[str, Any]

    def of(self, student: Student) -> Mapping[str, Any]:
        """What one got."""
        found: Mapping[str, Any] = self.document["students"][student.key]
        return found

    def unjust(self) -> Counter[str]:
        """Count who lost something that right work does not lose, by what it was, each once."""
        counts: Counter[str] = Counter()
        for student in self.students:
            got = self.of(student)
            points = lost(got)
            # A log with fewer runs than are asked for lacks something, and has not learnt much of its scatter.
            short = {"procedure"} if len(student.rows.mass) < 9 else set()
            unfair = [what for what in ("log", "procedure", "units") if points.get(what, 0) > 0 and what not in short]
            if points.get("inertia", 0) > OTHERWISE:
                unfair.append("inertia")
            if got["status"] != "graded":
                counts["not graded"] += 1
            elif unfair:
                counts[" and ".join(unfair)] += 1
        return counts

    def losers(self, criterion: str) -> int:
        """How many lost points of a criterion."""
        return sum(lost(self.of(student)).get(criterion, 0) > 0.005 for student in self.students)

    def accused(self) -> int:
        """How many have a slip or are in a flag."""
        flagged = {key for flag in self.document["flags"] for key in flag["students"]}
        return sum(bool(self.of(student)["slips"]) or student.key in flagged for student in self.students)


@cache
def careful(size: int, seed: int) -> Class:
    """A: told the format, one of three fits of the textbook."""
    students = tuple(draw(i, seed) for i in range(size))
    logs = {
        one: one.log("# g: 9.803 m/s^2", reported_line(*one.answer(fit=FITS[i % 3]))) for i, one in enumerate(students)
    }
    return Class(students, grade(canvas(logs)))


@cache
def any_route(size: int, seed: int) -> Class:
    """B: any right route, g, unit, steps, and idea of u."""
    students = tuple(draw(i, seed + 1) for i in range(size))
    logs = {}
    for i, student in enumerate(students):
        random = np.random.default_rng([seed, 17, i])
        value, u = by_route(student, list(ROUTES)[i % len(ROUTES)], random.choice([9.8, 9.81]), i % 2 == 0)
        u = random.choice([u, u, 1.5 * u, 0.01 * value])
        answer = typed.in_unit(value, u, list(typed.UNITS)[i // 7 % len(typed.UNITS)], random.choice([1, 2]))
        logs[student] = student.log(f"# reported_inertia: {answer}")
    return Class(students, grade(canvas(logs)))


BENCHES = {
    "0.3 s hand": replace(USUAL, hand=0.3),
    "whole seconds": replace(USUAL, decimals=0, thirds=False),
    "wobble": replace(USUAL, wobble=0.02),
    "10 rpm": replace(USUAL, rpm_step=10),
    "5 % imbalance": replace(USUAL, imbalance=0.05),
    "six runs": replace(USUAL, spins=(200, 500)),
}


@cache
def other_benches(size: int, seed: int) -> Class:
    """G: right work at benches that are not the usual one, each at stations of its own."""
    benches = list(itertools.islice(itertools.cycle(BENCHES.values()), STATIONS))
    students = tuple(draw(i, seed + 2, benches[i % STATIONS]) for i in range(size))
    logs = {one: one.log(reported_line(*one.answer(fit=FITS[i % 3]))) for i, one in enumerate(students)}
    return Class(students, grade(canvas(logs)))


def honest(name: str, make: Callable[[int, int], Class]) -> list[Cell]:
    """Make the cells of a class of right work."""

    def unjust(size: int, seed: int) -> Number:
        counts = make(size, seed).unjust()
        others = {what: make(size, seed).losers(what) for what in ("inertia", "reference", "uncertainty", "constancy")}
        words = [counted(counts), f"any loss: {counted(Counter(others))}" if any(others.values()) else ""]
        return Number(counts.total(), high=0, of=size, told="; ".join(filter(None, words)))

    def constancy(size: int, seed: int) -> Number:
        made = make(size, seed)
        where = Counter(
            next((bench for bench, one in BENCHES.items() if one == student.bench), "usual")
            for student in made.students
            if lost(made.of(student)).get("constancy", 0) > 0.005
        )
        # One in a thousand has such a scatter by chance.
        return Number(made.losers("constancy"), high=max(1, size // 100), of=size, told=counted(where))

    return [
        Cell(f"{name}: unjust loss", unjust),
        Cell(f"{name}: loss for the bench's scatter", constancy),
        Cell(f"{name}: slips or flags", lambda size, seed: Number(make(size, seed).accused(), high=0, of=size)),
    ]


# --- how the value is typed, and where ----------------------------------------------------------------------


def written(size: int, seed: int) -> Number:
    """F: the line is there; the value in it is typed as people type."""
    students = [draw(i, seed + 3) for i in range(size)]
    ways = list(typed.WAYS)
    answers = {one: one.answer(fit=FITS[i % 3]) for i, one in enumerate(students)}
    plain = {one: one.log(f"# reported_inertia: {typed.plain(*answers[one])}") for one in students}
    natural = {
        one: one.log(f"# reported_inertia: {typed.WAYS[ways[i % len(ways)]](*answers[one])}")
        for i, one in enumerate(students)
    }
    before, after = (grade(canvas(logs))["students"] for logs in (plain, natural))
    unread, losing = Counter[str](), Counter[str]()
    for i, student in enumerate(students):
        way = ways[i % len(ways)]
        if after[student.key]["status"] != "graded":
            unread[way] += 1
        # Another digit or two of u moves the other criteria by less.
        elif total(after[student.key]) < total(before[student.key]) - 0.1:
            losing[way] += 1
    words = f"not graded {unread.total()}: {counted(unread)}; losing {losing.total()}: {counted(losing)}"
    return Number(unread.total() + losing.total(), high=0, of=size, told=words)


def anywhere(size: int, seed: int) -> Number:
    """C: told no format."""
    each = max(1, size // len(typed.HABITS))
    habits = [habit for habit in typed.HABITS for _ in range(each)]
    classes: dict[str, dict[str, typed.Files]] = {"canvas": {}, "moodle": {}, "blackboard": {}}
    answers = {}
    for i, habit in enumerate(habits):
        student = draw(i, seed + 4)
        value, u = student.answer(fit=FITS[i % 3])
        lms = {"Moodle text": "moodle", "Blackboard field": "blackboard"}.get(habit, "canvas")
        name = {"canvas": typed.as_canvas, "moodle": typed.as_moodle, "blackboard": typed.as_blackboard}[lms]
        key = f"s{student.key}" if lms == "blackboard" else student.key
        classes[lms][key] = name(student, typed.HABITS[habit](student, typed.plain(value, u)))
        answers[key] = habit, value
    unread, wrong = Counter[str](), Counter[str]()
    for people in classes.values():
        files = {name: data for one in people.values() for name, data in one.items()}
        students = grade(files)["students"]
        for key in people:
            habit, value = answers[key]
            got = students[key]["reported"].get("value") if key in students else None
            if key not in students or students[key]["status"] != "graded":
                unread[habit] += 1
            elif got is None or not math.isclose(got, value, rel_tol=0.01):
                wrong[habit] += 1
    words = f"not graded: {counted(unread)}" + (f"; read wrongly: {counted(wrong)}" if wrong else "")
    return Number(unread.total() + len(habits) * wrong.total(), high=each, of=len(habits), told=words)


# --- copies -------------------------------------------------------------------------------------------------


class Search(Struct, frozen=True):
    """What was found in a class of whom some copied."""

    pairs: Mapping[str, list[frozenset[str]]]
    flags: tuple[frozenset[str], ...]

    def found(self, kind: str) -> int:
        return sum(any(pair <= flag for flag in self.flags) for pair in self.pairs[kind])

    @property
    def false(self) -> int:
        """Flags that name somebody beside a pair of whom one did copy."""
        planted = {pair for pairs in self.pairs.values() for pair in pairs}
        return sum(not any(flag <= pair for pair in planted) for flag in self.flags)


def with_answer(students: list[Student]) -> typed.Files:
    return canvas({one: one.log(reported_line(*one.answer())) for one in students})


@cache
def searched(size: int, seed: int, step: float) -> Search:
    """D and D5: a class with a tachometer read to so many rpm, with copies."""
    honest_ones = [draw(i, seed + 5, replace(USUAL, rpm_step=step)) for i in range(size)]
    students, pairs = plant(honest_ones, seed, max(1, size // 25))
    flags = grade(with_answer(students))["flags"]
    return Search(pairs, tuple(frozenset(flag["students"]) for flag in flags))


def copied(kinds: Mapping[str, object], least: float | None) -> Callable[[int, int], Number]:
    """Count the copies found of some disguises; least [1]."""

    def measure(size: int, seed: int) -> Number:
        both = [searched(size, seed, step) for step in (1, 5)]
        parts = {kind: [one.found(kind) for one in both] for kind in kinds}
        of = sum(len(one.pairs[kind]) for one in both for kind in kinds)
        words = ", ".join(f"{kind} {one} + {other}" for kind, (one, other) in parts.items())
        low = -math.inf if least is None else math.ceil(least * of - 1e-9)
        return Number(sum(map(sum, parts.values())), low=low, of=of, told=f"{words} (rpm to 1 + to 5)")

    return measure


def false_beside(size: int, seed: int) -> Number:
    """Count the false flags in the classes with copies."""
    return Number(sum(searched(size, seed, step).false for step in (1, 5)), high=0, of=2 * size)


def habits_of_spins(number: int) -> Bench:
    """One in twenty writes the spins aimed at, one in five reads to 5 rpm, one in ten to 10, the rest to 1."""
    if number % 20 == 7:
        return replace(USUAL, nominal=True)
    return replace(USUAL, rpm_step={0: 5, 3: 5, 6: 10}.get(number // 10 % 10, 1))


def false_pairs(size: int, seed: int) -> Number:
    """Count the flags of five times as many honest logs."""
    students = [draw(i, seed + 6, habits_of_spins(i)) for i in range(5 * size)]
    flags = grade(with_answer(students))["flags"]
    return Number(len(flags), high=0, of=5 * size, told=counted(Counter(flag["kind"] for flag in flags)))


# --- slips --------------------------------------------------------------------------------------------------


@cache
def slipped(size: int, seed: int) -> tuple[tuple[str, Mapping[str, Any]], ...]:
    """Plant slips in a class: the kind and what was told of each."""
    each = max(1, round(6 * size / 200))
    kinds = pick(max(20, size // 2), each)
    students = [draw(i, seed + 7) for i in range(len(kinds))]
    names = list(PLANTED)
    logs = {
        one: PLANTED[names[kind]][0](one) if kind >= 0 else one.log(reported_line(*one.answer()))
        for one, kind in zip(students, kinds.tolist(), strict=True)
    }
    found = grade(canvas(logs))["students"]
    return tuple((names[kind], found[one.key]) for one, kind in zip(students, kinds.tolist(), strict=True) if kind >= 0)


def slips_right(size: int, seed: int) -> Number:
    """Count the kinds that are named right in every log."""
    right = dict.fromkeys(PLANTED, True)
    for kind, student in slipped(size, seed):
        right[kind] &= named(kind, student)
    missing = ", ".join(kind for kind, all_of_them in right.items() if not all_of_them)
    return Number(sum(right.values()), low=17, of=len(PLANTED), told=f"not: {missing}" if missing else "")


def slips_wrong(size: int, seed: int) -> Number:
    """Count the logs in which slips are named and none of them is the one."""
    wrong = [(kind, student) for kind, student in slipped(size, seed) if told(student) and not named(kind, student)]
    words = Counter(f"{kind} as {' or '.join(slip['kind'] for slip in one['slips'])}" for kind, one in wrong)
    return Number(len(wrong), high=0, of=len(slipped(size, seed)), told=counted(words))


# --- the table ----------------------------------------------------------------------------------------------


def cells() -> list[Cell]:
    """All of them, in the order of the table."""
    return [
        *honest("A careful", careful),
        *honest("B any right route", any_route),
        *honest("G other benches", other_benches),
        Cell("F typed in 12 ways: not graded or losing", written),
        Cell("C told no format: not graded", anywhere),
        Cell("D every time changed: found", copied(JITTERED, 40 / 48)),
        Cell("D other copies: found", copied(KNOWN, 1.0)),
        Cell("D both columns, mean of two: found", copied(HARD, None)),
        Cell("D beside copies: false flags", false_beside),
        Cell("D honest, nominal spins too: false flags", false_pairs),
        Cell("slips: kinds named right", slips_right),
        Cell("slips: logs named wrongly", slips_wrong),
        *(Cell(f"desk: {name}", measure) for name, measure in desk.CELLS.items()),
        Cell("rubric in ten lines: points right", rubrics.ordinary),
        Cell("other bytes for other workers, kills, journals", cost.same_bytes),
    ]
