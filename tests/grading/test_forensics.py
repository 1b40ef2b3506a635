"""Copied, edited and invented logs are flagged with their evidence; honest ones hardly
ever are.
"""

import tracemalloc

import numpy as np
import pytest
from classes.disguises import rows_of
from classes.drawn import USUAL, Student, draw, with_rows
from msgspec.structs import replace
from scipy import stats
from simulated_labs import INERTIA, RPM, G

from gyrodata.grading.forensics import Fingerprint, fingerprint, flag_class
from gyrodata.measurements import measure
from gyrodata.readings import read_log

ALLOWED = 0.05
"""Flags of one kind that an honest class gets by chance, at most."""
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
CONVERTED = "Zeit [s];Spin [rad/s];turns;position [mm];mass [kg]\n"

Prints = dict[str, Fingerprint]


def print_of(log: str) -> Fingerprint:
    readings = read_log(log.encode(), name="log.csv")
    assert readings.ok, readings.diagnostics
    return fingerprint(readings, measure(readings))


@pytest.fixture(scope="module")
def logs() -> dict[str, Student]:
    students = [draw(i, 1) for i in range(100)]
    return {one.key: one for one in students}


@pytest.fixture(scope="module")
def prints(logs: dict[str, Student]) -> Prints:
    return {key: print_of(one.log()) for key, one in logs.items()}


def some(student: Student) -> Student:
    """Take the rows in another order."""
    which = np.random.default_rng(3).permutation(9).tolist()
    return with_rows(student, rows_of(student.rows, which), student.number)


def changed(student: Student, *which: int) -> Student:
    """Give other times and spins to some rows."""
    spin, time = student.rows.spin.copy(), student.rows.time.copy()
    spin[list(which)] += 9
    time[list(which)] *= 1.03
    return with_rows(
        student, replace(student.rows, spin=spin, time=time), student.number
    )


def in_tenths(student: Student) -> Student:
    return with_rows(
        replace(student, bench=replace(USUAL, decimals=1)), student.rows, student.number
    )


def converted(student: Student) -> str:
    """The same table in other units, rounded on the way, with its columns in another
    order.
    """
    rows = (
        (t, float(s) * RPM, f, 10 * float(x), float(m) / 1000)
        for m, x, s, t, f in student.cells()
    )
    return CONVERTED + "".join(
        f"{t};{s:.2f};{f};{x:.0f};{m:.3f}\n" for t, s, f, x, m in rows
    )


@pytest.mark.slow
def test_copy_in_other_units_and_order_is_found(
    logs: dict[str, Student], prints: Prints
) -> None:
    """More disguises are cells of the simulated classes."""
    (flag,) = flag_class(
        {**prints, "zz": print_of(converted(some(changed(logs["1002"], 1, 3, 8))))}
    )
    assert (flag.kind, flag.students) == ("shared rows", ("1002", "zz"))
    assert flag.p <= flag.expected <= ALLOWED


@pytest.mark.slow
def test_partners_are_not_flagged_but_a_third_who_copies(
    logs: dict[str, Student], prints: Prints
) -> None:
    copied = {**prints, "zz": print_of(some(logs["1004"]).log())}
    assert flag_class(copied, [frozenset({"1004", "zz", "1005"})]) == ()
    assert len(flag_class(copied, [frozenset({"1004", "1005"})])) == 1
    (flag,) = flag_class(
        {**copied, "y": print_of(logs["1004"].log())}, [frozenset({"1004", "y"})]
    )
    assert flag.students == ("1004", "y", "zz")


def test_old_logs_are_compared_but_not_with_each_other(
    logs: dict[str, Student], prints: Prints
) -> None:
    old = {
        "2023/anna": print_of(logs["1001"].log()),
        "2022/ben": print_of(logs["1001"].log()),
    }
    (flag,) = flag_class(dict(list(prints.items())[:20]), previous=old)
    assert (flag.kind, flag.students, flag.previous) == (
        "shared rows",
        ("1001",),
        ("2022/ben", "2023/anna"),
    )
    assert (
        flag_class(
            {key: one for key, one in prints.items() if key != "1001"}, previous=old
        )
        == ()
    )


