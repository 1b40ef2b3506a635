"""What students write as units, and what it must mean."""

import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata import units
from gyrodata.quantities import parse_quantity, parse_uncertainty
from gyrodata.readings import kind_of_role, to_display
from gyrodata.units import SI, TABLE, Uncertainty, UnitError, from_si, kinds_of, parse, parse_unit

RPM = 2 * math.pi / 60


@pytest.mark.parametrize(
    "text",
    [
        "rpm",
        "RPM",
        "r.p.m.",
        "1/min",
        "min^-1",
        "min⁻¹",
        "rev/min",
        "r/min",
        "U/min",
        "Umdr./min",
        "tr/min",
        "obr/min",
        "obr./min",
        "об/мин",
        "revolutions per minute",
        "U min^-1",
        "1/(min)",
    ],
)
def test_a_count_per_minute_is_revolutions(text):
    assert parse_unit(text, "rate").factor == pytest.approx(RPM, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        ("Hz", 2 * math.pi),
        ("Гц", 2 * math.pi),
        ("rev/s", 2 * math.pi),
        ("rps", 2 * math.pi),
        ("об/с", 2 * math.pi),
        ("rad/s", 1),
        ("рад/с", 1),
        ("rad·s⁻1", 1),
        ("rad s^-1", 1),
        ("deg/s", math.pi / 180),
        ("°/s", math.pi / 180),
    ],
)
def test_the_role_decides_what_a_rate_is(text, factor):
    assert parse_unit(text, "rate").factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize("text", ["1/s", "s^-1", "s⁻¹", "c^-1", "с^-1", "1/h"])
def test_a_bare_per_second_is_asked_about(text):
    with pytest.raises(UnitError, match="revolutions or radians") as caught:
        parse_unit(text, "rate")
    assert caught.value.reason == "ambiguous"
    assert "rad/s" in caught.value.hint


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        ("N·m", 1),
        ("Nm", 1),
        ("N*m", 1),
        ("N m", 1),
        ("N.m", 1),
        ("H*м", 1),
        ("Н·м", 1),
        ("Нм", 1),
        ("mN·m", 1e-3),
        ("mNm", 1e-3),
        ("N cm", 1e-2),
        ("g·cm", 9.80665e-5),
        ("gf*cm", 9.80665e-5),
        ("kgf·cm", 0.0980665),
    ],
)
def test_torques(text, factor):
    assert parse_unit(text, "torque").factor == factor


def test_mega_is_no_milli():
    for text in ("MN·m", "Mg", "MHz"):
        for kind in ("torque", "mass", "rate"):
            with pytest.raises(UnitError):
                parse_unit(text, kind)


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        ("кг", "mass", 1),
        ("г", "mass", 1e-3),
        ("KG", "mass", 1),
        ("мм", "length", 1e-3),
        ("см", "length", 1e-2),
        ("in", "length", 0.0254),
        ("с", "time", 1),
        ("c", "time", 1),
        ("сек.", "time", 1),
        ("s per turn", "time", 1),
        ("°", "angle", math.pi / 180),
        (" ̊", "angle", math.pi / 180),
        ("rev", "angle", 2 * math.pi),
        ("kg·m2", "inertia", 1),
        ("г·м²", "inertia", 1e-3),
        ("kg*cm^2", "inertia", 1e-4),
        ("m/s²", "acceleration", 1),
        ("m s^-2", "acceleration", 1),
        ("об", "number", 1),
        ("", "number", 1),
    ],
)
def test_other_kinds(text, kind, factor):
    assert parse_unit(text, kind).factor == factor


@pytest.mark.parametrize(
    "text", ["9**9**9*m", "m^99", "[" * 64, "x" * 65, "m" * 10_000, "m**(10**10)", "__import__", "kg)("]
)
def test_nothing_unchecked_reaches_pint(text, monkeypatch):
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("pint was asked"))
    for kind in SI:
        with pytest.raises(UnitError):
            parse_unit(text, kind)


def test_everyday_factors_are_those_of_pint():
    for (kind, spelling), factor in units._EVERYDAY.items():
        if kind not in ("sign", "text"):
            assert units._pint_factor(parse(spelling), kind, spelling) == pytest.approx(factor, rel=1e-15)


def test_pint_agrees_with_its_own_registry_where_it_can_be_trusted():
    import pint

    registry = pint.UnitRegistry()
    for text, kind in [
        ("lb", "mass"),
        ("oz", "mass"),
        ("inch", "length"),
        ("ft", "length"),
        ("kgf", "force"),
        ("lbf", "force"),
    ]:
        expected = registry.Quantity(
            1, text.replace("kgf", "kilogram_force").replace("lbf", "pound_force")
        ).to_base_units()
        assert parse_unit(text, kind).factor == pytest.approx(expected.magnitude, rel=1e-12)


@given(st.sampled_from([row[0] for row in TABLE]), st.sampled_from(sorted(SI)))
@settings(derandomize=True, max_examples=200)
def test_spellings_are_read_back(symbol, kind):
    if kind in kinds_of(symbol):
        unit = parse_unit(symbol, kind)
        assert parse_unit(unit.text, kind) == unit


@given(st.text(max_size=80), st.sampled_from(sorted(SI)))
@settings(derandomize=True, max_examples=500)
def test_any_text_is_a_unit_or_a_fault(text, kind):
    try:
        unit = parse_unit(text, kind)
    except UnitError:
        return
    assert math.isfinite(unit.factor)
    assert unit.factor > 0


def test_the_same_spin_four_ways():
    texts = ("10 Hz", "600 rpm", "0.1 s per turn", "62.83185307179586 rad/s")
    spins = [parse_quantity(text, "rate") for text in texts]
    assert spins == pytest.approx([20 * math.pi] * 4, rel=1e-15)


@pytest.mark.parametrize("text", ["20", "", "g", "1e999 g", "20 furlong", "0.1 s", "nan rpm", "1/0"])
def test_what_is_no_quantity(text):
    with pytest.raises(UnitError):
        parse_quantity(text, "rate" if text == "0.1 s" else "mass")


def test_quantities():
    assert parse_quantity("60 g", "mass") == pytest.approx(0.06)
    assert parse_quantity("9,803 m/s^2", "acceleration") == 9.803
    assert parse_quantity("−5 mm", "length") == -0.005
    assert parse_quantity("1/3", "number") == 1 / 3


def test_uncertainties():
    both = parse_uncertainty("0.2 % + 0.5 rpm", "rate")
    assert both.at(-400 * RPM) == pytest.approx(1.3 * RPM)
    assert parse_uncertainty("± 0,5 mm", "length") == Uncertainty(0.0005)
    assert parse_uncertainty("0.5", "length", "mm") == Uncertainty(0.0005)
    assert parse_uncertainty("1e-3 s", "time") == Uncertainty(0.001)
    for text in ("", "-1 mm", "0.5", "1 % + x", "2 g"):
        with pytest.raises(UnitError):
            parse_uncertainty(text, "length")


def test_display():
    assert to_display(0.02, "mass") == (20.0, "g")
    assert to_display(600 * RPM, "spin")[0] == pytest.approx(600)
    assert from_si(0.15, "cm", "length") == 15.0
    assert kind_of_role("u_position_zero") == "length"


def test_pint_is_not_loaded_for_everyday_units():
    code = "import sys, gyrodata.units as u; u.parse_unit('U/min', 'rate'); print('pint' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
