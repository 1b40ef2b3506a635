"""The ladder of models: what is chosen, what it costs, and what it saves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import Struct
from msgspec.structs import replace

import gyrodata
from gyrodata import effects, fitting, physics
from gyrodata.diagnostics import CODES
from gyrodata.effects import _kept, choose_model
from gyrodata.fitting import ChosenModel, Estimate, iterate_mean_rate
from gyrodata.measurements import Measurements, Source, measure
from gyrodata.simulation import EXACT, TYPICAL, Decay, Design, Truth, simulate
from gyrodata.units import Uncertainty

RPM = math.pi / 30
UP_AND_DOWN = (math.radians(-30), math.radians(30))
SLOW_HAND = TYPICAL | {"u_time_bias": Uncertainty(0.1)}
SCENES = {
    "level": (Truth(imbalance=1e-4), Design(), TYPICAL),
    "tilted": (Truth(), Design(spins=(100 * RPM, 200 * RPM, 300 * RPM), pitches=UP_AND_DOWN), TYPICAL),
    "spin falling by half": (Truth(decay=Decay(lost=0.5)), Design(), TYPICAL),
    "imbalance and a slow hand": (Truth(imbalance=1e-3), Design(), SLOW_HAND),
    "all together": (
        Truth(imbalance=1e-3, decay=Decay(lost=0.5)),
        Design(spins=(150 * RPM, 300 * RPM, 450 * RPM), pitches=UP_AND_DOWN),
        SLOW_HAND,
    ),
}


class Score(Struct, frozen=True):
    """How a model did over many labs, in per cent."""

    bias: float
    rmse: float
    coverage: float


def simplest(measured: Measurements) -> Estimate:
    """Eq. (9), the plain mean of the spins, and neither M0 nor b."""
    if measured.spin_start is not None and measured.spin_end is not None:
        measured = replace(measured, spin=(measured.spin_start + measured.spin_end) / 2)
    return fitting.fit(replace(measured, imbalance_u=lambda inertia: 1e-9, timing_bias_u=0.0)).inertia


def fullest(measured: Measurements) -> Estimate:
    chosen = ChosenModel(tilted=True, released=False, asked=True)
    return fitting.fit(iterate_mean_rate(measured, chosen), True).inertia


def chosen(measured: Measurements) -> Estimate:
    chosen = choose_model(measured, "auto")
    runs = iterate_mean_rate(measured, chosen)
    return fitting.fit(runs, chosen.tilted).inertia


def study(name: str, labs: int) -> dict[str, Score]:
    truth, design, noise = SCENES[name]
    found: dict[str, list[tuple[float, float]]] = {"simplest": [], "fullest": [], "chosen": []}
    for seed in range(labs):
        measured = measure(simulate(truth, design, noise, seed).readings)
        for model, answer in (("simplest", simplest), ("fullest", fullest), ("chosen", chosen)):
            estimate = answer(measured)
            assert estimate.u is not None
            found[model].append((estimate.value / truth.inertia - 1, estimate.u / truth.inertia))
    scores = {}
    for model, pairs in found.items():
        error, u = np.array(pairs).T
        inside = np.mean(np.abs(error) < 1.96 * u)
        scores[model] = Score(100 * error.mean(), 100 * float(np.sqrt(np.mean(error**2))), 100 * inside)
    return scores


@pytest.mark.parametrize("scene", SCENES)
def test_the_choice_costs_nothing(scene: str) -> None:
    scores = study(scene, 40)
    assert scores["chosen"].rmse == pytest.approx(scores["fullest"].rmse, rel=0.03)
    assert scores["chosen"].coverage == pytest.approx(scores["fullest"].coverage, abs=5.1)
    assert scores["chosen"].coverage > 85
    if "falling" in scene or "together" in scene:
        assert scores["simplest"].coverage < 45


LEVEL = ChosenModel(tilted=False, released=False, asked=False)


def typical(measured: Measurements) -> tuple[Source, ...]:
    """The sources of a log that states nothing."""
    names = {source.name: source for source in measured.sources}
    count = len(measured.runs)
    sizes = {"time": (0.14, 0.0), "spin": (0.0, 0.002), "mass": (0.0, 0.002)}
    return tuple(
        replace(names[name], absolute=np.full(count, absolute), relative=np.full(count, relative))
        for name, (absolute, relative) in sizes.items()
    )


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
    def test_a_level_rod_needs_eq_9(self) -> None:
        assert analysed(noise=TYPICAL).model.name == "horizontal"

    def test_a_slight_tilt_is_left_out_and_a_strong_one_kept(self) -> None:
        slight = analysed(noise=TYPICAL, pitches=(math.radians(2),))
        strong = analysed(noise=TYPICAL, pitches=UP_AND_DOWN[1:], spins=(150 * RPM, 300 * RPM))
        assert (slight.model.name, strong.model.name) == ("horizontal", "steady")
        assert not effect(slight, "tilt").kept
        assert effect(slight, "tilt").size < effects.DROP_ONE  # type: ignore[operator]
        assert "small enough" in effect(slight, "tilt").reason
        assert effect(strong, "tilt").kept

    def test_what_is_dropped_stays_small_together(self) -> None:
        assert _kept({"a": 0.1, "b": -0.15}, 0.0, 1.0) == set()
        assert _kept({"a": 0.1, "b": -0.15}, 0.1, 1.0) == {"b"}
        assert _kept({"a": 0.1, "b": -0.21}, 0.0, 1.0) == {"b"}
        assert _kept({"a": 0.1}, 0.25, 1.0) == {"a"}

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
            {"pitches": (math.radians(-50),)},
            {"decay": Decay(lost=0.3)},
            {"decay": Decay(lost=0.5), "pitches": UP_AND_DOWN},
            {"positions": (0.15, -0.15)},
            {"spins": (400 * RPM, -600 * RPM, 200 * RPM)},
            {"motion": "released"},
            {"motion": "released", "pitches": (math.radians(20),)},
            {"motion": "released", "imbalance": 5e-4, "spins": (400 * RPM, 600 * RPM)},
        ],
        ids=str,
    )
    def test_give_the_truth_back(self, truth: dict[str, object]) -> None:
        assert analysed(**truth).inertia.value == pytest.approx(4.44e-3, rel=1e-8)

    def test_of_a_rod_let_go_at_400_rpm(self) -> None:
        analysis = analysed(motion="released", spins=(400 * RPM,))
        assert analysis.inertia.value == pytest.approx(4.44e-3, rel=1e-3)

    def test_two_runs_cannot_tell_the_phase_of_the_nutation(self) -> None:
        analysis = analysed(motion="released", spins=(400 * RPM,), masses=(0.02, 0.06))
        assert abs(analysis.inertia.value - 4.44e-3) < 3 * analysis.inertia.u  # type: ignore[operator]
        assert analysis.inertia.u > 1e-3 * 4.44e-3  # type: ignore[operator]


RELEASED_SLOWLY = {"motion": "released", "imbalance": 2e-4, "spins": (60 * RPM, 100 * RPM, 200 * RPM)}


class TestSizes:
    """What is listed, against I_zz with the effect and without it by two analyses."""

    @pytest.mark.parametrize(
        ("name", "truth", "simpler"),
        [
            ("release", RELEASED_SLOWLY | {"turns": (2 / 3,)}, "horizontal"),
            ("release", RELEASED_SLOWLY | {"turns": (2.0,)}, "horizontal"),
            ("release", RELEASED_SLOWLY | {"turns": (1 / 3,), "masses": (0.0, 0.02, 0.04, 0.06)}, "horizontal"),
            ("tilt", {"spins": (20 * RPM, 60 * RPM, 200 * RPM), "pitches": (math.radians(-85),)}, "horizontal"),
            ("tilt", {"pitches": (math.radians(30),)}, "horizontal"),
        ],
        ids=str,
    )
    def test_are_those_of_two_analyses(self, name: str, truth: dict[str, object], simpler: str) -> None:
        made = simulated(**truth)
        within, without = (gyrodata.analyze(made, model=model) for model in ("auto", simpler))  # type: ignore[arg-type]
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

    def test_of_the_earth_leave_m0_what_it_takes_up(self) -> None:
        measured = measure(simulate(Truth(imbalance=2e-4), Design(masses=(0.0, 0.02, 0.04, 0.06)), EXACT, 0).readings)
        measured = replace(measured, sources=typical(measured), timing_bias_u=0.05)
        fit = fitting.fit(measured)
        listed = {found.effect: found for found in effects.list_effects(measured, fit, LEVEL)}["earth"]
        share = physics.EARTH_ROTATION * fit.sense * measured.time / (2 * np.pi * measured.turns)
        turned = fitting.fit(replace(measured, turns=measured.turns * (1 + share))).inertia.value
        assert listed.bias == pytest.approx(
            abs(fit.inertia.value / turned - 1), rel=0.1, abs=0.05 * effects.relative_u(fit)
        )
        assert listed.size < 0.1  # type: ignore[operator]

    def test_with_the_latitude_the_earth_is_corrected_for(self) -> None:
        exact = measure(simulate(Truth(), Design(), EXACT, 0).readings)
        sense = np.ones(len(exact.runs))
        # The floor turns by 42.5° north while the rod turns against the stars.
        vertical = physics.EARTH_ROTATION * math.sin(math.radians(42.5))
        seen = exact.turns - vertical * exact.time / (2 * np.pi)
        measured = replace(exact, turns=seen, precession_sense=sense, latitude=math.radians(42.5))
        chosen = choose_model(measured, "auto")
        assert chosen.earth
        corrected = iterate_mean_rate(measured, chosen)
        assert fitting.fit(corrected).inertia.value == pytest.approx(4.44e-3, rel=1e-6)
        kept = next(e for e in effects.list_effects(corrected, fitting.fit(corrected), chosen) if e.effect == "earth")
        without = fitting.fit(measured).inertia.value / 4.44e-3 - 1
        assert kept.kept
        assert kept.bias == pytest.approx(without, rel=0.1)

    def test_of_the_law_of_the_decay_is_that_of_the_other_law(self) -> None:
        measured = measure(simulate(Truth(decay=Decay(lost=0.3)), Design(), TYPICAL, 1).readings)
        told = tuple(source for source in measured.sources if source.name != "decay_exponent")
        measured = replace(measured, sources=told)
        fit = fitting.fit(measured)
        found = {one.effect: one for one in effects.list_effects(measured, fit, LEVEL)}["decay_law"]
        assert measured.spin_start is not None
        assert measured.spin_end is not None
        dry = (measured.spin_start - measured.spin_end) / np.log(measured.spin_start / measured.spin_end)
        brute = fitting.fit(replace(measured, spin=dry)).inertia.value / fit.inertia.value - 1
        assert found.bias == pytest.approx(brute, rel=0.1)
        assert "NOT small" in found.reason
        count = len(measured.runs)
        doubt = Source(
            "decay_exponent",
            "spin",
            np.zeros(count, dtype=int),
            np.zeros(count),
            np.full(count, 0.005),
            "",
            True,
            "0.5",
        )
        holding = replace(measured, sources=(*measured.sources, doubt))
        found = {one.effect: one for one in effects.list_effects(holding, fit, LEVEL)}["decay_law"]
        assert found.in_u
        assert "u holds" in found.reason

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


def test_three_readings_of_the_spin_need_no_law() -> None:
    rows = "\n".join(
        f"{m},15.0,{s},{s / math.sqrt(2):.12g},{s / 2},{t},1" for m, s, t in ((20, 400, 30), (60, 600, 15))
    )
    header = "mass [g],position [cm],spin_start [rpm],spin [rpm],spin_end [rpm],time [s],turns\n"
    analysis = gyrodata.analyze((header + rows).encode())
    assert "decay_law" not in [found.effect for found in analysis.effects]
    viscous = 400 * math.log(2)  # harmonic mean of a halving spin: start d/(e^d - 1)
    assert analysis.run_table[0].spin / RPM == pytest.approx(viscous, rel=1e-4)


if __name__ == "__main__":
    for scene in SCENES:
        print(scene, *(f"\n  {model:9} {score}" for model, score in study(scene, 1000).items()))
