"""No wrong number in silence: where there is no answer to believe, there is none, and
words that help.
"""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest
from gates.drawn_logs import INERTIA, Bench, draw, write
from msgspec.structs import astuple
from places import ACCEPTANCE, SAMPLES
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata.analysis import check_log
from gyrodata.base.errors import Diagnostic, LogError
from gyrodata.readings import read_log

SAMPLE = (SAMPLES / "air_gyroscope.csv").read_text(encoding="utf-8")
CORPUS = ACCEPTANCE / "fuzz" / "corpus"
HEAD = "# g: 9.803 m/s^2\n# motion: steady\nmass [g],position [cm],spin [rpm],time [s],turns\n"
KEYS = {
    **{f"u_{key}": "0 s" for key in ("time", "time_bias", "spin_delay")},
    **{
        f"u_{key}": "0 %"
        for key in ("spin", "spin_scale", "mass", "mass_scale", "g", "turns")
    },
    **{f"u_{key}": "0 mm" for key in ("position", "position_zero")},
}
"""Every uncertainty as none."""


def refusal(log: str) -> Diagnostic:
    """The one error that a log is refused with, by `analyze` and by `check` alike."""
    with pytest.raises(LogError) as caught:
        gyrodata.analyze(log.encode())
    (error,) = [d for d in caught.value.diagnostics if d.severity == "error"]
    assert astuple(error) in map(astuple, check_log(read_log(log.encode()))[1])
    return error


# --- uncertainties stated as none, or as very large ---


def nine_runs(stated: dict[str, str], noise: float) -> str:
    """Write runs of a level rod, with errors of spin and time or without."""
    random = np.random.default_rng(1)
    text = "".join(f"# {key}: {value}\n" for key, value in stated.items()) + HEAD
    for m, s in product((20.0, 40.0, 60.0), (200.0, 400.0, 600.0)):
        time = 2 * np.pi * INERTIA * s * np.pi / 30 / (m * 1e-3 * 9.803 * 0.15)
        spin, time = (
            s * (1 + 0.002 * noise * random.standard_normal()),
            time + 0.14 * noise * random.standard_normal(),
        )
        text += f"{m:.2f},15.0,{spin:.13g},{time:.13g},1\n"
    return text


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["all-uncertainties-zero", "all-uncertainties-zero-both-sides", ""]
)
def test_exact_readings_that_scatter_are_refused_and_the_hint_works(name: str) -> None:
    text = (
        (CORPUS / f"{name}.csv").read_text()
        if name
        else f"# u_time: 0 s\n# u_spin: 0 %\n{SAMPLE}"
    )
    text = f"# motion: steady\n{text}"
    error = refusal(text)
    assert error.code == "G421"
    assert (
        not name or "times as much as the stated uncertainties allow" in error.message
    )
    for line in re.findall(r"# (u_\w+: [\d.]+ [s%])", error.hint):
        text = re.sub(rf"# {line.split(':')[0]}: .*", f"# {line}", text)
    assert analyze_briefly(text.encode()).inertia.value == pytest.approx(
        INERTIA, rel=0.02
    )


@pytest.mark.slow
def test_one_exact_run_has_the_uncertainty_of_the_balance() -> None:
    text = (CORPUS / "all-uncertainties-zero-one-run.csv").read_text()
    found = gyrodata.analyze(f"# motion: steady\n# u_spin_delay: 0 s\n{text}".encode())
    assert found.inertia.value == pytest.approx(4.43e-3, rel=0.02)
    assert [share.source for share in found.budget] == ["residual_torque"]


def test_the_hint_shows_how_far_apart_the_runs_of_a_weight_are() -> None:
    error = refusal(
        "mass [g],position [cm],spin [rpm],time [s],turns\n"
        "35.0,14.2,250,13.19,1\n35.0,14.2,430,2.7,1\n35.0,14.2,610,320,1\n"
        "55.0,14.2,250,8.39,1\n55.0,14.2,430,140.3,1\n55.0,14.2,610,20.47,1\n"
    )
    assert error.code == "G421"
    low, high = re.findall(r"35\.0\d* g[^:]*: ([\d.]+) to ([\d.]+)", error.hint)[0]
    assert float(low) < 0.001 < 0.01 < float(high)


def test_two_runs_without_any_uncertainty_are_refused() -> None:
    *head, first, _, _, _, _, _, _, last, _ = nine_runs(KEYS, 1.0).splitlines()
    assert (
        "the runs are too few to show how well they agree"
        in refusal("\n".join([*head, first, last])).message
    )


@pytest.mark.slow
@pytest.mark.parametrize("percent", [10, 50])
@pytest.mark.parametrize("key", ["u_spin_scale", "u_position_zero", "u_mass", "u_spin"])
@pytest.mark.parametrize("others", [False, True], ids=["others usual", "others zero"])
def test_a_scale_that_is_hardly_known_is_in_u(
    key: str, percent: int, others: bool
) -> None:
    stated = {
        **(KEYS if others else {}),
        key: f"{1.5 * percent} mm" if "zero" in key else f"{percent} %",
    }
    exact = analyze_briefly(nine_runs(stated, 0.0).encode()).inertia
    assert exact.u is not None
    # A log that is silent about the delay of the spin is corrected for it.
    truth = INERTIA if others else INERTIA / 1.002
    assert exact.value == pytest.approx(truth, rel=1e-3)
    # The errors of three weights average out in part, those of nine spins more.
    share = {"u_mass": 0.5, "u_spin": 0.05}.get(key, 0.97)
    assert share * percent / 100 < exact.u / INERTIA < 1.05 * percent / 100
    try:
        found = analyze_briefly(nine_runs(stated, 1.0).encode()).inertia
    except LogError as refused:
        # An interval that reaches zero is no measurement, and the key that does it is
        # named.
        (error,) = [d for d in refused.diagnostics if d.severity == "error"]
        assert others or (percent, error.code, key in error.hint) == (50, "G435", True)
        return
    assert found.u is not None
    assert abs(found.value - INERTIA) < 1.5 * found.u


# --- a lab that times 1/3, 2/3 and 1 turn, and writes one count in every row ---


@pytest.mark.slow
@pytest.mark.parametrize("count", ["1/3", "2/3", "1"])
def test_one_count_for_all_weights_is_refused_and_explained(count: str) -> None:
    table = draw(Bench(thirds=True), 0)
    weights = dict(zip(table.mass, table.turns.copy(), strict=True))
    table.turns[:] = count
    error = refusal(write(table))
    assert error.code == "G420"
    likeliest = error.message.partition("; or else")[0]
    for grams, turns in weights.items():
        named = re.search(
            rf"{grams:g}\.?0* g at [\d.]+ cm fit ([\d/]+) turn", likeliest
        )
        assert (named and named[1]) == (None if turns == count else turns)
        table.turns[table.mass == grams] = turns
    # The advice is followed.
    assert analyze_briefly(write(table).encode()).inertia.value == pytest.approx(
        INERTIA, rel=0.05
    )


def test_released_rods_that_no_inertia_explains_are_refused() -> None:
    rows = "1222.15,91.98,198,0.0603,2.5\n1222.15,68.99,598,0.1957,2\n"
    rows += "2411.85,91.98,615,0.0939,2.5\n3774.46,68.99,203,0.0105,1"
    head = "# transverse_inertia: 6e-3 kg*m^2\n# g: 9.803 m/s^2\n"
    log = f"{head}mass [g],position [cm],spin [rpm],time [s],turns\n{rows}\n"
    with pytest.raises(LogError, match="G425"):
        gyrodata.analyze(log.encode(), model="released")