@pytest.mark.slow
def test_hundreds_of_equal_logs_are_one_flag_in_little_memory(
    logs: dict[str, Student], prints: Prints
) -> None:
    """Pair by pair they would be 5,000, and many megabytes."""
    copy = print_of(logs["1004"].log())
    others = {key: one for key, one in prints.items() if key != "1004"}
    copies = {f"c{number:04}": copy for number in range(100)}
    tracemalloc.start()
    flags = flag_class({**others, **copies}, [frozenset(copies)])
    assert flags == (), "all of them are partners"
    (flag,) = flag_class({**others, **copies}, previous={"2023/anna": copy})
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (flag.students, flag.previous) == (tuple(copies), ("2023/anna",))
    assert flag.evidence.endswith(f"; and {101 * 100 // 2 - 3} more like these")
    assert peak < 6e6


@pytest.mark.slow
def test_copies_are_joined_but_for_partners(
    logs: dict[str, Student], prints: Prints
) -> None:
    """Three copies of a log, two of them by partners, and a log with some of its rows:
    one flag of five pairs.
    """
    copy, part = (
        print_of(logs["1004"].log()),
        print_of(changed(logs["1004"], 2, 5).log()),
    )
    named = {"c0": copy, "c1": copy, "part": part}
    partners = [frozenset({"c0", "c1"})]
    (flag,) = flag_class({**prints, **named}, partners)
    assert (flag.kind, flag.students) == ("shared rows", ("1004", "c0", "c1", "part"))
    assert flag.evidence.endswith("; and 2 more like these")
    apart = {key: one for key, one in prints.items() if key != "1004"} | {
        "c0": copy,
        "c1": copy,
    }
    assert flag_class(apart, partners) == ()
    assert [one.students for one in flag_class(apart)] == [("c0", "c1")]


def noisy(student: Student, factors: np.ndarray, key: str) -> dict[str, Fingerprint]:
    """A copy with every mass, position, spin and time changed by its own factor."""
    rows = student.rows
    changed_rows = replace(
        rows,
        mass=np.round(factors[0] * rows.mass, 1),
        position=np.round(factors[1] * rows.position, 1),
        spin=np.round(factors[2] * rows.spin),
        time=factors[3] * rows.time,
    )
    return {key: print_of(with_rows(student, changed_rows, student.number).log())}


@pytest.mark.slow
def test_copy_with_every_number_changed_by_1_percent(
    logs: dict[str, Student], prints: Prints
) -> None:
    random, found = np.random.default_rng(4), 0
    for one in list(logs.values())[:16]:
        copy = noisy(one, random.uniform(0.99, 1.01, (4, 9)), "zz")
        flags = flag_class({**prints, **copy})
        found += [(flag.kind, set(flag.students)) for flag in flags] == [
            ("similar spins", {one.key, "zz"})
        ]
    assert found >= 11


@pytest.mark.slow
def test_copies_with_noise_of_1_percent_in_a_class_of_38() -> None:
    random = np.random.default_rng(6)
    shares = []
    for seed in range(6):
        honest = [draw(i, seed) for i in range(26)]
        prints = {one.key: print_of(one.log()) for one in honest}
        pairs = []
        for one in honest[:12]:
            factors = 1 + 0.01 * random.standard_normal((4, 9))
            prints |= noisy(one, factors, f"copy of {one.key}")
            pairs.append((one.key, f"copy of {one.key}"))
        flags = [flag.students for flag in flag_class(prints)]
        assert set(flags) <= set(pairs)
        shares.append(len(flags) / len(pairs))
    assert np.mean(shares) >= 0.5


