"""From a log to its result: published logs, doubts, hints that are followed, and runs
left out.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from gates.drawn_logs import Bench, draw, write
from places import ROOT
from simulated_labs import analyze_briefly
from typer.testing import CliRunner

import gyrodata
from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import LogError
from gyrodata.cli import app
from gyrodata.judging.tables import NamedFit

SAMPLES = ROOT / "sample_data"

# Arm [m] and three timings [s] (published student data); the "period" is 40° of
# precession.
ARMS = """0.12 8.13 8.16 8.35; 0.15 6.28 6.46 6.41; 0.18 4.87 5.25 5.25; 0.21 4.44 4.22 4.60;
    0.24 4.03 3.78 4.00; 0.27 3.65 3.75 3.56; 0.3 3.28 3.03 2.97"""
# Decimal commas (published student data, github.com/aidenfmunro/Labs, 1.2.5); spin 392
# turns a second.
COMMAS = """0,074 139,48; 0,092 110,54; 0,116 88,06; 0,141 72,22;
    0,179 59,91; 0,218 46,70; 0,272 37,85; 0,340 29,95"""


def seven_arms() -> str:
    text = (
        '"Mass, m (kg)","Radius,r (m)","Spin Speed,N (rpm)","Precession period,T (s)"\n'
    )
    for at, arm in enumerate(ARMS.split(";")):
        x, *times = arm.split()
        text += (
            f"{'' if at else '0.15'},{x},{'' if at else '4585'},{times[0]}\n"
            f",,,{times[1]}\n,,,{times[2]}\n"
        )
    return text


def decimal_commas() -> str:
    rows = (
        f"{at};{row.split()[0]};0,122;{row.split()[1]};1\n"
        for at, row in enumerate(COMMAS.split(";"), 1)
    )
    return "№;m, кг;l, м;t, с;N\n" + "".join(rows)


def published(analysis: gyrodata.Analysis, name: str) -> NamedFit:
    return next(fit for fit in analysis.fits if fit.name == name)


def codes(analysis: gyrodata.Analysis) -> set[str]:
    return {found.code for found in analysis.diagnostics}


class TestPublished:
    @pytest.mark.slow
    def test_heidelberg(self) -> None:
        a = gyrodata.analyze(SAMPLES / "heidelberg_ball.csv")
        assert published(a, "through_origin").inertia.value == pytest.approx(
            0.00423, abs=5e-6
        )
        assert published(a, "with_constant").inertia.value == pytest.approx(
            0.00483, abs=5e-6
        )
        assert published(a, "with_constant").constant.value == pytest.approx(
            -4.2e-3, abs=0.05e-3
        )
        assert a.inertia.value == pytest.approx(0.00483, abs=1.5 * a.inertia.u)
        # The torque at work is larger than m g x: 25 % of the lightest.
        assert a.residual_torque.value == pytest.approx(
            4.2e-3, abs=1.5 * a.residual_torque.u
        )
        assert "G433" in codes(a)
        assert not any(run.flagged for run in a.run_table)

    @pytest.mark.slow
    def test_salort_has_one_torque(self) -> None:
        a = gyrodata.analyze(SAMPLES / "salort_one_torque.csv")
        line = published(a, "with_constant")
        assert line.inertia is None
        assert "all torques are equal" in line.note
        assert published(a, "through_origin").inertia.value == pytest.approx(
            0.00430, abs=3e-5
        )
        assert a.inertia.value == pytest.approx(0.00430, abs=1.5 * a.inertia.u)
        assert "G414" in codes(a)

    @pytest.mark.slow
    def test_seven_arms(self) -> None:
        a = gyrodata.analyze(
            seven_arms().encode(),
            settings={"angle": "40 deg"},
            mapping={"time": "Precession period,T (s)"},
        )
        assert published(a, "through_origin").inertia.value == pytest.approx(
            0.00415, abs=1e-5
        )
        assert [t.runs for t in a.torques] == [3] * 7

    @pytest.mark.slow
    def test_decimal_commas(self) -> None:
        a = gyrodata.analyze(decimal_commas().encode(), settings={"spin": "392 Hz"})
        assert published(a, "through_origin").inertia.value == pytest.approx(
            0.000794, abs=1e-6
        )
        assert a.inertia.value == pytest.approx(0.000794, abs=1.5 * a.inertia.u)
        assert [run.run for run in a.run_table if run.flagged] == ["5"]
        assert not any(run.left_out for run in a.run_table), (
            "a run without an explanation stays"
        )


@pytest.mark.slow
def test_the_sample_is_recovered() -> None:
    a = gyrodata.analyze(SAMPLES / "air_gyroscope.csv")
    assert abs(a.inertia.value - 4.44e-3) < 2 * a.inertia.u
    assert abs(a.residual_torque.value - 6e-4) < 2 * a.residual_torque.u
    assert a.inertia.interval_95[0] < 4.44e-3 < a.inertia.interval_95[1]
    assert all(
        abs(law.exponent - 1) < 3 * law.u
        for law in a.power_law
        if law.exponent is not None
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", sorted(SAMPLES.glob("*.csv")), ids=lambda path: path.stem
)
def test_what_only_a_report_shows_changes_no_number(path: Path) -> None:
    whole, brief = gyrodata.analyze(path), analyze_briefly(path)
    for name in ("inertia", "residual_torque", "run_table", "explanations"):
        assert getattr(brief, name) == getattr(whole, name)


def test_the_sample_is_what_its_maker_makes() -> None:
    import make_sample_data

    assert {
        target.read_text(encoding="utf-8") for target in make_sample_data.TARGETS
    } == {make_sample_data.make()}


@pytest.mark.slow
def test_u_contains_what_the_runs_scatter_more_than_stated() -> None:
    log = explanations()["G411"].example
    bold, honest = (
        gyrodata.analyze(log.replace("0.01 s", u).encode()) for u in ("0.01 s", "0.4 s")
    )
    assert bold.inertia.u == pytest.approx(honest.inertia.u, rel=0.5)
    assert bold.budget[0].source == "unexplained_scatter"
    assert honest.fit.widths.scatter < 2 < bold.fit.widths.scatter


def printed(log: str) -> str:
    done = CliRunner().invoke(app, ["analyze", "-", "--no-report"], input=log)
    return " ".join(done.output.split())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("hand", [0.14, 0.5])
def test_u_is_said_to_include_the_scatter_only_if_the_runs_of_a_weight_show_it(
    seed: int, hand: float
) -> None:
    table = draw(Bench(hand=hand), seed)
    if hand < 0.5:
        # The balance weight was moved with each weight: M0 is +5, -5 and 0 % of the
        # lightest torque.
        m0 = np.repeat([0.05, -0.05, 0.0], 3) * table.mass[0] / table.mass
        table = table._replace(time=np.round(table.time / (1 + m0), 2))
    log = write(table)
    within = analyze_briefly(log.encode(), name="<stdin>").constancy
    text = printed(log)
    assert within is not None
    assert within.p >= 0.05 or hand == 0.5
    if "u already includes this" in text:
        assert within.p < 0.05
    elif " times as much as the timing uncertainty" in text:
        assert "the runs of one weight agree, but the weights do not" in text


@pytest.mark.slow
def test_a_scatter_that_no_weight_can_show_is_not_said_to_be_in_u() -> None:
    # One run of each weight.
    table = draw(Bench(masses=(20, 30, 40, 50, 60), spins=(400,), hand=2.0), 0)
    text = printed(write(table))
    assert "times as much as the timing uncertainty" in text
    assert "u includes this if every run has an error of its own" in text


BALL = "# ball_mass: 4.302 kg\n# ball_diameter: 101.6 mm\n"


def ball_finding(log: str) -> list[gyrodata.Diagnostic]:
    return [
        one
        for one in gyrodata.analyze(log.encode()).diagnostics
        if one.code in ("G443", "G459")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "too_long"), [(1, -0.006), (2, 0.006)])
def test_an_arm_that_is_off_is_a_finding_if_the_ball_is_known(
    seed: int, too_long: float
) -> None:
    right = write(draw(Bench(), seed, 0.4 * 4.302 * 0.0508**2), BALL)
    arms = f"{100 * (0.15 + too_long):.1f}"
    wrong = right.replace(",15.0,", f",{arms},")
    assert not ball_finding(right)
    (finding,) = ball_finding(wrong)
    edge = "far" if too_long > 0 else "near"
    assert f"not to its {edge} edge" in finding.hint
    # The proposed length is the mistake that was made.
    (millimetres,) = re.findall(r"positions ([\d.]+) mm", finding.hint)
    assert float(millimetres) == pytest.approx(6, abs=4)
    assert CliRunner().invoke(app, ["check", "-"], input=wrong).exit_code == 1


@pytest.mark.slow
def test_a_ball_that_is_hardly_known_is_no_reason_to_doubt_the_runs() -> None:
    log = write(draw(Bench(), 0, 0.4 * 4.302 * 0.0508**2), BALL).replace(
        ",15.0,", ",14.0,"
    )
    vague = log.replace("4.302 kg", "4.3 ± 0.3 kg")
    assert ball_finding(log)
    assert not ball_finding(vague)


class TestHints:
    @pytest.mark.slow
    def test_a_hand_stated_later_leaves_no_pattern(self) -> None:
        late = write(draw(Bench(repeats=3, late=0.6), 2), "# u_time_bias: 0.05 s")
        found = next(
            d for d in gyrodata.analyze(late.encode()).diagnostics if d.code == "G431"
        )
        assert "s later than stated" in found.message
        hint = found.hint.partition("# ")[2].partition(",")[0]
        assert float(
            hint.removeprefix("u_time_bias: ").removesuffix(" s")
        ) == pytest.approx(1.2, abs=0.3)
        mended = gyrodata.analyze(late.replace("u_time_bias: 0.05 s", hint).encode())
        assert "G431" not in codes(mended)
        assert abs(mended.inertia.value - 4.44e-3) < 2 * mended.inertia.u

    @pytest.mark.slow
    def test_a_ball_that_is_said_not_to_be_balanced_is_not_warned_of(self) -> None:
        silent = gyrodata.analyze(SAMPLES / "heidelberg_ball.csv")
        assert "# balanced: no" in next(
            d.hint for d in silent.diagnostics if d.code == "G433"
        )
        told = gyrodata.analyze(
            SAMPLES / "heidelberg_ball.csv", settings={"balanced": "no"}
        )
        assert "G433" not in codes(told)
        # What the line with a constant gives, which knows nothing of the balance.
        line = next(fit.inertia for fit in told.fits if fit.name == "with_constant")
        assert abs(told.inertia.value - line.value) < abs(
            silent.inertia.value - line.value
        )

    @pytest.mark.slow
    def test_an_interval_that_holds_zero_is_no_measurement(self) -> None:
        log = explanations()["G435"].example
        with pytest.raises(
            LogError,
            match=r"G435: I_zz is not measured: its 95 % interval, -(.|\n)*u_time: check",
        ):
            gyrodata.analyze(log.encode())
        assert (
            gyrodata.analyze(
                log.replace("100 s", "0.1 s").encode()
            ).inertia.interval_95[0]
            > 0
        )


@pytest.mark.slow
def test_advice_is_computed_and_in_order_of_gain() -> None:
    advice = gyrodata.analyze(SAMPLES / "air_gyroscope.csv").advice
    gains = [float(line.split(" to ")[-1].removesuffix(" %")) for line in advice]
    assert len(gains) >= 2
    assert gains == sorted(gains)


@pytest.mark.slow
def test_a_gross_slip_is_left_out_and_kept_it_is_refused() -> None:
    table = draw(Bench(thirds=True), 3)
    clean = gyrodata.analyze(write(table).encode())
    table.time[7] = 1004
    log = write(table).encode()
    slipped = gyrodata.analyze(log)
    assert [run.run for run in slipped.run_table if run.left_out] == ["8"]
    (found,) = (found for found in slipped.diagnostics if found.code == "G410")
    assert "left out" in found.message
    assert "--keep-flagged" in found.hint
    assert slipped.inertia.value == pytest.approx(
        clean.inertia.value, abs=2 * clean.inertia.u
    )
    with pytest.raises(
        LogError, match=r"error G421: no single I_zz(.|\n)*omit keep_flagged"
    ):
        gyrodata.analyze(log, keep_flagged=True)


@pytest.mark.slow
def test_a_wrong_count_of_one_weight_is_doubted_with_its_remedy() -> None:
    # 4.5 turns were written of a weight that was timed for 5, and the fit blames
    # another weight.
    log = (
        "# g: 9.80665\nmass [g],position [cm],spin [rpm],time [s],turns\n20.1,14.8,197,97.46,5\n"
        "20.1,14.8,407,199.41,5\n20.1,14.8,613,302.93,5\n40.3,14.8,196,48.63,4.5\n"
        "40.3,14.8,416,103.32,4.5\n"
        "40.3,14.8,586,145.12,4.5\n60.2,14.8,195,32.21,5\n60.2,14.8,404,66.57,5\n"
        "60.2,14.8,598,98.89,5\n"
    )
    found = gyrodata.analyze(log.encode())
    assert "contradiction" in [doubt.kind for doubt in found.doubts]
    assert any(
        "all 3 runs of 40.3 g at 14.8 cm would agree with the others if they had 5 turns"
        in each.words
        for each in found.explanations
    )
    # Its remedy: the turns of each weight, not only of those.
    right = gyrodata.analyze(log.replace(",4.5", ",5").encode())
    assert (right.doubts, right.inertia.value) == ((), pytest.approx(4.4e-3, rel=0.01))
