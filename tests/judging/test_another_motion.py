"""A model of motion that is added from outside: a rod with a constant drag.

A drag of constant size against the precession has a vertical torque D. The rod sinks
at the rate D/(I_zz ψ̇), so that a run of the time T has the mean pitch −D T/(2 I_zz ψ̇),
and eq. (8) gives the rate.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from typer.testing import CliRunner

import gyrodata
from gyrodata import physics
from gyrodata.cli import app
from gyrodata.physics import Floats, models
from gyrodata.physics.models import ModelError, MotionModel, TimedRuns
from gyrodata.physics.motion import Top

INERTIA, ACROSS, RPM = 4.44e-3, 9e-3, math.pi / 30
DRAG, G, ARM = 0.9e-3, 9.80665, 0.15


def rate_with_drag(torque: Floats, spin: Floats, time: Floats, top: Top) -> Floats:
    """Compute the mean rate [rad/s] of level rods that sink under the drag."""
    points, weights = np.polynomial.legendre.leggauss(12)
    moments = 0.5 * (points[:, None] + 1) * time
    pitch = -DRAG * moments / (np.asarray(top.inertia) * spin)
    fields = torque, spin, top.inertia, top.transverse_inertia, pitch
    return np.asarray(0.5 * weights @ physics.precession_rate(*fields))


class Dragged(MotionModel, frozen=True):
    """A rod with a constant drag that the log states: ``# rod_drag: 0.9e-3``."""

    name = "dragged"
    words = "eq. (8), a rod that sinks under a constant drag"
    effect = "drag"
    effect_words = "drag on the rod"
    source_words: ClassVar[Mapping[str, str]] = {"rod_drag": "drag on the rod"}

    def is_stated(self, runs: TimedRuns) -> bool:
        return "rod_drag" in runs.lines

    def reason(self, runs: TimedRuns, kept: bool, as_asked: str) -> str:
        if not self.is_stated(runs):
            return "no drag in the log"
        return f"the rod {'sinks' if kept else 'stays level'}{as_asked}"

    def mean_rate(self, top: Top, runs: TimedRuns, steady: Floats) -> Floats:
        if not self.is_stated(runs):
            return steady
        assert float(runs.lines["rod_drag"]) == DRAG
        return rate_with_drag(top.torque, runs.spin, runs.time, top)

    def errors(
        self, top: Top, runs: TimedRuns, slowing: Floats
    ) -> Iterator[ModelError]:
        size = 0.1 * np.abs(slowing - 1)
        yield ModelError("rod_drag", "turns", size, "10 % of the drag", "all runs")


@pytest.fixture(autouse=True)
def dragged() -> Iterator[None]:
    """Add the model to the list, as a package from outside would."""
    model = Dragged()
    models.MODELS.append(model)
    yield
    models.MODELS.remove(model)


def log_with_drag(*lines: str) -> str:
    """Write a log without noise of level rods that sink under the drag."""
    rows = []
    for mass in (0.02, 0.04, 0.06):
        for rpm in (100, 150, 200):
            torque, spin = np.array([mass * G * ARM]), np.array([rpm * RPM])
            top, angle = (
                Top(inertia=INERTIA, transverse_inertia=ACROSS, torque=torque),
                6 * math.pi,
            )
            time = angle * INERTIA * spin / torque
            for _round in range(30):
                time = angle / rate_with_drag(torque, spin, time, top)
            rows.append(f"{1e3 * mass:.3f},15.000,{rpm}.00,{time[0]:.4f},3")
    head = (
        "# motion: steady",
        f"# g: {G} m/s^2",
        f"# transverse_inertia: {ACROSS} kg*m^2",
        "# u_time: 0.05 s",
        "# u_time_bias: 0.01 s",
        "# u_spin_delay: 0 s",
        "# u_position_zero: 0.1 mm",
        *lines,
        "mass [g],position [cm],spin [rpm],time [s],turns",
    )
    return "\n".join((*head, *rows)) + "\n"


STATED = f"# rod_drag: {DRAG}"


def drag_in(analysis: gyrodata.Analysis) -> dict[str, object]:
    """Find the row of the drag in the table of effects, as in the JSON."""
    effects = analysis.to_dict()["result"]["effects"]
    return next(effect for effect in effects if effect["effect"] == "drag")


def off(analysis: gyrodata.Analysis) -> float:
    """Compare the answer with the truth, in u."""
    return abs(analysis.inertia.value - INERTIA) / analysis.inertia.u


def test_a_log_that_states_the_drag_is_fitted_with_it() -> None:
    analysis = gyrodata.analyze(log_with_drag(STATED).encode())
    result = json.loads(json.dumps(analysis.to_dict()))["result"]
    assert result["model"] == analysis.model.name == "dragged"
    assert off(analysis) < 0.2
    assert "rod_drag" in {share["source"] for share in result["budget"]}
    row = drag_in(analysis)
    assert row["kept"]
    assert row["size"] > 0.2
    assert "the rod sinks" in str(row["reason"])


def test_the_size_of_the_drag_is_that_of_two_analyses() -> None:
    within = gyrodata.analyze(log_with_drag(STATED).encode())
    without = gyrodata.analyze(log_with_drag().encode())
    assert without.model.name == "horizontal"
    assert off(without) > 3 * off(within) + 0.2
    brute = without.inertia.value / within.inertia.value - 1
    u = within.inertia.u / within.inertia.value
    assert drag_in(within)["bias"] == pytest.approx(brute, rel=0.1, abs=0.05 * u)
    row = drag_in(without)
    assert not row["kept"]
    assert "no drag in the log" in str(row["reason"])


def test_a_user_can_ask_for_it() -> None:
    log = log_with_drag(STATED).encode()
    analysis = gyrodata.analyze(log, model="dragged")  # type: ignore[arg-type]
    assert analysis.model.name == "dragged"
    assert "the rod sinks, as asked" in str(drag_in(analysis)["reason"])
    with pytest.raises(ValueError, match="dragged"):
        gyrodata.analyze(log, model="dragd")  # type: ignore[arg-type]


def test_answers_to_changes_are_those_of_the_changed_file() -> None:
    log = log_with_drag(STATED)
    told = {
        one.words: one.inertia for one in gyrodata.analyze(log.encode()).sensitivity
    }
    words = next(words for words in told if words.startswith("without 20"))
    rest = "".join(row for row in log.splitlines(True) if not row.startswith("20.000,"))
    changed = gyrodata.analyze(rest.encode()).inertia
    assert told[words].value == pytest.approx(changed.value, abs=0.03 * changed.u)


def test_page_names_it(tmp_path: Path) -> None:
    path = tmp_path / "dragged.csv"
    path.write_text(log_with_drag(STATED), encoding="utf-8")
    done = CliRunner().invoke(app, ["analyze", str(path), "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    page = next(tmp_path.rglob("report.html")).read_text(encoding="utf-8")
    for words in (Dragged.words, Dragged.effect_words, "the rod sinks"):
        assert words in page