@pytest.mark.slow
def test_copy_with_other_times_and_most_of_the_spins_is_found(
    logs: dict[str, Student], prints: Prints
) -> None:
    original = logs["1003"]
    random = np.random.default_rng(5)
    spin, time = original.rows.spin.copy(), original.rows.time.copy()
    spin[[0, 4, 8]] += [12, -21, 33]
    time *= 1 + 0.01 * random.standard_normal(9)
    rows = replace(original.rows, spin=spin, time=time)
    copy = some(with_rows(original, rows, 999))
    (flag,) = flag_class({**prints, "copy": print_of(copy.log())})
    assert flag.students == ("1003", "copy")
    assert "with the same spin" in flag.evidence
    assert "period" not in flag.evidence


@pytest.mark.slow
def test_bench_with_a_few_spins_only_is_not_flagged(prints: Prints) -> None:
    """Ten students at a motor with three speeds have the same spins."""
    bench = [draw(i, 9) for i in range(10)]
    speeds = np.tile([287.0, 412.0, 633.0], 3)
    same = {
        f"bench{one.number}": print_of(
            with_rows(one, replace(one.rows, spin=speeds), one.number).log()
        )
        for one in bench
    }
    assert flag_class({**prints, **same}) == ()


@pytest.mark.slow
def test_few_students_with_other_spins_are_not_flagged() -> None:
    aims = [(310, 520, 830)] * 4 + [(200, 400, 600)] * 36
    students = [
        draw(i, 3, replace(USUAL, spins=spins, missed=0.02))
        for i, spins in enumerate(aims)
    ]
    assert flag_class({one.key: print_of(one.log()) for one in students}) == ()


def test_evidence_names_the_rows(logs: dict[str, Student], prints: Prints) -> None:
    copy = some(in_tenths(changed(logs["1002"], 0, 4, 8)))
    (flag,) = flag_class(
        {**dict(list(prints.items())[:40]), "mallory": print_of(copy.log())}
    )
    assert flag.evidence == (
        "6 of 9 rows of 1002 (lines 4, 5, 6, 8, 9, 10) are in mallory (lines 3, 5, 6, "
        "8, 9, 10), with the same spin "
        "and the same precession period"
    )


@pytest.mark.slow
def test_chance_of_a_small_scatter_agrees_with_chi_square(prints: Prints) -> None:
    """Times worked out from the formula, as is, and with a scatter of few milliseconds:
    no hand does that.
    """
    student, random = draw(5, 2), np.random.default_rng(6)
    rows = student.rows
    exact = (
        2
        * np.pi
        * rows.turns
        * INERTIA
        * rows.spin
        * RPM
        / (1e-3 * rows.mass * G * 0.01 * rows.position)
    )
    invented = {
        f"z{i}": exact + 0.003 * i * random.standard_normal(9) for i in range(3)
    }
    logs = {
        key: with_rows(student, replace(rows, time=time), number)
        for number, (key, time) in enumerate(invented.items())
    }
    flags = [
        flag_class({**prints, key: print_of(one.log())}) for key, one in logs.items()
    ]
    assert [[(flag.kind, flag.students) for flag in one] for one in flags] == [
        [("scatter", (key,))] for key in logs
    ]
    for (flag,), one in zip(flags, logs.values(), strict=True):
        lever = rows.turns * rows.spin
        design = np.column_stack(
            [*(lever * (rows.mass == mass) for mass in (20, 40, 60)), np.ones(9)]
        )
        _, (squares,), _, _ = np.linalg.lstsq(design, one.rows.time, rcond=None)
        # The last digit of a time hides a part of its scatter; a good hand has 0.05 s.
        assert flag.p == pytest.approx(
            stats.chi2.cdf((squares + 5 * 0.01**2 / 12) / 0.05**2, 5), rel=1e-6
        )


@pytest.mark.slow
@pytest.mark.parametrize("size", [38, 100])
def test_honest_logs_are_not_flagged(size: int) -> None:
    for seed in range(200, 202):
        students = [draw(i, seed) for i in range(size)]
        assert flag_class({one.key: print_of(one.log()) for one in students}) == ()
