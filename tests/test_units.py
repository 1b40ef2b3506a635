"""What students write as units, and what it must mean; pint, with its own definitions, is the other opinion."""

import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata import units
from gyrodata.quantities import parse_quantity, parse_uncertainty
from gyrodata.units import SI, TABLE, Uncertainty, UnitError, kinds_of, parse, parse_unit

RPM = 2 * math.pi / 60
WRITTEN = {
    ("rate", RPM): "rpm; RPM; r.p.m.; 1/min; min^-1; min⁻¹; rev/min; r/min; U/min; Umdr./min; tr/min; obr/min; об/мин; "
    "revolutions per minute; U min^-1; 1/(min)",
    ("rate", 2 * math.pi): "Hz; Гц; rev/s; rps; об/с",
    ("rate", 1.0): "rad/s; рад/с; rad·s⁻1; rad s^-1",
    ("rate", math.pi / 180): "deg/s; °/s",
    ("torque", 1.0): "N·m; Nm; N*m; N m; N.m; H*м; Н·м; Нм",
    ("torque", 1e-3): "mN·m; mNm",
    ("torque", 9.80665e-5): "g·cm; gf*cm",
    ("time", 1.0): "c; сек.; s per turn",
    ("angle", math.pi / 180): "°",
    ("angle", 2 * math.pi): "rev",
    ("inertia", 1.0): "kg·m2",
    ("inertia", 1e-3): "г·м²",
    ("acceleration", 1.0): "m/s²; m s^-2",
}


@pytest.mark.parametrize(("kind", "factor"), WRITTEN, ids=str)
def test_unit_in_every_spelling_has_its_factor(kind: str, factor: float) -> None:
    for text in WRITTEN[kind, factor].split("; "):
        assert parse_unit(text, kind).factor == pytest.approx(factor, rel=1e-15), text


@pytest.mark.parametrize("text", ["1/s", "s^-1", "s⁻¹", "c^-1", "с^-1", "1/h"])
def test_bare_per_second_is_asked_about(text: str) -> None:
    with pytest.raises(UnitError, match="revolutions or radians") as caught:
        parse_unit(text, "rate")
    assert "rad/s" in caught.value.hint


@pytest.mark.parametrize(
    "text", ["9**9**9*m", "m^99", "[" * 64, "x" * 65, "m" * 10_000, "m**(10**10)", "__import__", "kg)("]
)
def test_nothing_unchecked_reaches_pint(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("pint was asked"))
    for kind in SI:
        with pytest.raises(UnitError):
            parse_unit(text, kind)


def test_everyday_factors_are_those_of_pint() -> None:
    for (kind, spelling), factor in units._EVERYDAY.items():
        if kind not in ("sign", "text"):
            assert units._pint_factor(parse(spelling), kind, spelling) == pytest.approx(factor, rel=1e-15)


def test_other_factors_are_those_of_the_registry_of_pint() -> None:
    import pint

    registry = pint.UnitRegistry()
    named = {"lb": "mass", "oz": "mass", "inch": "length", "ft": "length", "kgf": "force", "lbf": "force"}
    for text, kind in named.items():
        name = {"kgf": "kilogram_force", "lbf": "pound_force"}.get(text, text)
        expected = registry.Quantity(1, name).to_base_units().magnitude
        assert parse_unit(text, kind).factor == pytest.approx(expected, rel=1e-12)


@given(st.sampled_from([row[0] for row in TABLE]), st.sampled_from(sorted(SI)))
@settings(derandomize=True, max_examples=200)
def test_spelling_is_read_back(symbol: str, kind: str) -> None:
    if kind in kinds_of(symbol):
        unit = parse_unit(symbol, kind)
        assert parse_unit(unit.text, kind) == unit


@given(st.text(max_size=80), st.sampled_from(sorted(SI)))
@settings(derandomize=True, max_examples=500)
def test_any_text_is_a_unit_or_refused(text: str, kind: str) -> None:
    try:
        unit = parse_unit(text, kind)
    except UnitError:
        return
    assert 0 < unit.factor < math.inf


def test_same_spin_in_four_units_is_the_same() -> None:
    texts = ("10 Hz", "600 rpm", "0.1 s per turn", "62.83185307179586 rad/s")
    assert [parse_quantity(text, "rate") for text in texts] == pytest.approx([20 * math.pi] * 4, rel=1e-15)


def test_uncertainty_is_absolute_relative_or_both() -> None:
    assert parse_uncertainty("0.2 % + 0.5 rpm", "rate").at(-400 * RPM) == pytest.approx(1.3 * RPM)
    assert parse_uncertainty("± 0,5 mm", "length") == Uncertainty(0.0005)
    assert parse_uncertainty("1 % + 1 mm, k=2", "length") == Uncertainty(0.0005, 0.005)
    assert parse_uncertainty("1.96 mm (95 %)", "length").absolute == pytest.approx(0.001)
    for text in ("", "-1 mm", "0.5", "1 % + x", "2 g", "1.0(1) mm"):
        with pytest.raises(UnitError):
            parse_uncertainty(text, "length")


def test_pint_is_not_loaded_for_everyday_units() -> None:
    code = "import sys, gyrodata.units as u; u.parse_unit('U/min', 'rate'); print('pint' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
