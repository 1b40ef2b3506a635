"""The ladder of models: what is chosen, what it costs, and what it saves."""

from __future__ import annotations

import itertools
import math

import pytest

import gyrodata
from gyrodata import effects, physics
from gyrodata.diagnostics import CODES
from gyrodata.simulation import EXACT, TYPICAL, Decay, Design, Truth, simulate
from gyrodata.units import Uncertainty

RPM = math.pi / 30
UP_AND_DOWN = (math.radians(-30), math.radians(30))


def simulated(**truth: object) -> bytes:
    """A log without errors that states no uncertainty, so that the usual ones are taken."""
    design = {name: truth.pop(name) for name in ("masses", "spins", "pitches", "turns") if name in truth}
    log = simulate(Truth(**truth), Design(**design), EXACT).log  # type: ignore[arg-type]
    return "".join(line for line in log.splitlines(True) if not line.startswith("# u_")).encode()


def analysed(*, noise: dict[str, Uncertainty] = EXACT, model: str = "auto", **truth: object) -> gyrodata.Analysis:
    design = {name: truth.pop(name) for name in ("masses", "spins", "pitches", "positions", "turns") if name in truth}
    made = simulate(Truth(**truth), Design(**design), noise)  # type: ignore[arg-type]
    return gyrodata.analyze(made.log.encode(), model=model)  # type: ignore[arg-type]


def effect(analysis: gyrodata.Analysis, name: str) -> effects.Effect:
    return next(found for found in analysis.effects if found.effect == name)


class TestChoice:
    def test_a_slight_tilt_is_left_out_and_a_strong_one_kept(self) -> None:
        slight = analysed(noise=TYPICAL, pitches=(math.radians(2),))
        strong = analysed(noise=TYPICAL, pitches=UP_AND_DOWN[1:], spins=(150 * RPM, 300 * RPM))
        assert (slight.model.name, strong.model.name) == ("horizontal", "steady")
        assert not effect(slight, "tilt").kept
        assert effect(slight, "tilt").size < effects.DROP_ONE  # type: ignore[operator]
        assert "small enough" in effect(slight, "tilt").reason
        assert effect(strong, "tilt").kept

    @pytest.mark.parametrize(("model", "tilt"), [("horizontal", False), ("steady", True), ("released", True)])
    def test_what_is_asked_for_is_done(self, model: str, tilt: bool) -> None:
        analysis = analysed(noise=TYPICAL, pitches=UP_AND_DOWN, model=model)
        assert analysis.model.name == model
        assert effect(analysis, "tilt").kept is tilt
        assert "as asked" in effect(analysis, "tilt").reason
        assert analysis.to_dict()["result"]["model"] == model

    def test_the_log_says_that_the_rod_was_let_go(self) -> None:
        analysis = analysed(noise=TYPICAL, motion="released", masses=(0.06, 0.12), spins=(150 * RPM, 200 * RPM))
        assert analysis.model.name == "released"
        assert abs(analysis.inertia.value / 4.44e-3 - 1) < 3 * analysis.inertia.u / 4.44e-3  # type: ignore[operator]
        assert {"nutation", "release"} <= {share.source for share in analysis.budget}


class TestExactLogs:
    @pytest.mark.parametrize(
        "truth",
        [
            {},
            {"pitches": (math.radians(50),)},
            {"decay": Decay(lost=0.5), "pitches": UP_AND_DOWN},
            {"positions": (0.15, -0.15)},
            {"spins": (400 * RPM, -600 * RPM, 200 * RPM)},
            {"motion": "released", "pitches": (math.radians(20),)},
            {"motion": "released", "imbalance": 5e-4, "spins": (400 * RPM, 600 * RPM)},
        ],
        ids=str,
    )
    def test_give_the_truth_back(self, truth: dict[str, object]) -> None:
        assert analysed(**truth).inertia.value == pytest.approx(4.44e-3, rel=1e-8)

    def test_two_runs_cannot_tell_the_phase_of_the_nutation(self) -> None:
        analysis = analysed(motion="released", spins=(400 * RPM,), masses=(0.02, 0.06))
        assert abs(analysis.inertia.value - 4.44e-3) < 3 * analysis.inertia.u  # type: ignore[operator]
        assert analysis.inertia.u > 1e-3 * 4.44e-3  # type: ignore[operator]


RELEASED_SLOWLY = {"motion": "released", "imbalance": 2e-4, "spins": (60 * RPM, 100 * RPM, 200 * RPM)}


