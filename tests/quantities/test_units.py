"""What students write as units, and what it must mean; the registry that pint comes
with is the other opinion.
"""

import math

import pint
import pytest

from gyrodata.quantities.notation import parse_uncertainty
from gyrodata.quantities.units import SI, Uncertainty, UnitError, parse_unit

RPM = 2 * math.pi / 60
WRITTEN = {
    (
        "rate",
        RPM,
    ): "rpm; RPM; r.p.m.; 1/min; min^-1; min⁻¹; rev/min; r/min; U/min; Umdr./min; tr/min; "
    "obr/min; об/мин; "
    "revolutions per minute; U min^-1",
    ("rate", 2 * math.pi): "Hz; Гц; rev/s; rps; об/с",
    ("rate", 1.0): "rad/s; рад/с; rad·s⁻1; rad s^-1",
    ("rate", math.pi / 180): "deg/s; °/s",
    ("torque", 1.0): "N·m; Nm; N*m; N m; N.m; H*м; Н·м; Нм",
    ("torque", 1e-3): "mN·m; mNm",
    ("time", 1.0): "c; сек.; s per turn",
    ("angle", math.pi / 180): "°",
    ("inertia", 1.0): "kg·m2",
    ("inertia", 1e-3): "г·м²",
    ("acceleration", 1.0): "m/s²; m s^-2",
    ("length", 0.01): "cm; см; سانتیمتر; سانتی\u200cمتر; centimetres; CENTIMETERS",
    ("mass", 1.0): "kg; KG; кг; kilos; 公斤",
}


@pytest.mark.parametrize(("kind", "factor"), WRITTEN, ids=str)
def test_unit_in_every_spelling_has_its_factor(kind: str, factor: float) -> None:
    for text in WRITTEN[kind, factor].split("; "):
        assert parse_unit(text, kind).factor == pytest.approx(factor, rel=1e-15), text


@pytest.mark.parametrize(
    "text",
    ["9**9**9*m", "m^99", "[" * 64, "x" * 65, "m**(10**10)", "__import__", "kg)("],
)
def test_unit_that_would_take_for_ever_is_refused_at_once(text: str) -> None:
    for kind in SI:
        with pytest.raises(UnitError):
            parse_unit(text, kind)


@pytest.mark.slow
def test_factors_are_those_of_the_registry_of_pint() -> None:
    registry = pint.UnitRegistry()
    named = {
        "lb": "mass",
        "oz": "mass",
        "g": "mass",
        "inch": "length",
        "ft": "length",
        "mm": "length",
        "ms": "time",
        "kgf": "force",
        "lbf": "force",
        "deg": "angle",
        "N*m": "torque",
        "kg*m^2": "inertia",
    }
    for text, kind in named.items():
        name = {"kgf": "kilogram_force", "lbf": "pound_force"}.get(text, text)
        expected = registry.Quantity(1, name).to_base_units().magnitude
        assert parse_unit(text, kind).factor == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "factor"),
    [
        ("milliseconds", "time", 1e-3),
        ("Ounces", "mass", 0.028349523125),
        ("feet", "length", 0.3048),
        ("micrometers", "length", 1e-6),
        ("millinewtons", "force", 1e-3),
    ],
)
def test_unit_can_be_written_as_a_word(name: str, kind: str, factor: float) -> None:
    assert parse_unit(name, kind).factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("hand", "length"), ("point", "length"), ("grams", "time"), ("turns", "mass")],
)
def test_word_that_is_no_usual_unit_of_its_kind_is_refused(
    name: str, kind: str
) -> None:
    with pytest.raises(UnitError):
        parse_unit(name, kind)


def test_uncertainty_is_absolute_relative_or_both() -> None:
    assert parse_uncertainty("0.2 % + 0.5 rpm", "rate").at(-400 * RPM) == pytest.approx(
        1.3 * RPM
    )
    assert parse_uncertainty("± 0,5 mm", "length") == Uncertainty(0.0005)
    assert parse_uncertainty("1 % + 1 mm, k=2", "length") == Uncertainty(0.0005, 0.005)
    assert parse_uncertainty("1.96 mm (95 %)", "length").absolute == pytest.approx(
        0.001
    )
    for text in ("", "-1 mm", "0.5", "1 % + x", "2 g", "1.0(1) mm"):
        with pytest.raises(UnitError):
            parse_uncertainty(text, "length")
