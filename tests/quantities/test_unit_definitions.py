"""Every unit of `units.txt` in every spelling, alone, with prefixes and in products.

The expected sizes are written here a second time, from the definitions of the units.
"""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from fractions import Fraction

import pytest
from places import PACKAGE

from gyrodata.quantities import vocabulary
from gyrodata.quantities.units import (
    KINDS,
    UnitError,
    fold_letters,
    kinds_of,
    parse_unit,
    spellings,
)

POUND, GRAVITY, TURN = Fraction("0.45359237"), Fraction("9.80665"), math.tau
SIZES = {
    "length": {"m": 1, "dm": "0.1", "cm": "0.01", "mm": "0.001", "um": "1e-6"}
    | {"in": "0.0254", "ft": "0.3048", "yd": "0.9144"},
    "mass": {"kg": 1, "g": "0.001", "mg": "1e-6", "ug": "1e-9", "tonne": 1000}
    | {"lb": POUND, "oz": POUND / 16},
    "time": {"s": 1, "ms": "0.001", "min": 60, "h": 3600},
    "angle": {"rad": 1, "mrad": "0.001", "deg": math.pi / 180, "rev": TURN},
    "rate": {"rpm": TURN / 60, "rps": TURN, "Hz": TURN}
    | {"kHz": 1000 * TURN, "mHz": TURN / 1000},
    "force": {"N": 1, "mN": "0.001", "uN": "1e-6", "cN": "0.01", "kN": 1000}
    | {"kgf": GRAVITY, "gf": GRAVITY / 1000, "lbf": POUND * GRAVITY, "dyn": "1e-5"},
}
"""SI values of the units by kind and name."""
UNITS = {
    name: (kind, float(Fraction(size)))
    for kind, sizes in SIZES.items()
    for name, size in sizes.items()
}
DEFINITIONS = [
    line.split(" = ")
    for line in (PACKAGE / "quantities" / "units.txt").read_text("utf-8").splitlines()
    if " = " in line and not line.startswith("#")
]
LINES = {name: words for name, _, *words in DEFINITIONS if not name.endswith("-")}
PREFIXES = {"nano": -9, "micro": -6, "milli": -3, "centi": -2, "deci": -1} | {
    "deca": 1,
    "hecto": 2,
    "kilo": 3,
    "mega": 6,
}
POWERS = {
    "length": (0, 1, 0),
    "mass": (1, 0, 0),
    "time": (0, 0, 1),
    "force": (1, 1, -2),
}
"""Powers of mass, length and time."""
KINDS_BY_POWERS = {
    (1, 0, 0): "mass",
    (0, 1, 0): "length",
    (0, 0, 1): "time",
    (1, 1, -2): "force",
    (1, 2, -2): "torque",
    (1, 2, 0): "inertia",
    (0, 1, -2): "acceleration",
    (0, 0, 0): "number",
}
SAME_IN_ANY_CASE = [name for name in UNITS if name not in ("mN", "ms", "mg", "mHz")]


def spellings_of(name: str) -> set[str]:
    """List what may be written for a unit, in the languages too."""
    in_languages = vocabulary.words(name).split() if name in ("rev", "min", "s") else ()
    return {name, *LINES[name], *in_languages} - {"_"}


def exactly(size: float) -> object:
    return pytest.approx(size, rel=3e-16, abs=0.0)


def test_each_unit_of_the_file_is_tested() -> None:
    assert set(LINES) == set(UNITS)
    written = [name for name, *_ in DEFINITIONS if name.endswith("-")]
    assert written == [f"{prefix}-" for prefix in PREFIXES]


@pytest.mark.slow
@pytest.mark.parametrize("name", UNITS)
def test_each_spelling_of_a_unit_has_its_size(name: str) -> None:
    kind, size = UNITS[name]
    for spelling in spellings_of(name):
        # A word of two units belongs to the one that lists it in the file.
        if spellings()[fold_letters(spelling)] != name:
            assert spelling not in LINES[name]
            continue
        for text in (spelling, f" {spelling} ", f"({spelling})", f"[{spelling}]"):
            unit = parse_unit(text, kind)
            assert (unit.factor, unit.text) == (exactly(size), name), text
            assert kind in kinds_of(text)
        if spelling == "°":
            continue
        per_thousand = parse_unit(f"10^-3 {spelling}", kind).factor
        assert per_thousand == pytest.approx(size / 1000, rel=1e-15)


@pytest.mark.parametrize("name", SAME_IN_ANY_CASE)
def test_case_is_forgiven_in_words(name: str) -> None:
    kind, size = UNITS[name]
    words = [word for word in LINES[name] if len(word) > 3 and word.isascii()]
    for word in words:
        for text in (word.upper(), word.lower(), word.capitalize()):
            assert parse_unit(text, kind).factor == exactly(size), text


@pytest.mark.parametrize("text", ["Mg", "MG", "MN", "Ms", "MS", "MHz", "Mrad"])
def test_mega_is_not_read_as_milli(text: str) -> None:
    assert kinds_of(text) == frozenset()