class TestSizes:
    """What is listed, against I_zz with the effect and without it by two analyses."""

    @pytest.mark.parametrize(
        ("name", "truth"),
        [
            ("release", RELEASED_SLOWLY | {"turns": (2 / 3,)}),
            ("release", RELEASED_SLOWLY | {"turns": (1 / 3,), "masses": (0.0, 0.02, 0.04, 0.06)}),
            ("tilt", {"spins": (20 * RPM, 60 * RPM, 200 * RPM), "pitches": (math.radians(-85),)}),
            ("tilt", {"pitches": (math.radians(30),)}),
        ],
        ids=str,
    )
    def test_are_those_of_two_analyses(self, name: str, truth: dict[str, object]) -> None:
        made = simulated(**truth)
        within, without = (gyrodata.analyze(made, model=model) for model in ("auto", "horizontal"))  # type: ignore[arg-type]
        found = effect(within, name)
        assert found.kept
        brute = without.inertia.value / within.inertia.value - 1
        assert found.bias == pytest.approx(brute, rel=0.1, abs=0.05 * within.inertia.u / within.inertia.value)  # type: ignore[operator]
        assert abs(brute) > 0.2 * within.inertia.u / within.inertia.value  # type: ignore[operator]

    @pytest.mark.parametrize("turns", [1 / 3, 2 / 3, 2.0])
    def test_of_a_release_are_told_before_it_is_known(self, turns: float) -> None:
        made = simulated(**RELEASED_SLOWLY, turns=(turns,))
        silent = gyrodata.analyze(made.replace(b"# motion: released\n", b""))
        brute = silent.inertia.value / gyrodata.analyze(made).inertia.value - 1
        found, u = effect(silent, "release"), silent.inertia.u / silent.inertia.value  # type: ignore[operator]
        assert found.bias == pytest.approx(brute, rel=0.1, abs=0.05 * u)
        told = [d.message for d in silent.diagnostics if d.code == "G418"]
        assert bool(told) == (abs(brute) > 0.2 * u)
        side = "high" if brute > 0 else "low"
        assert all(f"{100 * abs(found.bias):.2g} % too {side}" in message for message in told)  # type: ignore[arg-type]

    def test_of_a_ball_that_is_not_balanced_are_those_of_a_line_through_the_origin(self) -> None:
        analysis = analysed(imbalance=1e-3, noise=TYPICAL)
        found = effect(analysis, "residual_torque")
        assert found.bias == pytest.approx(-0.03, abs=0.015)
        assert found.kept


def test_what_i_across_the_rod_matters_is_told() -> None:
    analysis = gyrodata.analyze(CODES["G417"].example.encode())
    share = next(share for share in analysis.budget if share.source == "transverse_inertia")
    found = next(found for found in analysis.diagnostics if found.code == "G417")
    assert f"{100 * share.u_inertia / analysis.inertia.value:.2g} % of I_zz" in found.message


def test_with_the_latitude_the_turning_floor_is_corrected_for() -> None:
    floor = physics.EARTH_ROTATION * math.sin(math.radians(42.5))
    rows = ""
    for mass, rpm in itertools.product((20, 40, 60), (200, 400, 600)):
        seconds = 2 * math.pi / (mass * 1e-3 * 9.803 * 0.15 / (4.44e-3 * rpm * RPM) - floor)
        rows += f"{mass}.0000,15.0000,{rpm}.000,{seconds:.8f},1,ccw\n"
    head = "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense\n"
    keys = {
        "s": "time time_bias spin_delay",
        "%": "spin spin_scale mass mass_scale turns g",
        "mm": "position position_zero",
    }
    lines = "".join(f"# u_{key}: 1e-6 {unit}\n" for unit, named in keys.items() for key in named.split())
    analysis = gyrodata.analyze(f"# g: 9.803 m/s^2\n# latitude: 42.5 deg\n{lines}{head}{rows}".encode())
    assert analysis.inertia.value == pytest.approx(4.44e-3, rel=1e-6)
    assert effect(analysis, "earth").kept


def test_three_readings_of_the_spin_need_no_law() -> None:
    rows = "\n".join(
        f"{m},15.0,{s},{s / math.sqrt(2):.12g},{s / 2},{t},1" for m, s, t in ((20, 400, 30), (60, 600, 15))
    )
    header = "mass [g],position [cm],spin_start [rpm],spin [rpm],spin_end [rpm],time [s],turns\n"
    analysis = gyrodata.analyze((header + rows).encode())
    assert "decay_law" not in [found.effect for found in analysis.effects]
    viscous = 400 * math.log(2)  # harmonic mean of a halving spin: start d/(e^d - 1)
    assert analysis.run_table[0].spin / RPM == pytest.approx(viscous, rel=1e-4)
