"""The fit: the truth, the same number by another method, coverage, and where other fits break."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from golden import every_number_of_a_fit, every_slip_found
from hypothesis import given, settings
from hypothesis import strategies as st
from labs import INERTIA, G, lab, scenes
from msgspec.structs import replace
from scipy.integrate import quad
from scipy.optimize import least_squares
from scipy.special import gammaincc

from gyrodata import fitting, motion, physics
from gyrodata.fitting import NoFit, explaining_counts, fit, fit_as_stated, insist_on_solution, ordinary_line, screen
from gyrodata.fitting.adjustment import Start, adjust
from gyrodata.measurements import Measurements, Source

EXPECTED = Path(__file__).parent / "expected"
FITS = json.loads((EXPECTED / "fits.json").read_text(encoding="utf-8"))
SLIPS = json.loads((EXPECTED / "slips.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("scene", FITS)
def test_no_number_of_a_fit_changes_unnoticed(scene: str) -> None:
    found = every_number_of_a_fit(scene)
    assert found.keys() == FITS[scene].keys()
    off = {}
    for key, row in FITS[scene].items():
        # What is 0 but for rounding is nothing in any unit of these.
        if found[key] != pytest.approx(row, rel=1e-6, abs=1e-20 + 1e-6 * max(map(abs, row), default=0.0)):
            off[key] = found[key], row
    assert off == {}, "if it is meant: python tests/make_expected.py"


@pytest.mark.parametrize("name", SLIPS)
def test_no_slip_is_found_otherwise_than_before(name: str) -> None:
    # Where a run becomes odd, a slip, or explained by a count, a threshold is met: the steps tell where it lies.
    found, expected = every_slip_found(name), SLIPS[name]
    assert len(found) == len(expected)
    off = [(at, *pair) for at, pair in enumerate(zip(found, expected, strict=True)) if not alike(*pair)]
    assert off == [], "if it is meant: python tests/make_expected.py"


def alike(found: list[float], expected: list[float]) -> bool:
    return len(found) == len(expected) and found == pytest.approx(expected, rel=1e-6)


class TestWhatIsBelieved:
    """A fit is an answer if it comes to rest near its start, near the readings and near a line of the textbook."""

    RESULT = fit_as_stated(lab(np.random.default_rng(1)))
    START = RESULT.inertia.value

    def refused(self, factor: float = 3.0, start: float = START, **changes: object) -> str:
        try:
            insist_on_solution(replace(self.RESULT.adjusted, **changes), start, factor)
        except NoFit as why:
            return str(why)
        return ""

    def test_it_is_finite_positive_and_came_to_rest(self) -> None:
        unknowns, covariance = self.RESULT.adjusted.unknowns, self.RESULT.adjusted.covariance
        assert self.refused() == ""
        for at in range(3):
            assert "not finite" in self.refused(unknowns=np.where(np.arange(3) == at, np.nan, unknowns))
        assert "not finite" in self.refused(covariance=np.where(np.eye(3) > 0, np.inf, covariance))
        assert "come to rest" in self.refused(converged=False)
        for inertia in (0.0, -4e-3):
            assert "not positive" in self.refused(unknowns=np.array([inertia, 0.0, 0.0]))

    @pytest.mark.parametrize("factor", [3.0, 30.0])
    def test_it_is_near_its_start_by_a_factor(self, factor: float) -> None:
        for start in (1 / factor, factor):
            inside, outside = 1 + (start < 1) * 1e-9 - (start > 1) * 1e-9, 1 - (start < 1) * 1e-9 + (start > 1) * 1e-9
            assert self.refused(factor, inside * start * self.START) == ""
            assert "by themselves are near" in self.refused(factor, outside * start * self.START)

    @pytest.mark.parametrize(("scene", "name"), [
        ("nine runs", "mass"), ("nine runs", "spin_scale"), ("nine runs", "position_zero"), ("torques", "torque"),
        ("the weight spins along", "g"), ("the weight spins along", "added"), ("tilted", "transverse_inertia"),
    ])  # fmt: skip
    def test_nothing_was_read_a_fifth_too_high_and_three_u_off(self, scene: str, name: str) -> None:
        measured = scenes()[scene]
        adjusted = fit_as_stated(measured, scene != "nine runs" and scene != "torques").adjusted
        problem = adjusted.problem
        at = next(s for s, source in enumerate(problem.sources) if source.name == name)
        which = next(k for k, s in zip(problem.to_column, problem.from_source, strict=True) if s == at)
        runs = [run for run, k in zip(problem.from_run, problem.to_column, strict=True) if k == which]
        read = np.abs(problem.observed[problem.quantity[at], runs])
        size = float(np.max((problem.absolute[at, runs] + problem.relative[at, runs] * read) / read))

        def refused(errors: float, share: float) -> bool:
            """With an error of so many u that is such a share of what was read."""
            wider = share / (errors * size)
            sizes = [np.where(np.arange(len(each))[:, None] == at, wider, 1.0) * each
                     for each in (problem.absolute, problem.relative)]  # fmt: skip
            shared = np.where(np.arange(len(adjusted.shared)) == which, -errors, 0.0)
            wide = replace(adjusted, problem=problem.reread(problem.observed, (sizes[0], sizes[1])), shared=shared)
            why = ""
            try:
                insist_on_solution(wide, float(adjusted.unknowns[0]), 3.0)
            except NoFit as refusal:
                why = str(refusal)
            assert not why or (name.replace("_", " ") in why and "more than 20 %" in why)
            return bool(why)

        measurable = name != "transverse_inertia"
        assert refused(3.01, 0.21) is measurable
        assert refused(30.0, 0.21) is measurable
        assert not refused(2.99, 0.21)
        assert not refused(3.01, 0.19)
        assert not refused(30.0, 0.19)
        # Runs that are left out say nothing.
        adjusted = replace(adjusted, kept=np.where(np.isin(np.arange(len(adjusted.kept)), runs), 0.0, 1.0))
        assert not refused(3.01, 0.21)

    @pytest.mark.parametrize("scene", ["nine runs", "one torque", "both sides", "tilted", "the weight spins along"])
    def test_a_line_of_the_textbook_is_near_by_a_factor_of_three(self, scene: str) -> None:
        measured, tilted = scenes()[scene], scene in ("tilted", "the weight spins along")
        result, kept = fit_as_stated(measured, tilted), np.ones(len(measured.runs))
        kept[2] = 0.0
        use = kept > 0
        rate = 2 * np.pi * measured.turns / measured.time * (1 if measured.slowing is None else measured.slowing)
        rate, spin, torque = (measured.sense * rate)[use], measured.spin[use], measured.torque[use]
        if tilted:
            height = np.sin(measured.pitch[use])
            torque = torque + fitting.transverse_inertia(measured)[use] * rate**2 * height
            spin = spin + rate * height
        x = rate * spin
        lines = [float(x @ torque / (x @ x))] + [float(np.polyfit(x, torque, 1)[0])] * (scene != "one torque")
        far = {"low": 3 * min(lines), "high": 3 * max(lines), "little": min(lines) / 3, "less": max(lines) / 3}

        def believed(inertia: float) -> bool:
            told = replace(result, inertia=replace(result.inertia, value=inertia))
            why = ""
            try:
                fitting.insist_on_lines(measured, told, tilted, kept)
            except NoFit as refusal:
                why = str(refusal)
            assert not why or all(f"{line:.2g}" in why for line in lines)
            return not why

        assert believed(far["high"] * (1 - 1e-9))
        assert not believed(far["high"] * (1 + 1e-9))
        assert believed(far["little"] * (1 + 1e-9))
        assert not believed(far["little"] * (1 - 1e-9))
        assert not believed(-result.inertia.value)

    def test_lines_without_a_torque_say_nothing(self) -> None:
        still = replace(scenes()["nine runs"], torque=np.zeros(9))
        with pytest.raises(NoFit, match="the lines of the textbook 0"):
            fitting.insist_on_lines(still, self.RESULT, False, np.ones(9))


def test_torques_differ_by_two_per_cent_of_the_largest() -> None:
    for sign in (1, -1):
        assert fitting.torques_differ(sign * np.array([0.05, 0.0489]))
        assert not fitting.torques_differ(sign * np.array([0.05, 0.0491]))
        assert not fitting.torques_differ(sign * np.array([0.05, 0.05]))
    assert fitting.torques_differ(np.array([-0.05, 0.05]))
    assert fitting.torques_differ(np.array([0.0, 0.05]))
    # Exactly so much is not more.
    assert not fitting.torques_differ(np.array([50.0, 49.0]))


def test_a_sample_is_even_in_torques_and_within_each() -> None:
    measured = lab(np.random.default_rng(2), repeats=60)
    kept = np.ones(540)
    assert fitting.sample(measured, kept[:150]).tolist() == list(range(150))
    kept[[5, 17, 300]] = 0.0
    taken = fitting.sample(measured, kept)
    assert len(set(taken.tolist())) == 150
    assert not set(taken.tolist()) & {5, 17, 300}
    assert taken.tolist() == sorted(taken.tolist())
    for torque in range(3):
        of_it = taken[taken // 180 == torque]
        assert len(of_it) == pytest.approx(50, abs=1)
        # Of every stretch of its runs about as many: by the golden ratio no two are far from even.
        gaps = np.diff(np.concatenate([[180 * torque - 1], of_it, [180 * torque + 180]]))
        assert gaps.max() <= 12
        assert np.bincount((of_it - 180 * torque) // 45) == pytest.approx(np.full(4, 12.5), abs=5)
    # With one run more than are enough, one is left out.
    assert len(fitting.sample(measured, np.arange(540) < 151)) == 150
    assert fitting.sample(measured, np.arange(540) < 150).tolist() == list(range(150))


def test_what_is_not_said_is_a_level_rod_steady_and_as_it_was_read() -> None:
    measured = scenes()["tilted"]
    stated, whole = fit_as_stated(measured), fit(measured)
    level = fit_as_stated(measured, False)
    assert (stated.inertia, stated.chi2) == (level.inertia, level.chi2)
    assert abs(fit_as_stated(measured, True).inertia.value / stated.inertia.value - 1) > 1e-5
    assert whole.inertia == fit(measured, False).inertia != fit(measured, True).inertia
    assert screen(measured)[1].inertia == screen(measured, False)[1].inertia  # type: ignore[union-attr]
    assert screen(measured)[1].inertia != screen(measured, True)[1].inertia  # type: ignore[union-attr]
    again = fitting.refit(whole, measured, False)
    assert again.inertia == fitting.refit(whole, measured, False, False).inertia
    assert again.imbalance.value != 0
    (one,) = fitting.fit_otherwise(measured, whole, [fitting.Otherwise()])
    assert one.interval_95 is not None
    chosen = fitting.ChosenModel(tilted=True, released=True, asked=False)
    assert chosen.earth is False
    let_go = scenes()["let go"]
    result = fit_as_stated(let_go, True)
    silent, said = (fitting.corrected(let_go, result, INERTIA, chosen, *more) for more in ((), (False,)))
    followed = fitting.corrected(let_go, result, INERTIA, chosen, True)
    assert (silent.slowing == said.slowing).all()  # type: ignore[union-attr]
    assert (silent.slowing != followed.slowing).any()  # type: ignore[union-attr]


@pytest.mark.parametrize("factor", [0.34, 0.6, 1.8, 2.9])
@pytest.mark.parametrize("imbalance", [-8e-3, 0.0, 8e-3])
def test_from_a_start_that_is_far_off_the_steps_end_at_the_same(factor: float, imbalance: float) -> None:
    measured = lab(np.random.default_rng(1), imbalance=1e-3)
    near = fit_as_stated(measured).adjusted
    problem, width = near.problem, float(np.abs(measured.torque).min())
    start = Start(factor * near.unknowns[0], imbalance)
    again = adjust(problem, measured.sense, start, width, np.ones(9), 3.0)
    assert again.unknowns == pytest.approx(near.unknowns, rel=1e-6, abs=1e-9)
    assert again.chi2 == pytest.approx(near.chi2, rel=1e-6)


class TestCorrections:
    """What the runs are corrected by, against the motion itself."""

    def measured(self) -> Measurements:
        nine = scenes()["tilted"]
        falling = {"spin_start": 1.3 * nine.spin, "spin_end": 0.75 * nine.spin}
        mean = np.array([physics.harmonic_mean_spin(1.3 * s, 0.75 * s) for s in nine.spin])
        return replace(nine, **falling, spin=mean * (1 + 0.01 * np.cos(np.arange(9))))

    def at(self, measured: Measurements, inertia: float, **model: bool) -> Measurements:
        chosen = fitting.ChosenModel(**{"tilted": True, "released": False, "asked": False} | model)
        followed = model.pop("followed", False)
        return fitting.corrected(measured, self.result(measured), inertia, chosen, followed)

    def result(self, measured: Measurements) -> fitting.FitResult:
        return fit_as_stated(measured, True)

    def test_the_mean_rate_of_a_falling_spin_is_its_integral(self) -> None:
        measured, inertia = self.measured(), 4.4e-3
        total = measured.torque + self.result(measured).imbalance.value
        across = fitting.transverse_inertia(measured)
        found = self.at(measured, inertia).slowing
        assert measured.spin_start is not None
        assert measured.spin_end is not None
        assert found is not None
        for i in range(9):
            start, end = float(measured.spin_start[i]), float(measured.spin_end[i])
            first = start * float(measured.spin[i]) / physics.harmonic_mean_spin(start, end)

            def rate(share: float, spin: float, ratio: float, i: int = i) -> float:
                """After a share of the time, in which the spin falls to a ratio."""
                lean = across[i], measured.pitch[i]
                return float(physics.precession_rate(total[i], spin * ratio**share, inertia, *lean))

            mean, _ = quad(rate, 0, 1, args=(first, end / start), epsrel=1e-13)
            assert found[i] == pytest.approx(rate(0.0, float(measured.spin[i]), 1.0) / mean, rel=1e-11)

    @pytest.mark.parametrize("lean", [True, False])
    def test_a_released_rod_goes_at_its_mean_rate_and_its_phase_is_in_doubt(self, lean: bool) -> None:
        measured = replace(scenes()["tilted"], added=2e-5 * np.arange(9))
        result, inertia = self.result(measured), 4.4e-3
        chosen = fitting.ChosenModel(tilted=lean, released=True, asked=False)
        runs = fitting.corrected(measured, result, inertia, chosen)
        total, across = measured.torque + result.imbalance.value, fitting.transverse_inertia(measured)
        whole = inertia + measured.added
        pitch = measured.pitch if lean else 0.0 * measured.pitch
        steady = physics.precession_rate(total, measured.spin, whole, across if lean else 0.0, pitch)
        top = motion.Top(whole, across, total)
        mean = motion.mean_precession_rate(top, motion.released(top, measured.spin, measured.pitch))
        assert runs.slowing == pytest.approx(steady / mean, rel=1e-13)
        nutation, release = runs.sources[-2:]
        assert (nutation.name, release.name) == ("nutation", "release")
        assert (nutation.shared, release.shared) == (False, True)
        assert nutation.default
        assert release.default
        assert nutation.absolute == pytest.approx(across / (whole * measured.spin) / math.sqrt(2), rel=1e-13)
        assert release.relative == pytest.approx(2 * 0.05 * np.abs(steady / mean - 1), rel=1e-11)
        assert not nutation.relative.any()
        assert not release.absolute.any()
        # Of a log without a pitch that gives I, I is known as well as it usually is, and without I less well.
        level = replace(measured, sources=measured.sources[:5])
        for stated, u in ((np.full(9, 7e-3), 0.02), (None, 0.2)):
            silent = replace(level, transverse_inertia=stated)
            runs = fitting.corrected(silent, result, inertia, chosen)
            assert runs.slowing is not None
            assert runs.sources[-1].relative == pytest.approx(2 * u * np.abs(runs.slowing - 1), rel=1e-9)
        assert fitting.unslowed(runs).slowing is None
        assert [one.name for one in fitting.unslowed(runs).sources] == [one.name for one in level.sources]

    def test_a_rod_that_is_followed_has_swept_its_turns_at_the_last_click(self) -> None:
        plain = replace(scenes()["tilted"], transverse_inertia=np.full(9, 7e-3))
        chosen, inertia = fitting.ChosenModel(tilted=True, released=True, asked=False), 4.4e-3
        result = self.result(plain)
        total = plain.torque + result.imbalance.value
        top = motion.Top(inertia, np.full(9, 7e-3), total)
        state = motion.released(top, plain.spin, plain.pitch)
        time = plain.time - result.timing_bias.value
        swept, mean = motion.precession_angle(top, state, time), motion.mean_precession_rate(top, state)
        steady = physics.precession_rate(total, plain.spin, inertia, 7e-3, plain.pitch)
        angle = 2 * np.pi * plain.turns
        click = 7e-3 / (inertia * plain.spin)
        for u_across, u_spin in ((0.0, 0.0), (0.02, 0.0), (0.0, 0.005), (0.004, 0.003)):
            names = {"transverse_inertia": u_across, "spin": u_spin, "spin_scale": 0.5 * u_spin}
            sources = tuple(
                replace(one, relative=np.full(9, names[one.name])) if one.name in names else one
                for one in plain.sources
            )
            measured = replace(plain, sources=sources)
            runs = fitting.corrected(measured, result, inertia, chosen, followed=True)
            phase = plain.time / click * math.sqrt(u_across**2 + 1.25 * u_spin**2)
            known = np.exp(-0.5 * phase**2)
            assert runs.slowing == pytest.approx(steady / mean * (1 - known * (swept - mean * time) / angle), rel=1e-11)
            assert runs.sources[-2].absolute == pytest.approx(click * np.sqrt((1 - known**2) / 2), rel=1e-9, abs=1e-15)

    def test_the_floor_turns_under_each_run(self) -> None:
        nine = scenes()["nine runs"]
        result, chosen = fit_as_stated(nine), fitting.ChosenModel(tilted=False, released=False, asked=False, earth=True)
        share = 7.292115e-5 * nine.time / (2 * math.pi * nine.turns)
        turned = np.array([1.0, -1, 1, -1, 0, 1, 1, 0, -1])
        for latitude, sense, vertical, signs in (
            (None, None, 1.0, nine.sense),
            (0.7, turned, math.sin(0.7), np.where(turned == 0, nine.sense, turned)),
            (-0.7, -turned, -math.sin(0.7), np.where(turned == 0, nine.sense, -turned)),
        ):
            there = replace(nine, latitude=latitude, precession_sense=sense)
            floor = fitting.turn_of_floor(there, result)
            assert floor == pytest.approx(signs * vertical * share, rel=1e-13)
            assert fitting.corrected(there, result, 4e-3, chosen).slowing == pytest.approx(1 + floor, rel=1e-15)
            slow = fitting.corrected(replace(there, slowing=np.full(9, 1.1)), result, 4e-3, chosen).slowing
            assert slow == pytest.approx(1.1 * (1 + floor), rel=1e-15)
        ones = np.ones(9)
        told = {(None, None): False, (0.0, None): False, (None, 1): False, (0.0, 0): False, (0.0, 1): True}
        for (latitude, value), expected in told.items():
            sense = None if value is None else np.where(np.arange(9) == 3, value, ones)
            assert fitting.earth_is_told(replace(nine, latitude=latitude, precession_sense=sense)) is expected

    def test_what_needs_no_correction_is_left_alone(self) -> None:
        nine, tilted = scenes()["nine runs"], self.measured()
        level = fitting.ChosenModel(tilted=False, released=False, asked=False)
        assert fitting.iterate_mean_rate(nine, level) is nine
        assert fitting.iterate_mean_rate(tilted, level) is tilted
        steady = fitting.ChosenModel(tilted=True, released=False, asked=False)
        assert fitting.iterate_mean_rate(scenes()["tilted"], steady) is scenes()["tilted"]
        runs = fitting.iterate_mean_rate(tilted, steady, left_out=[3])
        assert runs.slowing is not None
        # Fit and correction go together.
        result = fit_as_stated(runs, True, [3])
        again = fitting.corrected(tilted, result, result.inertia.value, steady)
        assert again.slowing == pytest.approx(runs.slowing, rel=1e-8)
        assert steady.name == "steady"
        assert level.name == "horizontal"
        assert fitting.ChosenModel(tilted=True, released=True, asked=False).name == "released"


def exact(**options: object) -> Measurements:
    return lab(np.random.default_rng(0), noise=0.0, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("imbalance", [0.0, 2e-3, -2e-3, 8e-3])
def test_exact_readings_give_back_the_truth(imbalance: float) -> None:
    result = fit_as_stated(exact(imbalance=imbalance))
    assert result.inertia.value == pytest.approx(INERTIA, rel=1e-4)  # the broad prior of M0 pulls by 1e-5
    # The prior of all designs pulls a large M0 a little: by a small part of u, never the other way.
    whole = fit(exact(imbalance=imbalance))
    assert whole.inertia.value == pytest.approx(INERTIA, abs=0.25 * whole.inertia.u)
    assert result.imbalance.value == pytest.approx(imbalance, abs=1e-5)
    assert result.chi2 < 1e-2


def test_torques_of_both_signs_and_an_unloaded_run() -> None:
    both = exact(positions=(0.15, -0.15), imbalance=1e-3)
    assert fit(both).inertia.value == pytest.approx(INERTIA, rel=1e-5)
    assert fit(exact(unloaded=True, imbalance=6e-4)).imbalance.value == pytest.approx(6e-4, rel=1e-4)


def latent_least_squares(measured: Measurements) -> tuple[float, float]:
    """The same problem by another method: every true reading is an unknown of one big least-squares problem."""
    count = len(measured.runs)
    time, spin, spin_scale, mass, zero = measured.sources
    weights = max(mass.groups) + 1

    def model(p: np.ndarray) -> np.ndarray:
        inertia, imbalance, bias = p[0] * 1e-3, p[1] * 1e-3, p[2]
        e_spin, e_scale, e_zero = p[3 : 3 + count], p[3 + count], p[4 + count]
        e_mass = p[5 + count : 5 + count + weights]
        true_spin = measured.spin / (1 + spin.relative * e_spin + spin_scale.relative * e_scale)
        true_mass = measured.mass / (1 + mass.relative * e_mass[list(mass.groups)])
        torque = true_mass * G * (measured.position - zero.absolute * e_zero)
        predicted = 2 * np.pi * measured.turns * inertia * true_spin / np.abs(torque + imbalance) + bias
        priors = [p[1] * 1e-3 / np.abs(measured.torque).min(), p[2] / measured.timing_bias_u, *p[3:]]
        return np.concatenate([(measured.time - predicted) / time.absolute, priors])

    start = np.zeros(5 + count + weights)
    start[0] = 4.0
    solution = least_squares(model, start, method="trf", xtol=1e-15, ftol=1e-15, gtol=1e-15, jac="3-point")
    cov = np.linalg.inv(solution.jac.T @ solution.jac)
    return solution.x[0] * 1e-3, math.sqrt(cov[0, 0]) * 1e-3


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_agrees_with_least_squares_in_all_true_readings(seed: int) -> None:
    measured = lab(np.random.default_rng(seed), repeats=2, imbalance=2e-3, bias=0.04)
    value, u = latent_least_squares(measured)
    result = fit_as_stated(measured)
    assert result.inertia.value == pytest.approx(value, rel=2e-7)
    assert result.inertia.u == pytest.approx(u, rel=1e-5)


@pytest.mark.parametrize(
    ("repeats", "weights", "close"),
    # Where M0 is hardly told, u is 5 % of I_zz, and nothing is linear.
    [(2, (0.02, 0.04, 0.06), 0.05), (1, (0.02, 0.04, 0.06), 0.05), (3, (0.1, 0.12), 0.35)],
)
def test_agrees_with_the_posterior_by_plain_integration(repeats: int, weights: tuple[float, ...], close: float) -> None:
    # Times are normal about the model with a covariance that is written down whole; I_zz, M0 and s on a dense grid.
    measured = lab(np.random.default_rng(4), repeats=repeats, weights=weights, imbalance=5e-4, bias=0.04)
    result = fit(measured)
    time, spin, spin_scale, mass, zero = measured.sources
    lightest = float(np.abs(measured.torque).min())
    inertias = result.inertia.value + np.linspace(-8, 8, 161) * result.inertia.u
    imbalances = result.imbalance.value + np.linspace(-8, 8, 121) * result.imbalance.u
    lever = 2 * np.pi * measured.turns * measured.spin
    same = np.equal.outer(np.array(mass.groups), np.array(mass.groups))
    at = lever * result.inertia.value / (measured.torque + result.imbalance.value)
    by_torque = at * measured.torque / (measured.torque + result.imbalance.value)
    shared = measured.timing_bias_u**2 + spin_scale.relative[0] ** 2 * np.outer(at, at)
    shared = shared + np.outer(by_torque, by_torque) * (mass.relative[0] ** 2 * same + (zero.absolute[0] / 0.15) ** 2)
    total = np.zeros(len(inertias))
    predicted = lever * inertias[:, None, None] / (measured.torque + imbalances[:, None])
    residual = measured.time - predicted
    for factor in np.exp(np.linspace(math.log(0.15), math.log(12), 80)):
        covariance = shared + factor**2 * np.diag(time.absolute**2 + (spin.relative * at) ** 2)
        inverse, (_, size) = np.linalg.inv(covariance), np.linalg.slogdet(covariance)
        chi2 = np.einsum("abi,ij,abj->ab", residual, inverse, residual)
        log_factor = math.log(factor)
        prior = 0.95 * math.exp(-0.5 * (log_factor / math.log(3.5)) ** 2) / (math.log(3.5) * math.sqrt(2 * math.pi))
        prior += 0.05 / (math.pi * math.log(5) * (1 + (log_factor / math.log(5)) ** 2))
        cauchy = 1 / (1 + (imbalances / (0.05 * lightest)) ** 2)
        total += prior * (np.exp(-0.5 * (chi2 + size) + 200) * cauchy).sum(axis=1)
    below = (np.cumsum(total) - total / 2) / total.sum()
    told = (result.inertia.interval_95[0], result.inertia.value, result.inertia.interval_95[1])
    off = (np.array(told) - np.interp((0.025, 0.5, 0.975), below, inertias)) / result.inertia.u
    assert off == pytest.approx(np.zeros(3), abs=close)


@pytest.mark.parametrize(("imbalance", "repeats"), [(0.0, 1), (1.5e-3, 1), (0.0, 3)])
def test_coverage_and_bias(imbalance: float, repeats: int) -> None:
    random = np.random.default_rng(11)
    labs = 400
    results = [
        fit(lab(random, repeats=repeats, imbalance=imbalance, bias=0.05 * random.standard_normal()))
        for _ in range(labs)
    ]
    errors = np.array([(r.inertia.value - INERTIA) / r.inertia.u for r in results])
    # Three standard deviations of a binomial of 400; few runs tell their own scatter badly, so u is on the long side.
    assert 0.63 < np.mean(np.abs(errors) < 1) < 0.80
    inside = [r.inertia.interval_95[0] <= INERTIA <= r.inertia.interval_95[1] for r in results]
    assert 0.92 < np.mean(inside) < 0.99
    assert abs(errors.mean()) < 3 / math.sqrt(labs) + 0.25 * (imbalance > 0)


def test_unknown_sense_of_an_unloaded_run_is_covered() -> None:
    random = np.random.default_rng(5)
    errors = []
    for _ in range(150):
        result = fit(lab(random, unloaded=True, sensed=False, imbalance=-5e-4))
        errors.append((result.inertia.value - INERTIA) / result.inertia.u)
    assert np.mean(np.abs(errors) < 2) > 0.90


@pytest.mark.parametrize("sensed", [True, False])
def test_what_finer_readings_would_give_is_what_a_fit_of_them_gives(sensed: bool) -> None:
    measured = lab(np.random.default_rng(5), u_mass=0.02, imbalance=1e-4, unloaded=True, sensed=sensed)
    result = fit(measured)
    assert result.two_signs != sensed
    for name in ("mass", "time"):
        sources = tuple(
            replace(one, relative=0.2 * one.relative, absolute=0.2 * one.absolute) if one.name == name else one
            for one in measured.sources
        )
        exact = fit(replace(measured, sources=sources)).inertia
        (near,), (rough,) = (
            fitting.fit_otherwise(measured, result, [fitting.Otherwise({name: 0.2})], rough) for rough in (False, True)
        )
        assert (rough.value, rough.u) == pytest.approx((near.value, near.u), rel=1e-6)
        assert exact.u is not None
        # Two signs of M0 make two answers, and what is less known so is added to all that is otherwise.
        close = 0.01 if sensed else 0.1
        assert near.value == pytest.approx(exact.value, abs=close * exact.u)
        assert near.u == pytest.approx(exact.u, rel=close)


def test_rows_as_independent_would_understate_u() -> None:
    measured = exact(repeats=3)
    alone = replace(
        measured,
        sources=tuple(
            replace(source, groups=np.arange(len(measured.runs))) if source.name != "spin_scale" else source
            for source in measured.sources
        ),
    )
    assert fit(measured).inertia.u > 1.02 * fit(alone).inertia.u


@settings(deadline=None, max_examples=30, derandomize=True)
@given(factor=st.floats(0.01, 100), seed=st.integers(0, 1000))
def test_scaling_all_masses_scales_the_inertia(factor: float, seed: int) -> None:
    measured = lab(np.random.default_rng(seed))
    heavier = replace(measured, mass=measured.mass * factor, torque=measured.torque * factor)
    first, second = fit(measured), fit(heavier)
    assert second.inertia.value == pytest.approx(first.inertia.value * factor, rel=1e-8)
    assert second.inertia.u == pytest.approx(first.inertia.u * factor, rel=1e-6)


def test_order_of_the_runs_does_not_matter() -> None:
    measured = lab(np.random.default_rng(3))
    order = [4, 0, 8, 2, 7, 1, 5, 3, 6]
    from gyrodata.measurements import select

    assert fit(select(measured, order)).inertia.value == pytest.approx(fit(measured).inertia.value, rel=1e-10)


def test_budget_adds_up() -> None:
    result = fit(lab(np.random.default_rng(2), repeats=2))
    assert math.fsum(share.share for share in result.budget) == pytest.approx(1)
    assert math.fsum(share.u_inertia**2 for share in result.budget) == pytest.approx(result.inertia.u**2, rel=1e-9)


def test_a_torque_of_runs_without_a_say_leaves_no_m0_to_be_found() -> None:
    measured = lab(np.random.default_rng(3), weights=(0.04, 0.06), rpm=(200.0, 400.0, 600.0))
    for fitted in (fit, fit_as_stated):
        # Of three runs of one torque I_zz takes one degree of freedom, of six of two M0 another.
        assert fitted(measured).dof == 4
        assert fitted(measured, left_out=[3, 4, 5]).dof == 2
        assert fitted(measured, left_out=[5]).dof == 3


def test_the_budget_names_what_makes_the_answer_uncertain_and_nothing_else() -> None:
    measured = scenes()["nine runs"]
    last = np.where(np.arange(9) == 8, 0.01, 0.0)
    angle = Source("angle", "turns", np.arange(9), last, np.zeros(9), "", True, "")
    measured = replace(measured, sources=(*measured.sources, angle))
    names = {share.source for share in fit(measured).budget}
    assert names == {"time", "spin", "spin_scale", "mass", "position_zero", "angle", "residual_torque", "time_bias"}
    # What only a run has that has no say, or what is known exactly, is not in it.
    assert {share.source for share in fit(measured, left_out=[8]).budget} == names - {"angle"}
    assert "time_bias" not in {share.source for share in fit(replace(measured, timing_bias_u=0.0)).budget}


def test_exact_parts_need_no_ridge() -> None:
    measured = exact(repeats=2)
    bare = replace(
        measured,
        sources=tuple(
            source if source.name == "position_zero" else replace(source, absolute=0 * source.absolute,
                                                                   relative=0 * source.relative)
            for source in measured.sources
        ),
        timing_bias_u=0.0,
    )  # fmt: skip
    result = fit(bare)
    assert result.inertia.value == pytest.approx(INERTIA, rel=1e-8)
    # One arm, one zero: the relative error of the arm is that of I_zz, however many runs there are.
    assert result.inertia.u / INERTIA == pytest.approx(0.0005 / 0.15, rel=1e-2)


class TestFewRuns:
    def test_one_torque_rests_on_the_balance(self) -> None:
        measured = exact(weights=(0.04,))
        result, balanced = fit(measured), fit(replace(measured, balanced=True))
        assert result.inertia.value == pytest.approx(INERTIA, rel=1e-4)
        share = next(s for s in result.budget if s.source == "residual_torque")
        assert share.share > 0.9
        # Half of the 68.3 % interval of a Cauchy of 5 % is 9.2 %.
        assert result.inertia.u / INERTIA == pytest.approx(0.092, rel=0.1)
        assert balanced.inertia.u < 0.3 * result.inertia.u
        told = fitting.if_balanced(measured, result)
        assert (told.value, told.u) == pytest.approx((balanced.inertia.value, balanced.inertia.u), rel=0.02)

    def test_one_run(self) -> None:
        result = fit(exact(weights=(0.04,), rpm=(400.0,)))
        assert result.inertia.value == pytest.approx(INERTIA, rel=1e-4)
        assert result.inertia.u > 0
        assert result.dof == 0

    def test_two_runs_of_two_torques(self) -> None:
        result = fit(exact(weights=(0.02, 0.06), rpm=(400.0,)))
        assert result.inertia.value == pytest.approx(INERTIA, rel=2e-4)
        assert result.dof == 0

    def test_identical_runs(self) -> None:
        measured = exact(weights=(0.04,), rpm=(400.0,), repeats=4)
        assert fit(measured).inertia.value == pytest.approx(INERTIA, rel=1e-4)

    def test_times_as_short_as_their_error(self) -> None:
        random = np.random.default_rng(8)
        short = []
        for _ in range(60):
            measured = lab(random, weights=(0.2, 0.4), repeats=2, turns=1 / 3, u_time=0.3)
            with suppress(NoFit):
                short.append(fit(measured))
        # Where the times are mostly error, some labs tell nothing.
        assert len(short) > 45
        assert all(r.adjusted.converged for r in short)
        values = np.array([r.inertia.value for r in short])
        assert (values > 0.2 * INERTIA).all()
        assert (values < 3 * INERTIA).all()
        assert np.isfinite([r.inertia.u for r in short]).all()


class TestBalance:
    def test_a_true_test_narrows_the_answer(self) -> None:
        measured = exact()
        widths = (None, 1e-3, 1e-4, 1e-5, 1e-6, 0.0)
        u = []
        for width in widths:
            test = None if width is None else lambda inertia, width=width: width
            u.append(fit(replace(measured, imbalance_u=test, imbalance_from="u_imbalance")).inertia.u)
        # A tighter true test is never quoted worse.
        assert all(after <= 1.002 * before for before, after in pairwise(u))
        assert u[-1] < 0.85 * u[0]

    def test_a_contradicted_test_loses(self) -> None:
        measured = exact(imbalance=6e-3)
        tested = replace(measured, imbalance_u=lambda inertia: 1e-5, imbalance_from="u_imbalance")
        result, free = fit(tested), fit(measured)
        assert result.contradicted_balance == pytest.approx(1e-5)
        assert result.inertia.value == pytest.approx(free.inertia.value, abs=0.2 * free.inertia.u)
        assert result.inertia.u == pytest.approx(free.inertia.u, rel=0.25)

    def test_doubt_widens_before_it_wins(self) -> None:
        tests = {"imbalance_u": lambda inertia: 1e-4, "imbalance_from": "u_imbalance"}
        results = [fit(replace(exact(imbalance=size), **tests)) for size in (0.0, 6e-4, 6e-3)]
        assert results[0].inertia.u < results[1].inertia.u
        assert results[0].contradicted_balance is None
        assert results[2].contradicted_balance == pytest.approx(1e-4)


def test_influence_is_what_leaving_out_does() -> None:
    measured = lab(np.random.default_rng(12), repeats=2)
    whole = fit(measured)
    for run in (0, 7, 17):
        changed = fit(measured, left_out=(run,)).inertia.value - whole.inertia.value
        assert whole.influence[run] == pytest.approx(changed, rel=0.1, abs=0.05 * whole.inertia.u)


class TestScreening:
    def test_clean_labs_raise_no_alarm(self) -> None:
        random = np.random.default_rng(21)
        assert sum(len(screen(lab(random, imbalance=5e-4))[0]) for _ in range(200)) == 0

    @pytest.mark.parametrize(("run", "written", "true"), [(4, 3.0, 2.0), (0, 1.0, 2.0), (8, 1.0, 3.0), (3, 2.0, 1.0)])
    def test_a_wrong_count_is_named(self, run: int, written: float, true: float) -> None:
        random = np.random.default_rng(run)
        measured = lab(random)
        time, turns = measured.time.copy(), measured.turns.copy()
        time[run] *= true
        turns[run] = written
        outliers, _ = screen(replace(measured, time=time, turns=turns))
        assert [(o.index, o.turns) for o in outliers] == [(run, true)]

    @pytest.mark.parametrize("true", [1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 1, 2, 5, 12, 30])
    def test_every_count_that_is_likely_is_found(self, true: float) -> None:
        # Also far from what was written, and whatever was.
        for written in {1.0, 7.0} - {true}:
            measured = lab(np.random.default_rng(4), noise=0.1, u_time=0.01, u_spin=1e-4, turns=written)
            off = np.where(np.arange(9) == 4, true / written, 1.0)
            outliers, _ = screen(replace(measured, time=measured.time * off))
            assert [(o.index, o.turns) for o in outliers] == [(4, true)]

    @pytest.mark.parametrize("true", [1 / 3, 1 / 2, 2 / 3, 2, 3])
    def test_a_count_that_is_wrong_for_all_runs_of_a_torque_is_found(self, true: float) -> None:
        for group in (0, 2):
            measured = lab(np.random.default_rng(4), noise=0.2)
            wrong = np.arange(9) // 3 == group
            counted = replace(measured, time=measured.time * np.where(wrong, true, 1.0))
            assert explaining_counts(counted) == [{group: true}]
        assert explaining_counts(measured) == []
        # Six of nine runs are two torques: fewer are changed by taking the third for wrong.
        both = replace(measured, time=measured.time * np.where(np.arange(9) < 3, 1.0, true))
        assert all(len(answer) <= 2 for answer in explaining_counts(both))

    def test_a_third_of_the_runs_may_be_odd_and_no_more(self) -> None:
        def odd(count: int) -> list[int]:
            measured = lab(np.random.default_rng(4), noise=0.3)
            time = measured.time.copy()
            time[[0, 4, 8, 5][:count]] *= [1.5, 0.7, 1.6, 0.6][:count]
            return [o.index for o in screen(replace(measured, time=time))[0]]

        assert (odd(1), odd(2), odd(3), odd(4)) == ([0], [0, 4], [0, 4, 8], [])

    def test_a_slip_is_what_has_a_count_or_is_far_off(self) -> None:
        def found(factor: float) -> tuple[float | None, bool]:
            measured = lab(np.random.default_rng(4), noise=0.1)
            ((odd, *_), _) = screen(replace(measured, time=measured.time * np.where(np.arange(9) == 4, factor, 1.0)))
            return odd.turns, odd.slip

        assert found(1.08) == (None, False)
        assert found(1.30) == (None, True)
        assert found(2.0) == (2.0, True)

    def test_a_watch_that_was_stopped_at_once_timed_no_turn_at_all(self) -> None:
        measured = lab(np.random.default_rng(4), noise=0.1)
        for short in (0.0, 0.05, 0.3):
            outliers, _ = screen(replace(measured, time=np.where(np.arange(9) == 4, short, measured.time)))
            assert [(odd.index, odd.turns, odd.slip) for odd in outliers] == [(4, None, True)]

    def test_one_bad_timing_without_a_count_is_named_without_one(self) -> None:
        measured = lab(np.random.default_rng(4), repeats=2)
        time = measured.time.copy()
        time[5] *= 1.12
        outliers, _ = screen(replace(measured, time=time))
        assert [(o.index, o.turns) for o in outliers] == [(5, None)]
        assert outliers[0].deviation > 5

    def test_gross_errors_kept_in_the_fit_do_not_break_it(self) -> None:
        # A weak ruler and tight times: a fit by the raw conditions would shrink I_zz and the arm to nothing.
        measured = lab(np.random.default_rng(6), weights=tuple(0.01 * k for k in range(3, 12)), u_zero=0.01)
        turns = measured.turns.copy()
        turns[[3, 4]] = 1.5
        assert 2e-3 < fit(replace(measured, turns=turns)).inertia.value < 8e-3


class TestOrdinaryLine:
    def test_agrees_with_closed_forms(self) -> None:
        random = np.random.default_rng(7)
        x = random.uniform(1, 9, 12)
        y = 3 * x + 2 + random.standard_normal(12)
        line = ordinary_line(x, y, intercept=True)
        slope, intercept = np.polyfit(x, y, 1)
        assert line is not None
        assert line.intercept is not None
        assert line.slope.value == pytest.approx(slope, rel=1e-12)
        assert line.intercept.value == pytest.approx(intercept, rel=1e-11)
        residuals = y - slope * x - intercept
        u = math.sqrt(residuals @ residuals / 10 / np.sum((x - x.mean()) ** 2))
        assert line.slope.u == pytest.approx(u, rel=1e-12)
        origin = ordinary_line(x, y, intercept=False)
        assert origin is not None
        assert origin.slope.value == pytest.approx(x @ y / (x @ x), rel=1e-13)

    def test_certified_line_through_the_origin(self) -> None:
        # NIST StRD NoInt1: b = 2.07438016528926, standard error 0.165289256198347E-01.
        x, y = np.arange(60.0, 71.0), np.arange(130.0, 141.0)
        line = ordinary_line(x, y, intercept=False)
        assert line is not None
        assert line.slope.value == pytest.approx(2.07438016528926, rel=1e-14)
        assert line.slope.u == pytest.approx(0.165289256198347e-01, rel=1e-13)

    def test_many_labs_at_once_are_each_lab_alone(self) -> None:
        random = np.random.default_rng(8)
        x = random.uniform(1, 9, (5, 12))
        y = 3 * x + 2 + random.standard_normal(x.shape)
        for name, intercept in (("through_origin", False), ("with_constant", True)):
            slopes, u = fitting.TEXTBOOK[name](x, y)
            for i in range(len(x)):
                line = ordinary_line(x[i], y[i], intercept)
                assert line is not None
                assert (slopes[i], u[i]) == pytest.approx((line.slope.value, line.slope.u), rel=1e-13)
        mean, u = fitting.TEXTBOOK["mean_of_ratios"](x, y)
        np.testing.assert_allclose(mean, (y / x).mean(axis=1), rtol=1e-13)
        np.testing.assert_allclose(u, (y / x).std(axis=1, ddof=1) / math.sqrt(12), rtol=1e-13)

    def test_no_spread_is_no_slope(self) -> None:
        assert ordinary_line(np.full(5, 3.0), np.arange(5.0), intercept=True) is None

    def test_one_point_has_no_u(self) -> None:
        line = ordinary_line(np.array([2.0]), np.array([4.0]), intercept=False)
        assert line is not None
        assert line.slope == fitting.Estimate(2.0, None)


@pytest.mark.parametrize("dof", [1, 2, 3, 8, 25, 400])
@pytest.mark.parametrize("chi2", [0.0, 0.3, 5.0, 27.5, 420.0, 3000.0])
def test_chi_square_tail(chi2: float, dof: int) -> None:
    assert fitting.chi2_tail(chi2, dof) == pytest.approx(gammaincc(dof / 2, chi2 / 2), rel=1e-11, abs=1e-300)


def test_a_source_knows_if_it_is_shared() -> None:
    zeros = np.zeros(3)
    assert Source("mass", "mass", np.array([0, 0, 1]), zeros, zeros, "", True, "").shared
    assert not Source("mass", "mass", np.array([0, -1, -1]), zeros, zeros, "", True, "").shared


def test_response_adds_up_where_the_balance_is_known() -> None:
    # With M0 and b fixed, inertias that are all 1 % high make I_zz 1 % high.
    measured = replace(exact(), imbalance_u=lambda inertia: 0.0, timing_bias_u=0.0)
    result = fit(replace(measured, balanced=True))
    assert result.response.sum() == pytest.approx(1, rel=2e-2)
    assert (result.response > 0).all()


def test_uncertainty_agrees_with_gtc() -> None:
    # Two runs and two unknowns: the answer is a formula, and GTC propagates the readings' errors through it.
    from GTC import uncertainty, ureal, value

    measured = replace(lab(np.random.default_rng(2), weights=(0.02, 0.06), rpm=(400.0,)), timing_bias_u=0.0)
    scale, zero = ureal(1, 0.001), ureal(0, 0.0005)
    levers, swings, torques = [], [], []
    for i in range(2):
        spin = float(measured.spin[i])
        levers.append(2 * math.pi * ureal(spin, 0.002 * spin) * scale)
        swings.append(ureal(float(measured.time[i]), 0.14))
        mass = float(measured.mass[i])
        torques.append(ureal(mass, 0.002 * mass) * measured.g * (float(measured.position[i]) + zero))
    # M T = I L − M0 T for both runs.
    efforts = [torque * swing for torque, swing in zip(torques, swings, strict=True)]
    inertia = (efforts[1] * swings[0] - efforts[0] * swings[1]) / (levers[1] * swings[0] - levers[0] * swings[1])
    result = fit_as_stated(measured)
    assert result.inertia.value == pytest.approx(value(inertia), rel=2e-3)  # the broad prior of M0 pulls a little
    assert result.inertia.u == pytest.approx(uncertainty(inertia), rel=2e-2)


@pytest.mark.parametrize("weights", [(0.02, 0.04), (0.02, 0.06)])
def test_with_two_torques_the_wrong_count_is_blamed_not_the_right_ones(weights: tuple[float, ...]) -> None:
    # A large M0 would make two good runs odd in its place.
    random = np.random.default_rng(8)
    for wrong in range(6):
        measured = lab(random, weights=weights)
        turns = measured.turns.copy()
        turns[wrong] = 2
        outliers, _ = screen(replace(measured, turns=turns))
        assert [(outlier.index, outlier.turns) for outlier in outliers] == [(wrong, 1)]
