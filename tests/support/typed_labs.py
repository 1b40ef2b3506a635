"""Logs of nine runs without noise, whose columns a test can write in its own way."""

from __future__ import annotations

import math

import pytest
from simulated_labs import analyze_briefly

from gyrodata import LogError
from gyrodata.base.errors import Diagnostic

TRUTH, G = 4.4e-3, 9.80665
THIRDS = (1, 3, 2, 6, 3, 1, 3, 6, 2)
"""Thirds of a turn of each run."""
IN_TURNS = {1: "1/3", 2: "2/3", 3: "1", 6: "2"}
IN_WORDS = {1: "one third", 2: "two thirds", 3: "full", 6: "two turns"}
START = "mass [g],position [cm],spin [rpm],time [s]"
FOUR = "{mass},14.8,{spin},{time:.2f}"


def values(mass: float, spin: float, thirds: int) -> dict[str, object]:
    """Return what a cell of a run may contain; the weight hangs at 14.8 cm."""
    torque = mass * 1e-3 * G * 0.148
    period = 2 * math.pi * TRUTH * spin * math.pi / 30 / torque
    time = period * thirds / 3
    written = {"turns": IN_TURNS[thirds], "words": IN_WORDS[thirds]}
    written |= {"percent": f"{100 * thirds / 3:.1f}", "degrees": f"{120 * thirds}"}
    numbers = {"mass": mass, "spin": spin, "thirds": thirds, "time": time}
    return {**written, **numbers, "period": period, "minutes": time / 60}


def log(head: str, row: str, above: str = "") -> str:
    """Write nine runs below a header; a row names the values of its cells."""
    settings = [(mass, spin) for mass in (20.1, 40.3, 60.2) for spin in (206, 394, 604)]
    runs = zip(settings, THIRDS, strict=True)
    rows = [row.format(**values(*setting, thirds)) for setting, thirds in runs]
    return "\n".join([f"{above}# g: {G} m/s^2", head, *rows]) + "\n"


def is_true(text: str, **options: dict[str, str]) -> bool:
    answer = analyze_briefly(text.encode(), **options).inertia
    return bool(abs(answer.value - TRUTH) < max(0.01 * TRUTH, 3 * answer.u))


def questions(text: str) -> list[Diagnostic]:
    with pytest.raises(LogError) as raised:
        analyze_briefly(text.encode())
    return [one for one in raised.value.diagnostics if one.severity == "error"]
