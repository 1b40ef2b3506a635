"""Slips of unit, origin, count or column planted in good logs: each is named, and
nearly always as it was made.
"""

from __future__ import annotations

import re
import tomllib
from fractions import Fraction

import numpy as np
import pytest
from msgspec import Struct
from msgspec.structs import replace
from places import DATA
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata import physics

MASS, DIAMETER, G = 4.3, 10.16, 9.803
TRUTH = physics.solid_ball_inertia(MASS, DIAMETER / 100)
RPM = physics.RPM


class Lab(Struct, frozen=True):
    """A log as columns of numbers, each under its header."""

    mass: np.ndarray
    position: np.ndarray
    spin: np.ndarray
    time: np.ndarray
    turns: np.ndarray
    heads: tuple[str, ...] = (
        "mass [g]",
        "position [cm]",
        "spin [rpm]",
        "time [s]",
        "turns",
    )
    top: str = f"# ball_mass: {MASS} kg\n# ball_diameter: {DIAMETER} cm\n"

    def text(self) -> str:
        rows = zip(
            self.mass, self.position, self.spin, self.time, self.turns, strict=True
        )
        # As many digits as were read, whatever the unit.
        lines = "".join(
            f"{','.join(f'{x:.6g}' for x in row[:-1])},{Fraction(row[-1]).limit_denominator(12)}\n"
            for row in rows
        )
        return f"# g: {G} m/s^2\n# motion: steady\n{self.top}{','.join(self.heads)}\n{lines}"


def lab(turns: float = 1 / 3, seed: int = 4) -> Lab:
    random = np.random.default_rng(seed)
    mass, spin = np.repeat([20.1, 40.3, 60.2], 3), np.tile([212.0, 398.0, 604.0], 3)
    position, part = np.full(9, 14.8), np.full(9, turns)
    time = (
        2
        * np.pi
        * part
        * TRUTH
        * spin
        * RPM
        / (mass * 1e-3 * G * position * 1e-2 + 0.4e-3)
    )
    return Lab(
        mass, position, spin, np.round(time + 0.1 * random.standard_normal(9), 2), part
    )


def headed(one: Lab, **heads: str) -> Lab:
    """Write other headers over the columns."""
    roles = ("mass", "position", "spin", "time", "turns")
    return replace(
        one,
        heads=tuple(heads.get(role, one.heads[roles.index(role)]) for role in roles),
    )


def ball(diameter: float) -> str:
    return f"# ball_mass: {MASS} kg\n# ball_diameter: {diameter} cm\n"


SLIPS = tomllib.loads(
    (DATA / "wrong_units_and_counts.toml").read_text(encoding="utf-8")
)


def slipped(name: str) -> Lab:
    """Make a slip in a good log."""
    one, slip = lab(), SLIPS[name]
    for role, factor in slip.items():
        if isinstance(factor, (int, float)) and role != "ball":
            one = replace(one, **{role: getattr(one, role) * factor})
            one = headed(one, **{role: slip["head"]}) if "head" in slip else one
    if name == "spin and time exchanged":
        one = headed(one, time=slip["time"])
    return replace(one, top=ball(slip["ball"])) if "ball" in slip else one


def told(log: str) -> list[str]:
    """What is said of magnitudes, by the analysis or, where there is no answer, beside
    the error; the first first.
    """
    try:
        found = analyze_briefly(log.encode()).diagnostics
    except gyrodata.LogError as error:
        found = error.diagnostics
    return [
        f"{d.message} | {d.hint}"
        for d in found
        if d.code in ("G440", "G441", "G442", "G443")
    ]


def is_first(words: list[str], cause: str) -> bool:
    """Whether the cause is what the first message names, and first in it."""
    message, _, hint = words[0].partition(" | ") if words else ("", "", "")
    return (
        cause in f"{message.partition('; or ')[0]} | {hint.partition('; or else')[0]}"
    )


@pytest.mark.slow
def test_a_good_log_is_not_asked() -> None:
    for seed, turns in enumerate((1 / 3, 2 / 3, 1.0) * 3):
        assert told(lab(turns, seed).text()) == []


@pytest.mark.slow
def test_one_cell_in_another_unit_is_asked_about_and_spoils_nothing() -> None:
    text = lab().text()
    row = text.splitlines()[9]
    slip = text.replace(row, row.replace("40.3", "0.0403"))
    (words,) = told(slip)
    assert "mass 0.0403 g is outside the range of this experiment" in words
    # The weight that nobody had is left out, and says nothing of the balance.
    found, without = (
        gyrodata.analyze(one.encode()) for one in (slip, text.replace(f"{row}\n", ""))
    )
    assert [run.left_out for run in found.run_table].count(True) == 1
    assert "run 5 (line 10), left out: mass 40.3 g" in str(found)
    u = without.inertia.u or 0.0
    assert found.inertia.value == pytest.approx(without.inertia.value, abs=0.02 * u)
    assert found.inertia.u == pytest.approx(u, rel=0.01)


def obeyed(one: Lab, hint: str) -> Lab:
    """Carry out the first thing that a hint says to type."""
    if header := re.search(r'write the header as "((\w+) \[[^"]+\])"', hint):
        role = {"force": "mass", "angle": "turns"}.get(header[2], header[2])
        return headed(one, **{role: header[1]})
    if "exchange the two headers" in hint:
        return headed(one, spin="spin [rpm]", time="time [s]")
    if by := re.search(r"(add|take) the ball's radius, ([\d.]+) cm", hint):
        return replace(
            one, position=one.position + float(by[2]) * (1 if by[1] == "add" else -1)
        )
    if written := re.search(r"write the turns as ([\d/]+)", hint):
        return replace(one, turns=np.full(9, float(Fraction(written[1]))))
    if written := re.search(r"# ball_diameter: ([\d.]+) cm", hint):
        return replace(one, top=ball(float(written[1])))
    if "write the part of a turn" in hint:
        return replace(one, turns=1 / one.turns)
    if "halve the spins or the turns" in hint:
        return replace(one, spin=one.spin / 2)
    assert "measure from the centre of the ball" in hint
    return replace(one, position=np.full(9, 14.8))


OTHER_CAUSE_FIRST = {
    "newtons under kg",
    "an arm from the centre to the far side, halved",
}
"""Slips that nothing in the log tells from another cause."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SLIPS)
def test_a_slip_is_named_first_and_its_hint_gives_the_truth(name: str) -> None:
    wrong = slipped(name)
    words = told(wrong.text())
    assert is_first(words, SLIPS[name]["says"]) or name in OTHER_CAUSE_FIRST, words
    mended = obeyed(
        wrong, words[0].partition(" | ")[2].partition("; or else")[0]
    ).text()
    # A slip that leaves the same factor gives the same answer.
    close = 0.06 if name in OTHER_CAUSE_FIRST else 0.03
    assert analyze_briefly(mended.encode()).inertia.value == pytest.approx(
        TRUTH, rel=close
    )
    assert told(mended) == []
