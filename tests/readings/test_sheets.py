"""A hundred and twenty logs as students type them: read and right, or refused with a remedy that is right."""

import math
from collections import Counter

import pytest
from sheets import HABITS, HEADERS, INERTIA, lab, source

from gyrodata.analysis import analyze_readings
from gyrodata.errors import GyroError
from gyrodata.readings import read_log


def answer(data, **given):
    """Give how far off I_zz is in u, whether anything was warned of, and all that is said."""
    try:
        readings = read_log(data, **given)
    except GyroError as error:
        return None, " ".join(f"{d.message} {d.hint}" for d in error.diagnostics), True
    said = " ".join(f"{d.code} {d.message} {d.hint}" for d in readings.diagnostics)
    if not readings.ok:
        return None, said, True
    analysis = analyze_readings(readings)
    found = analysis.inertia
    warned = any(d.severity != "note" for d in analysis.diagnostics)
    return (found.value - INERTIA) / found.u, said, warned


def made(habit):
    runs = lab(HABITS.index(habit), habit.turns, habit.unloaded)
    return source(habit.make(runs))


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.name)
def test_a_log_as_students_type_it(habit):
    data = made(habit)
    off, said, _ = answer(data)
    if habit.asked:
        assert off is None, said
        assert habit.says in said
        if habit.edit:
            data = data.decode().replace(*habit.edit).encode()
        off, said, _ = answer(data, settings=habit.settings, mapping=habit.mapping)
    assert off is not None, said
    assert abs(off) < 3, (off, said)
    if not habit.asked:
        assert habit.says in said


def test_most_of_them_are_read_without_help_and_workbooks_and_languages_are_among_them():
    asked = [habit for habit in HABITS if habit.asked]
    assert len(HABITS) >= 120
    assert len(asked) < 0.15 * len(HABITS)
    assert sum(made(habit).startswith(b"PK") for habit in HABITS) >= 40
    assert len({habit.name for habit in HABITS}) == len(HABITS)


USUAL = {
    "mass [g]": ("mass", "20.1", 0.0201),
    "position [cm]": ("position", "14.8", 0.148),
    "spin [rpm]": ("spin", "400", 400 * math.pi / 30),
    "time [s]": ("time", "13.2", 13.2),
    "turns": ("turns", "1/3", 1 / 3),
}


def test_headers_that_students_write_are_understood_or_asked_about_by_name():
    outcomes = Counter()
    for meant, headers in HEADERS.items():
        for header in headers.split("; "):
            head = [header if role == meant else usual for usual, (role, _, _) in USUAL.items()]
            row = [cell for _, cell, _ in USUAL.values()]
            readings = read_log(";".join(head) + "\n" + ";".join(row) + "\n")
            if readings.ok:
                for role, _, value in USUAL.values():
                    assert readings.columns[role].values == (pytest.approx(value),), header
                outcomes["understood"] += 1
            else:
                said = [d for d in readings.diagnostics if d.severity == "error"]
                asked = any(f'"{header}"' in d.hint or (d.code != "G301" and f'"{header}"' in d.message) for d in said)
                outcomes["asked" if asked else "not placed"] += 1
    assert outcomes.total() >= 120
    assert outcomes["understood"] >= 110
    assert outcomes["not placed"] <= 2
