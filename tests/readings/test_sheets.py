"""A hundred and twenty logs as students type them: read and right, or refused with a remedy that is right."""

import warnings

import pytest
from sheets import HABITS, INERTIA, lab, source

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
