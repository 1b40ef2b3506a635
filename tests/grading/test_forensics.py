"""Copied, edited and invented logs are flagged with their evidence; honest ones hardly ever are."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from grading.students import RPM, Course, Row, honest_class, print_of, prints_of, text, with_times
from msgspec.structs import replace

from gyrodata.grading import Fingerprint, Flag, flag_class
from gyrodata.grading.forensics import ALLOWED, KINDS

COURSE = Course()
CONVERTED = "Zeit [s];Spin [rad/s];turns;position [mm];mass [kg]"


@pytest.fixture(scope="module")
def logs() -> dict[str, list[Row]]:
    return honest_class(np.random.default_rng(1), COURSE, 100)


@pytest.fixture(scope="module")
def prints(logs: dict[str, list[Row]]) -> dict[str, Fingerprint]:
    return prints_of(logs)


def changed(rows: list[Row], which: tuple[int, ...]) -> list[Row]:
    """Give other times and spins to some rows."""
    return [
        (m, x, f"{float(spin) + 9:.0f}", f"{1.03 * float(time):.2f}", turns)
        if i in which
        else (m, x, spin, time, turns)
        for i, (m, x, spin, time, turns) in enumerate(rows)
    ]


def shuffled(rows: list[Row]) -> list[Row]:
    return [rows[i] for i in np.random.default_rng(3).permutation(len(rows))]


def converted(rows: list[Row]) -> str:
    """The same table in other units, rounded on the way, with its columns in another order."""
    lines = [
        f"{time};{float(spin) * RPM:.2f};{turns};{10 * float(x):.0f};{float(m) / 1000:.3f}"
        for m, x, spin, time, turns in rows
    ]
    return "# g: 9.803 m/s^2\n" + "\n".join([CONVERTED, *lines]) + "\n"


def as_periods(rows: list[Row]) -> str:
    """Spin periods, and the periods of precession worked out."""
    parts = {"1/3": 1 / 3, "2/3": 2 / 3, "1": 1.0}
    lines = [f"{m},{x},{60 / float(s):.4f},{float(t) / parts[f]:.2f}" for m, x, s, t, f in rows]
    return "# g: 9.803 m/s^2\nmass [g],position [cm],spin period [s],precession period [s]\n" + "\n".join(lines) + "\n"


def flags_with(prints: dict[str, Fingerprint], log: str, student: str = "zz") -> tuple[Flag, ...]:
    return flag_class({**prints, student: print_of(log)})


COPIES: dict[str, Callable[[list[Row]], str]] = {
    "reordered, in other units, three rows changed": lambda rows: converted(shuffled(changed(rows, (1, 3, 8)))),
    "periods worked out": lambda rows: as_periods(shuffled(rows)),
    "rounded to tenths": lambda rows: text(with_times(rows, lambda time: time, 1)),
    "four rows only": lambda rows: text([rows[i] for i in (1, 3, 5, 8)]),
}
"""More disguises are cells of the simulated classes."""


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_is_found(how: str, logs: dict[str, list[Row]], prints: dict[str, Fingerprint]) -> None:
    flags = flags_with(prints, COPIES[how](logs["s00002"]))
    assert [(flag.kind, flag.students) for flag in flags] == [("shared rows", ("s00002", "zz"))]
    assert flags[0].p <= flags[0].expected <= ALLOWED


def test_five_copies_of_one_log_are_one_flag(logs: dict[str, list[Row]], prints: dict[str, Fingerprint]) -> None:
    ring = {f"z{i}": print_of(text(changed(logs["s00009"], (i, i + 1)))) for i in range(4)}
    flags = flag_class({**prints, **ring})
    assert [(flag.kind, flag.students) for flag in flags] == [("shared rows", ("s00009", "z0", "z1", "z2", "z3"))]
    assert "and 7 more like these" in flags[0].evidence


def test_partners_are_not_flagged(logs: dict[str, list[Row]], prints: dict[str, Fingerprint]) -> None:
    copied = {**prints, "zz": print_of(text(shuffled(logs["s00004"])))}
    assert flag_class(copied, [frozenset({"s00004", "zz", "s00005"})]) == ()
    assert flag_class(copied, [frozenset({"s00004", "nobody"}), frozenset({"zz", "s00004"})]) == ()
    assert len(flag_class(copied, [frozenset({"s00004", "s00005"})])) == 1


def test_a_third_who_copies_from_partners_is_found(logs: dict[str, list[Row]], prints: dict[str, Fingerprint]) -> None:
    copied = {**prints, "y": print_of(text(logs["s00004"])), "zz": print_of(text(shuffled(logs["s00004"])))}
    flags = flag_class(copied, [frozenset({"s00004", "y"})])
    assert [flag.students for flag in flags] == [("s00004", "y", "zz")]
    assert "s00004 (lines 3, 4, 5, 6, 7, 8, 9, 10, 11) are in y" not in flags[0].evidence


def test_last_years_logs_are_compared_but_not_with_each_other(
    logs: dict[str, list[Row]], prints: dict[str, Fingerprint]
) -> None:
    old = {"2023/anna": print_of(text(logs["s00001"])), "2022/ben": print_of(text(logs["s00001"]))}
    few = {student: prints[student] for student in list(prints)[:20]}
    flags = flag_class(few, previous=old)
    assert [(flag.kind, flag.students, flag.previous) for flag in flags] == [
        ("shared rows", ("s00001",), ("2022/ben", "2023/anna"))
    ]
    without = {student: one for student, one in few.items() if student != "s00001"}
    assert flag_class(without, previous=old) == ()


def test_evidence_names_rows(logs: dict[str, list[Row]], prints: dict[str, Fingerprint]) -> None:
    rows = shuffled(with_times(changed(logs["s00002"], (0, 4, 8)), lambda time: time, 1))
    few = {student: prints[student] for student in list(prints)[:40]}
    (flag,) = flags_with(few, text(rows), "mallory")
    assert flag.evidence == (
        "6 of 9 rows of mallory (lines 3, 5, 6, 8, 9, 10) are in s00002 (lines 4, 5, 6, 8, 9, 10), with the same spin "
        "and the same precession period, in another order, not typed to the same digit"
    )


ODD = (
    "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,400,13.1,1/3\n",
    "mass [g],position [cm],spin [rpm],time [s],turns\n" + "20,15,400,13,1/3\n" * 40,
    "mass [g],position [cm],time [s],turns\n# spin: 400 rpm\n"
    + "".join(f"{m},15,{260 / m:.2f},1\n" for m in range(10, 60)),
    "mass [g],position [cm],spin [rpm],time [s],turns\n0,,400,160.2,1/3\n0,,500,200.2,1/3\n0,,600,240.3,1/3\n",
    "mass [g],position [cm],spin [rpm],time [s],turns\n"
    + "".join(f"20,-15,{400 + i / 7!r},{39 + i / 11!r},1\n" for i in range(9)),
    "torque [N*m],spin_period [s],angle [deg],time [s]\n"
    + "".join(f"{0.01 * i},0.1,{60 * i},0:{10 + i}.5\n" for i in range(1, 9)),
)


@pytest.mark.parametrize("others", [0, 30])
def test_odd_designs_are_no_trouble(others: int, prints: dict[str, Fingerprint]) -> None:
    class_ = {student: prints[student] for student in list(prints)[:others]}
    odd = {f"z{i}{twice}": print_of(log) for i, log in enumerate(ODD) for twice in "ab"}
    for flag in flag_class(class_ | odd, previous={"old": print_of(ODD[1])}):
        assert 0 < flag.p <= 1
        assert 0 < flag.expected <= ALLOWED
        assert all(student.startswith("z") for student in flag.students)


CLASSES = {
    "as in a course": COURSE,
    "one station, spins hit exactly, good hands": replace(COURSE, stations=1, missed=0.0, hand=(0.05, 0.08)),
    "three repeats with one reading of the spin": replace(COURSE, repeats=3, same_spin=True, missed=2.0),
    "tenths of a second": replace(COURSE, decimals=1, missed=0.0),
    "a bend that all share": replace(COURSE, bend=0.05, missed=0.0, stations=1),
}


@pytest.mark.parametrize("name", CLASSES)
def test_honest_classes_get_no_more_flags_than_stated(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # With 40 times as many allowed, a few classes tell what a hundred would.
    allowed, classes = 2.0, 3
    for module in ("copies", "flags"):
        monkeypatch.setattr(f"gyrodata.grading.forensics.{module}.ALLOWED", allowed)
    counts: Counter[str] = Counter()
    for seed in range(classes):
        flags = flag_class(prints_of(honest_class(np.random.default_rng([11, seed]), CLASSES[name], 60)))
        assert all(flag.expected <= allowed for flag in flags)
        counts.update(flag.kind for flag in flags)
        assert not any(flag.expected <= ALLOWED for flag in flags)
    # Four standard deviations of a count.
    assert all(counts[kind] <= allowed * classes + 4 * math.sqrt(allowed * classes) for kind in KINDS)
    assert sum(counts.values()) <= allowed * classes * 2


def test_times_worked_out_from_the_formula_scatter_too_little(prints: dict[str, Fingerprint]) -> None:
    rows = [
        (
            f"{m}",
            "15.0",
            f"{spin}",
            f"{2 * math.pi / 3 * n * 4.44e-3 * spin * RPM / (m * 1e-3 * 9.803 * 0.15):.2f}",
            f"{n}/3",
        )
        for m, n in ((20, 1), (40, 2), (60, 3))
        for spin in (207, 411, 598)
    ]
    flags = flags_with(prints, text(rows))
    assert [(flag.kind, flag.students) for flag in flags] == [("scatter", ("zz",))]


def test_published_and_sample_logs_are_not_flagged() -> None:
    samples = sorted((Path(__file__).parents[2] / "sample_data").glob("*.csv"))
    assert len(samples) > 2
    assert flag_class({path.stem: print_of(path.read_text(encoding="utf-8")) for path in samples}) == ()
