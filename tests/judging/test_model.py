"""The ladder of models: what is chosen, what it costs, and what it saves."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from msgspec.structs import asdict, replace
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata import physics
from gyrodata.judging import changes
from gyrodata.quantities.units import Uncertainty
from gyrodata.results import FittedLog
from gyrodata.trials.simulation import EXACT, TYPICAL, Design, Truth, simulate

RPM = math.pi / 30
UP_AND_DOWN = (math.radians(-30), math.radians(30))


def made(noise: dict[str, Uncertainty] = TYPICAL, **truth: Any) -> str:
    design = {
        name: truth.pop(name)
        for name in ("masses", "spins", "pitches", "turns")
        if name in truth
    }
    return simulate(Truth(**truth), Design(**design), noise).log


def analysed(log: str, model: str = "auto") -> FittedLog:
    """Fit a log, and compute the sizes of all effects."""
    found = analyze_briefly(log.encode(), model)  # type: ignore[arg-type]
    return replace(found, effects=changes.list_effects(found.lab))


def simulated(**truth: object) -> str:
    """A log without errors that states no uncertainty, so that the usual ones are
    taken.
    """
    return "".join(
        line
        for line in made(EXACT, **truth).splitlines(True)
        if not line.startswith("# u_")
    )


def effect(analysis: FittedLog, name: str) -> dict[str, Any]:
    """Return one row of the table of effects."""
    return next(asdict(found) for found in analysis.effects if found.effect == name)


@pytest.mark.slow
@pytest.mark.parametrize("pitches", [(0.0,), (math.radians(2),)])
def test_sizes_of_effects_are_the_same_if_they_are_computed_again(
    pitches: tuple[float, ...],
) -> None:
    """The choice of the model has computed some of them already."""
    analysis = analysed(simulated(pitches=pitches))
    assert changes.list_effects(replace(analysis.lab, effects=())) == analysis.effects


@pytest.mark.slow
def test_a_slight_tilt_is_left_out_and_a_strong_one_kept() -> None:
    slight = analysed(made(pitches=(math.radians(2),)))
    strong = analysed(made(pitches=UP_AND_DOWN[1:], spins=(150 * RPM, 300 * RPM)))
    assert (slight.model.name, strong.model.name) == ("horizontal", "steady")
    assert not effect(slight, "tilt")["kept"]
    assert effect(slight, "tilt")["size"] < 0.2
    assert effect(strong, "tilt")["kept"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "tilt"), [("horizontal", False), ("steady", True), ("released", True)]
)
def test_a_model_that_is_asked_for_is_used(model: str, tilt: bool) -> None:
    log = made(pitches=UP_AND_DOWN)
    analysis = gyrodata.analyze(log.encode(), model=model)  # type: ignore[arg-type]
    assert analysis.to_dict()["result"]["model"] == analysis.model.name == model
    assert effect(analysis, "tilt")["kept"] is tilt
    assert "as asked" in effect(analysis, "tilt")["reason"]


@pytest.mark.slow
@pytest.mark.parametrize("model", ["horizontal", "steady", "released"])
@pytest.mark.parametrize("motion", ["steady", "released"])
def test_the_reason_of_a_model_that_is_asked_for_is_the_request(
    model: str, motion: str
) -> None:
    """Such a model is not kept because the runs show it, whatever they show."""
    log = made(motion=motion, pitches=(math.radians(3),), spins=(400 * RPM,))
    for row in map(asdict, analysed(log, model).effects):
        assert "kept because" not in row["reason"]
        if row["effect"] == "release" and motion == "released":
            assert "as the log says" in row["reason"] or row["kept"]
        if row["effect"] == "release" and row["kept"]:
            assert "as asked" in row["reason"]
            assert "as the log says" not in row["reason"]


@pytest.mark.slow
def test_no_release_is_assumed_or_advised_if_the_rod_would_have_fallen() -> None:
    """The largest weight makes a rod at 48 rpm fall; the spin read while it sags is
    larger than the one that is conserved."""
    masses, spins = (0.025, 0.05, 0.075), (48 * RPM, 90 * RPM, 130 * RPM)
    log = simulated(motion="released", masses=masses, spins=spins, turns=(5,))
    with pytest.raises(gyrodata.GyroError, match="G425"):
        analysed(log)
    silent = gyrodata.analyze(log.replace("# motion: released\n", "").encode())
    assert not effect(silent, "release")["kept"]
    assert not any("motion: released" in one.hint for one in silent.diagnostics)


@pytest.mark.slow
def test_a_stated_release_that_is_dropped_is_not_called_an_assumption() -> None:
    log = made(motion="released", masses=(0.02,), spins=(600 * RPM,))
    row = effect(analysed(log), "release")
    assert not row["kept"]
    assert "released, as the log says" in row["reason"]
    assert "assumed" not in row["reason"]


@pytest.mark.slow
def test_a_log_of_a_released_rod_has_that_model() -> None:
    analysis = analysed(
        made(motion="released", masses=(0.06, 0.12), spins=(150 * RPM, 200 * RPM))
    )
    assert analysis.model.name == "released"
    assert abs(analysis.inertia.value - 4.44e-3) < 3 * analysis.inertia.u
    assert {"nutation", "release"} <= {share.source for share in analysis.budget}
    # Two runs do not show the phase of the nutation.
    two = analysed(
        made(EXACT, motion="released", spins=(400 * RPM,), masses=(0.02, 0.06))
    )
    assert abs(two.inertia.value - 4.44e-3) < 3 * two.inertia.u
    assert two.inertia.u > 1e-3 * 4.44e-3


RELEASED = {
    "motion": "released",
    "imbalance": 2e-4,
    "spins": (60 * RPM, 100 * RPM, 200 * RPM),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("release", RELEASED | {"turns": (2 / 3,)}),
        ("release", RELEASED | {"turns": (1 / 3,), "masses": (0.0, 0.02, 0.04, 0.06)}),
        (
            "tilt",
            {"spins": (20 * RPM, 60 * RPM, 200 * RPM), "pitches": (math.radians(-85),)},
        ),
        ("tilt", {"pitches": (math.radians(30),)}),
    ],
    ids=str,
)
def test_the_size_of_an_effect_is_that_of_two_analyses(
    name: str, truth: dict[str, object]
) -> None:
    log = simulated(**truth)
    within, without = analysed(log), analysed(log, "horizontal")
    found, u = effect(within, name), within.inertia.u / within.inertia.value
    assert found["kept"]
    brute = without.inertia.value / within.inertia.value - 1
    assert found["bias"] == pytest.approx(brute, rel=0.1, abs=0.05 * u)
    assert abs(brute) > 0.2 * u


@pytest.mark.slow
@pytest.mark.parametrize("turns", [1 / 3, 2 / 3, 2.0])
def test_a_silent_log_of_a_released_rod_is_fitted_as_released_if_it_matters(
    turns: float,
) -> None:
    log = simulated(**RELEASED, turns=(turns,))
    silent, told = analysed(log.replace("# motion: released\n", "")), analysed(log)
    size = effect(silent, "release")["size"]
    assert (silent.model.name == "released") == (size > changes.DROP_ONE) == (turns > 1)
    if silent.model.name != "released":
        assert (
            abs(silent.inertia.value - told.inertia.value)
            < changes.DROP_ONE * silent.inertia.u
        )
        return
    assert abs(silent.inertia.value - told.inertia.value) < silent.inertia.u
    assert "assumes that it was released" in next(
        found.message for found in silent.diagnostics if found.code == "G418"
    )


@pytest.mark.slow
def test_of_a_ball_that_is_not_balanced_are_those_of_a_line_through_the_origin() -> (
    None
):
    found = effect(analysed(made(imbalance=1e-3)), "residual_torque")
    assert found["bias"] == pytest.approx(-0.03, abs=0.015)
    assert found["kept"]


@pytest.mark.slow
def test_with_the_latitude_the_turning_floor_is_corrected_for() -> None:
    floor = physics.EARTH_ROTATION * math.sin(math.radians(42.5))
    small = {
        "s": "time time_bias spin_delay",
        "%": "spin spin_scale mass mass_scale turns g",
        "mm": "position position_zero",
    }
    log = "# g: 9.803 m/s^2\n# motion: steady\n# latitude: 42.5 deg\n"
    log += "".join(
        f"# u_{key}: 1e-6 {unit}\n"
        for unit, keys in small.items()
        for key in keys.split()
    )
    log += "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense\n"
    for mass, rpm in itertools.product((20, 40, 60), (200, 400, 600)):
        seconds = (
            2 * math.pi / (mass * 1e-3 * 9.803 * 0.15 / (4.44e-3 * rpm * RPM) - floor)
        )
        log += f"{mass}.0000,15.0000,{rpm}.000,{seconds:.8f},1,ccw\n"
    analysis = analysed(log)
    assert analysis.inertia.value == pytest.approx(4.44e-3, rel=1e-6)
    assert effect(analysis, "earth")["kept"]