@pytest.mark.slow
@pytest.mark.parametrize("prefix", PREFIXES)
def test_prefix_in_words_stands_before_an_english_word(prefix: str) -> None:
    words = {name: words[0] for name, words in LINES.items() if words[0] != "_"}
    assert {"m", "g", "s", "N", "lb", "ft"} <= set(words)
    for name, word in words.items():
        if name == "rev":
            continue  # a number of turns is an angle too
        kind, size = UNITS[name]
        size = float(Fraction(size) * Fraction(10) ** PREFIXES[prefix])
        for text in (prefix + word, f"{prefix}{word}s", (prefix + word).upper()):
            assert parse_unit(text, kind).factor == pytest.approx(size, rel=1e-15)
        assert parse_unit(parse_unit(prefix + word, kind).text, kind).factor == (
            pytest.approx(size, rel=1e-15)
        )


NO_PREFIX = """
Nmin nmin mmin kmin cmin umin millimin Nsec Ngram kilot micros centigrade
millimilligram kilokilogram kilorpm nanomm millikg
"""


@pytest.mark.parametrize("text", NO_PREFIX.split())
def test_letter_or_word_in_front_of_a_spelling_is_no_prefix(text: str) -> None:
    for kind in KINDS:
        with pytest.raises(UnitError):
            parse_unit(text, kind)


@pytest.mark.slow
def test_product_of_two_units_has_the_product_of_their_sizes() -> None:
    names = [name for name, (kind, _) in UNITS.items() if kind in POWERS]
    tested = 0
    for left, right in [*itertools.product(names, repeat=2)][::5]:
        (kind, size), (other_kind, other_size) = UNITS[left], UNITS[right]
        for power, signs in (
            (1, ("{}*{}", "{} {}", "{}·{}", "{}⋅{}", "{}-{}")),
            (-1, ("{}/{}", "{} per {}", "{}*{}^-1", "{} {}⁻¹", "{}∕{}")),
            (2, ("{}*{}^2", "{} {}²", "{}*{}**2", "{}·{}2")),
            (-2, ("{}/{}^2", "{}*{}^-2", "{} {}⁻²", "{}/{}/{}")),
        ):
            powers = tuple(
                one + power * other
                for one, other in zip(POWERS[kind], POWERS[other_kind], strict=True)
            )
            for sign in signs:
                text = sign.format(left, right, right)
                expected = KINDS_BY_POWERS.get(powers)
                of_torque = {"torque"} if powers == (1, 1, 0) else set()
                of_rate = {"rate"} if powers == (0, 0, -1) else set()
                known = {expected} - {None} or of_torque or of_rate
                assert kinds_of(text) == known, text
                if expected:
                    product = size * other_size**power
                    assert parse_unit(text, expected).factor == (
                        pytest.approx(product, rel=1e-14)
                    ), text
                    tested += 1
    assert tested > 400


def test_mass_at_an_arm_is_a_torque_by_its_weight() -> None:
    assert parse_unit("g*cm", "torque").factor == 9.80665e-5
    assert parse_unit("gcm", "torque").factor == parse_unit("gf*cm", "torque").factor


@pytest.mark.parametrize(
    ("text", "kind", "size"),
    [
        ("rpm", "rate", TURN / 60),
        ("U/min", "rate", TURN / 60),
        ("1/min", "rate", TURN / 60),
        ("Hz", "rate", TURN),
        ("r", "number", 1.0),
        ("rev", "angle", TURN),
        ("s/rev", "time", 1.0),
        ("Nm", "torque", 1.0),
        ("mNm", "torque", 1e-3),
        ("KG", "mass", 1.0),
        ("M", "length", 1.0),
        ("G", "mass", 1e-3),
        ("c", "time", 1.0),
        ("h", "time", 3600.0),
    ],
)
def test_text_that_means_something_else_in_the_default_registry(
    text: str, kind: str, size: float
) -> None:
    assert parse_unit(text, kind).factor == size


NOT_OURS = """
C pcs A V F a b e l R u parsec hand point degC °C percent % dimensionless pi k
"""


@pytest.mark.parametrize("text", NOT_OURS.split())
def test_unit_of_the_default_registry_alone_is_refused(text: str) -> None:
    assert kinds_of(text) == frozenset()


CODE = """
import sys
import gyrodata.quantities.units as units
assert "pint" not in sys.modules, "pint is loaded before a unit is read"
units.load()
import pint
assert units.registry() is not pint.application_registry.get()
assert "meter" not in units.registry() or units.registry().get_name("meter") == "m"
assert not [name for name in ("enzyme_unit", "parsec", "coulomb") if name in units.registry()]
print("ok")
"""


@pytest.mark.slow
def test_pint_is_loaded_with_the_first_unit_and_without_its_own_definitions() -> None:
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, check=False
    )
    assert done.stdout == "ok\n", done.stderr
