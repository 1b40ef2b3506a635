"""No wrong number in silence: where there is no answer to believe, there is none, and words that help."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from fuzz.clean import draw_clean
from labs import INERTIA, lab
from msgspec.structs import replace

import gyrodata
from gyrodata import fitting
from gyrodata.errors import Diagnostic, LogError
from gyrodata.measurements import measure
from gyrodata.procedure import check_log
from gyrodata.readings import read_log

SAMPLES = Path(__file__).parent.parent / "sample_data"
CORPUS = Path(__file__).parent / "fuzz" / "corpus"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"


def refusal(log: str | bytes, **options: object) -> Diagnostic:
    """The one error that a log is refused with, by `analyze` and by `check` alike."""
    data = log.encode() if isinstance(log, str) else log
    with pytest.raises(LogError) as caught:
        gyrodata.analyze(data, **options)  # type: ignore[arg-type]
    (error,) = [d for d in caught.value.diagnostics if d.severity == "error"]
    if not options:
        assert error in [d for d in check_log(read_log(data))[1] if d.severity == "error"]
    return error


def cycled(runs: int, weights: int, seed: int = 1) -> str:
    """Clean runs whose weights come round in turn."""
    random = np.random.default_rng(seed)
    masses = np.linspace(20, 60, weights)[np.arange(runs) % weights]
    spins = random.uniform(200, 600, runs)
    times = 2 * np.pi * INERTIA * spins * np.pi / 30 / (masses * 1e-3 * 9.803 * 0.15) / 3
    times += 0.14 * random.standard_normal(runs)
    rows = zip(masses, spins, times, strict=True)
    return HEAD + "".join(f"{m:.2f},15.0,{s:.1f},{t:.2f},1/3\n" for m, s, t in rows)


class TestLargeLogs:
    @pytest.mark.parametrize(
        ("runs", "weights"), [(150, 2), (200, 2), (299, 3), (300, 3), (449, 3), (600, 5), (3000, 3)]
    )
    def test_weights_that_come_round_in_turn(self, runs: int, weights: int) -> None:
        found = gyrodata.analyze(cycled(runs, weights).encode()).inertia
        assert found.u is not None
        assert abs(found.value - INERTIA) < 4 * found.u
        assert found.u < 0.02 * INERTIA

    @pytest.mark.parametrize("seed", range(30))
    def test_three_hundred_runs_of_three_weights(self, seed: int) -> None:
        found = gyrodata.analyze(cycled(300, 3, seed).encode()).inertia
        assert found.value == pytest.approx(INERTIA, rel=0.04)

    def test_the_sample_to_start_from_has_every_torque(self) -> None:
        measured = measure(read_log(cycled(3000, 5).encode()))
        index = fitting.sample(measured, np.ones(3000))
        assert len(index) == len(set(index.tolist())) == 150
        assert np.bincount(index % 5).min() >= 29

    def test_leaving_out_a_large_torque_is_as_leaving_out_a_small_one(self) -> None:
        """By the side of the runs and by the side of the unknowns: the same number."""
        for repeats in (1, 2, 12):
            measured = lab(np.random.default_rng(2), repeats=repeats)
            adjusted = fitting.fit(measured).adjusted
            groups = measured.by_torque
            rest = np.eye(len(groups[0])) - adjusted.orthogonal[groups[0]] @ adjusted.orthogonal[groups[0]].T
            gain = adjusted.gain[groups[0]]
            own = np.stack([adjusted.weighted[groups[0]], gain], axis=-1)
            assert adjusted.without(groups)[0] == pytest.approx(tuple(gain @ np.linalg.solve(rest, own)), rel=1e-9)

    def test_many_odd_runs_are_counted(self) -> None:
        lines = cycled(900, 3).splitlines()
        lines[2:602:3] = [line.replace("1/3", "1") for line in lines[2:602:3]]
        found = [d for d in gyrodata.analyze("\n".join(lines).encode()).diagnostics if d.code == "G410"]
        assert len(found) == 101
        assert found[-1].message.startswith("100 more runs look odd")


class TestRunaway:
    def test_exact_clocks_give_no_number(self) -> None:
        exact = {"u_time": "0 s", "u_spin": "0 %"}
        error = refusal((SAMPLES / "air_gyroscope.csv").read_bytes(), settings=exact)
        assert error.code == "G421"
        assert "# u_time: 0.14 s" in error.hint
        # The hint, carried out.
        advised = dict(re.findall(r"# (u_\w+): ([\d.]+ [s%])", error.hint))
        assert advised.keys() == exact.keys()
        found = gyrodata.analyze((SAMPLES / "air_gyroscope.csv").read_bytes(), settings=advised).inertia
        assert found.value == pytest.approx(INERTIA, rel=0.01)

    @pytest.mark.parametrize("name", ["only-u_mass-left", "only-u_position_zero-left", "only-u_mass_scale-left"])
    def test_one_scale_that_could_shrink_all(self, name: str) -> None:
        assert refusal((CORPUS / f"{name}.csv").read_bytes()).code == "G421"

    def test_an_adjusted_reading_stays_where_it_was_read(self) -> None:
        measured = lab(np.random.default_rng(1))
        adjusted = fitting.fit(measured).adjusted
        fitting.insist_on_solution(adjusted, INERTIA, 3.0)
        scale = next(s for s, source in enumerate(adjusted.problem.sources) if source.name == "spin_scale")
        column = adjusted.problem.member[scale, 0]
        adjusted.shared[column] = 300.0
        with pytest.raises(fitting.NoFit, match="what was read as spin scale is off by more than 20 %"):
            fitting.insist_on_solution(adjusted, INERTIA, 3.0)

    def test_what_is_far_from_the_start_is_no_solution(self) -> None:
        adjusted = fitting.fit(lab(np.random.default_rng(1))).adjusted
        with pytest.raises(
            fitting.NoFit, match=r"ends at 0\.004\d kg\*m\^2, where the runs by themselves are near 0\.02"
        ):
            fitting.insist_on_solution(adjusted, 0.02, 3.0)

    def test_a_line_of_the_textbook_is_near(self) -> None:
        measured = lab(np.random.default_rng(1))
        fit = fitting.fit(measured)
        fitting.insist_on_lines(measured, fit, tilted=False, kept=np.ones(9))
        slow = measured.spin * 5
        with pytest.raises(fitting.NoFit, match="the lines of the textbook"):
            fitting.insist_on_lines(replace(measured, spin=slow), fit, False, np.ones(9))

    @pytest.mark.parametrize("seed", range(40))
    def test_clean_logs_hold_the_truth(self, seed: int) -> None:
        found = gyrodata.analyze(draw_clean(seed).encode()).inertia
        assert found.u is not None
        assert abs(found.value - INERTIA) < 5 * found.u


KEYS = {
    **{f"u_{key}": "0 s" for key in ("time", "time_bias", "spin_delay")},
    **{f"u_{key}": "0 %" for key in ("spin", "spin_scale", "mass", "mass_scale", "g", "turns")},
    **{f"u_{key}": "0 mm" for key in ("position", "position_zero")},
}
"""Every uncertainty as none."""


def nine_runs(stated: dict[str, str], noise: float, runs: tuple[tuple[float, float], ...] = ()) -> str:
    """Write runs of a level rod, with errors of spin and time or without."""
    random = np.random.default_rng(1)
    text = "".join(f"# {key}: {value}\n" for key, value in stated.items()) + HEAD
    for m, s in runs or product((20.0, 40.0, 60.0), (200.0, 400.0, 600.0)):
        time = 2 * np.pi * INERTIA * s * np.pi / 30 / (m * 1e-3 * 9.803 * 0.15)
        spin, time = s * (1 + 0.002 * noise * random.standard_normal()), time + 0.14 * noise * random.standard_normal()
        text += f"{m:.2f},15.0,{spin:.13g},{time:.13g},1\n"
    return text


class TestZeroUncertainties:
    @pytest.mark.parametrize("name", ["all-uncertainties-zero", "all-uncertainties-zero-both-sides"])
    def test_runs_that_scatter_are_refused(self, name: str) -> None:
        text = (CORPUS / f"{name}.csv").read_text()
        error = refusal(text)
        assert error.code == "G421"
        assert "times as much as the stated uncertainties allow" in error.message
        for line in re.findall(r"# (u_\w+: [\d.]+ [s%])", error.hint):
            text = re.sub(rf"# {line.split(':')[0]}: .*", f"# {line}", text)
        assert gyrodata.analyze(text.encode()).inertia.value == pytest.approx(INERTIA, rel=0.02)

    def test_one_run_has_the_balance_to_rest_on(self) -> None:
        text = (CORPUS / "all-uncertainties-zero-one-run.csv").read_text()
        found = gyrodata.analyze(f"# u_spin_delay: 0 s\n{text}".encode())
        assert found.inertia.value == pytest.approx(4.43e-3, rel=0.02)
        assert [share.source for share in found.budget] == ["residual_torque"]

    def test_runs_that_agree_exactly_have_an_answer(self) -> None:
        keys = ("time", "time_bias", "spin", "spin_scale", "mass", "mass_scale", "position", "position_zero", "g")
        zero = "".join(f"# u_{key}: 0 {'s' if 'time' in key else '%'}\n" for key in keys if key != "position_zero")
        rows = "".join(
            f"{m:.2f},15.0,{s:.1f},{2 * np.pi * INERTIA * s * np.pi / 30 / (m * 1e-3 * 9.803 * 0.15)!r},1\n"
            for m, s in product((20.0, 40.0, 60.0), (200.0, 400.0))
        )
        found = gyrodata.analyze(f"{zero}# u_position_zero: 0 mm\n{HEAD}{rows}".encode()).inertia
        assert found.value == pytest.approx(INERTIA, rel=1e-8)

    @pytest.mark.parametrize("kept", KEYS)
    @pytest.mark.parametrize("others", [False, True], ids=["one zero", "all others zero"])
    def test_any_of_them_zero_is_an_answer_or_words(self, kept: str, others: bool) -> None:
        zero = {key: text for key, text in KEYS.items() if (key != kept) == others}
        for noise in (0.0, 1.0):
            try:
                found = gyrodata.analyze(nine_runs(zero, noise).encode()).inertia
            except LogError:
                assert others
                continue
            assert found.u is not None
            assert abs(found.value - INERTIA) < 3 * found.u + 1e-8 * INERTIA
            assert found.u > (0.002 if noise else 1e-10) * INERTIA

    def test_two_runs_without_any_uncertainty_tell_none(self) -> None:
        error = refusal(nine_runs(KEYS, 1.0, ((20.0, 400.0), (60.0, 400.0))))
        assert "no run is left over to tell how well the others agree" in error.message


class TestScales:
    @pytest.mark.parametrize("percent", [10, 20, 30, 50])
    @pytest.mark.parametrize("key", ["u_spin_scale", "u_mass_scale", "u_position_zero", "u_mass", "u_g", "u_spin"])
    @pytest.mark.parametrize("others", [False, True], ids=["others usual", "others zero"])
    def test_a_scale_that_is_hardly_known(self, key: str, percent: int, others: bool) -> None:
        stated = {**(KEYS if others else {}), key: f"{1.5 * percent} mm" if "zero" in key else f"{percent} %"}
        exact = gyrodata.analyze(nine_runs(stated, 0.0).encode()).inertia
        assert exact.u is not None
        assert exact.value == pytest.approx(INERTIA, rel=1e-3)
        # The errors of three weights average out in part, those of nine spins more.
        share = {"u_mass": 0.5, "u_spin": 0.05}.get(key, 0.97)
        assert share * percent / 100 < exact.u / INERTIA < 1.05 * percent / 100
        try:
            found = gyrodata.analyze(nine_runs(stated, 1.0).encode()).inertia
        except LogError as refused:
            if not others:
                # An interval that reaches zero is no measurement, and the key that does it is named.
                assert percent == 50
                (error,) = [d for d in refused.diagnostics if d.severity == "error"]
                assert error.code == "G435"
                assert key in error.hint
            return
        assert found.u is not None
        assert abs(found.value - INERTIA) < 1.5 * found.u
        assert 0.8 * exact.u < found.u < 1.3 * exact.u


class TestReleased:
    @pytest.mark.parametrize("slip", ["time-in-minutes", "time-in-thousands", "mass-in-kg-as-g"])
    def test_a_unit_slip_is_told_in_words(self, slip: str) -> None:
        error = refusal((CORPUS / f"released-{slip}.csv").read_bytes())
        assert error.code == "G421"
        assert "look for a wrong unit of time, spin, mass or position" in error.hint


class TestCounts:
    """A lab times 1/3, 2/3 and 1 turn, and writes one count in every row."""

    @pytest.mark.parametrize("path", sorted((SAMPLES / "class").glob("*.csv")), ids=lambda path: path.name)
    @pytest.mark.parametrize("count", ["1/3", "2/3", "1"])
    def test_every_log_of_the_class(self, path: Path, count: str) -> None:
        lines = path.read_bytes().decode("utf-8", "replace").splitlines()
        start = next((i for i, line in enumerate(lines) if re.search(r"\bturns\b|;N;", line)), None)
        if start is None:
            pytest.skip("no log")
        delimiter = ";" if ";" in lines[start] else ","
        heads = [head.strip() for head in lines[start].split(delimiter)]
        column = heads.index("turns" if "turns" in heads else "N")
        true: dict[float, str] = {}
        for i, line in enumerate(lines[start + 1 :], start + 1):
            cells = line.split(delimiter)
            true[float(cells[0]) * (1e3 if "kg" in heads[0] else 1)] = cells[column]
            cells[column] = count
            lines[i] = delimiter.join(cells)
        assert set(true.values()) == {"1/3", "2/3", "1"}
        error = refusal("\n".join(lines))
        assert error.code == "G420"
        likeliest = error.message.partition("; or else")[0]
        for grams, turns in true.items():
            named = re.search(rf"{grams:g}\.?0* g at [\d.]+ cm fit ([\d/]+) turn", likeliest)
            assert (named and named[1]) == (None if turns == count else turns)

    def test_the_sample(self) -> None:
        text = re.sub(r",(1/3|2/3|1),ccw", ",1/3,ccw", (SAMPLES / "air_gyroscope.csv").read_text())
        error = refusal(text)
        assert error.message.endswith(
            "the runs of 39.99 g at 15.00 cm fit 2/3 turn, not 1/3, those of 60.04 g at 15.00 cm fit 1 turn, not 1/3"
        )
        # What it advises gives the answer.
        for mass, turns in (("39.99", "2/3"), ("60.04", "1")):
            text = re.sub(rf"({mass},.*),1/3,ccw", rf"\1,{turns},ccw", text)
        lab = gyrodata.analyze(text.encode())
        assert lab.inertia.value == gyrodata.analyze(SAMPLES / "air_gyroscope.csv").inertia.value

    def test_two_weights_are_told_only_where_nothing_fits(self) -> None:
        times = {20: (13.3, 26.6), 40: (13.3, 26.6)}
        rows = "".join(f"{m}.00,15.0,{s},{t},1\n" for m in times for s, t in zip((134.5, 269), times[m], strict=True))
        assert refusal(HEAD + rows).code in ("G420", "G421")

    def test_more_than_one_way_is_told_as_such(self) -> None:
        text = re.sub(r",(1/3|2/3|1),ccw", ",1,ccw", (SAMPLES / "air_gyroscope.csv").read_text())
        message = refusal(text).message
        assert "20.00 g at 15.00 cm fit 1/3 turn, not 1, those of 39.99 g at 15.00 cm fit 2/3 turn, not 1" in message
        other = "those of 39.99 g at 15.00 cm fit 2 turns, not 1, those of 60.04 g at 15.00 cm fit 3 turns, not 1"
        assert message.endswith(f"; or else {other}")

    @pytest.mark.parametrize("imbalance", [0.0, 3e-3, -3e-3])
    @pytest.mark.parametrize("seed", range(10))
    def test_a_lab_without_a_slip_is_never_blamed(self, imbalance: float, seed: int) -> None:
        measured = lab(np.random.default_rng(seed), imbalance=imbalance, noise=2.0)
        assert fitting.explaining_counts(measured) == []


def test_no_fit_that_runs_on_is_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyrodata.fitting.adjustment.TURNS", 2)
    with pytest.raises(fitting.NoFit, match="does not come to rest"):
        fitting.fit(lab(np.random.default_rng(1)))
