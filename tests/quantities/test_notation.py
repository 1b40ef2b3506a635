"""A quantity is read alike wherever it may be written, and whatever this tool prints of
a value it reads.
"""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gyrodata
from gyrodata.base.errors import GyroError
from gyrodata.quantities import vocabulary
from gyrodata.readings import read_log, write_log
from gyrodata.reporting.values import inertia_text

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"
ROW = "20,15.0,406,13.06,1/3"
KEY = "transverse_inertia"


def by_cell(text: str) -> gyrodata.Readings:
    quoted = '"' + text.replace('"', '""') + '"'
    return read_log(f"{HEAD},{KEY} [kg m^2]\n{ROW},{quoted}\n")


def by_line(text: str) -> gyrodata.Readings:
    return read_log(f"# {KEY}: {text}\n{HEAD}\n{ROW}\n")


def by_setting(text: str) -> gyrodata.Readings:
    return read_log(f"{HEAD}\n{ROW}\n", settings={KEY: text})


def values(text: str) -> list[tuple[float, float | None]]:
    """Value and u of a text in a cell, in a line above, in an option, and as the
    student's answer.
    """
    found = []
    for read in (by_cell, by_line, by_setting):
        readings = read(text)
        assert readings.ok, readings.diagnostics
        (cell,) = readings.columns[KEY].readings
        found.append((cell.value, None if cell.u is None else cell.u.at(cell.value)))
    answer = read_log(f"# reported_inertia: {text}\n{HEAD}\n{ROW}\n").reported[
        "inertia"
    ]
    assert answer.problem is None
    return [*found, (answer.value, answer.u)]


# text, I [kg*m^2], its standard uncertainty
WAYS: list[tuple[str, float, float | None]] = [
    ("(4.441 ± 0.023) × 10⁻³ kg·m²", 4.441e-3, 2.3e-5),
    ("4.63e-3 ± 2 % kg m^2", 4.63e-3, 9.26e-5),
    *(
        (text, 4.4e-3, 1e-4)
        for text in (
            "4.400(100)e-3 kg·m²",
            "4.4e-3 ± 0.196e-3 kg m^2 (95 %)",
            "4.4 ± 0.2 (k = 2) g m^2",
            "4.4 ± 0.1 × 10⁻³ kg m²",
            r"4.4e-3 \pm 0.1e-3 kg m^2",
            "4,4e-3 ± 0,1e-3 кг·м²",
            "4.4e-3 kg m^2 ± 0.1 g m^2",
        )
    ),
    *(
        (text, 4.4e-3, None)
        for text in (
            "4.4 x 10^-3 kg m^2",
            "4.4·10^{-3} kg m^2",
            "0,0044 kg m^2",
            "44000 g cm^2",
        )
    ),
    ("½ g m^2", 5e-4, None),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "value", "u"), WAYS, ids=[text for text, _, _ in WAYS]
)
def test_quantity_is_the_same_wherever_it_is_written(
    text: str, value: float, u: float | None
) -> None:
    for found, spread in values(text):
        assert found == pytest.approx(value, rel=1e-14)
        assert spread == (u and pytest.approx(u, rel=1e-12))


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "kg m^2",
        "46 300 g cm^2",
        "4.4e-3 ± 0.1e-3 s",
        "1/0 kg m^2",
        "nan kg m^2",
        "9" * 201,
    ],
)
def test_text_that_is_not_a_quantity_is_refused_everywhere(text: str) -> None:
    assert not by_cell(text).ok
    assert not by_line(text).ok
    with pytest.raises(GyroError):
        by_setting(text)
    assert (
        read_log(f"# reported_inertia: {text}\n{HEAD}\n{ROW}\n")
        .reported["inertia"]
        .problem
    )


def test_comma_that_may_part_thousands_is_asked_about() -> None:
    (told,) = by_line("46,300 g cm^2").diagnostics
    assert (told.code, "46300 or 46.300" in told.message) == ("G306", True)
    # In a table of decimal commas it is one, and so it is where it can mean one thing
    # only.
    table = f"# {KEY}: 46,300 g cm^2\n{HEAD.replace(',', ';')}\n20;15,0;406;13,06;1/3\n"
    assert read_log(table).columns[KEY].values == (pytest.approx(4.63e-6),)
    for text in ("0,300 g m^2", "46,30 g m^2", "4,441×10⁻³ kg m²"):
        assert values(text) == values(text.replace(",", "."))


@pytest.mark.parametrize(
    ("text", "turns"),
    [
        ("π", 1 / 2),
        ("2π", 1),
        ("π/2", 1 / 4),
        ("2 pi/3", 1 / 3),
        ("1.5 pi", 3 / 4),
        ("4π rad", 2),
    ],
)
def test_angle_in_parts_of_pi_has_its_value(text: str, turns: float) -> None:
    head = HEAD.replace("turns", "angle [rad]")
    (angle,) = read_log(f"{head}\n{ROW.replace('1/3', text)}\n").columns["angle"].values
    assert angle == pytest.approx(turns * 2 * math.pi, rel=1e-15)


# --- what this tool prints ---

PAIRS = st.tuples(st.floats(1e-6, 1e2), st.floats(1e-5, 2.0))
MANY = settings(derandomize=True, deadline=None, max_examples=100)


@pytest.mark.slow
@given(PAIRS)
@MANY
def test_printed_value_is_read_and_written_again(pair: tuple[float, float]) -> None:
    value, u = pair[0], pair[0] * pair[1]
    readings = by_line(inertia_text(value, u))
    (cell,) = readings.columns[KEY].readings
    assert cell.u is not None
    assert cell.u.absolute == pytest.approx(u, rel=0.051)
    assert cell.value == pytest.approx(value, abs=0.0501 * u, rel=1e-12)
    (again,) = read_log(write_log(readings)).columns[KEY].readings
    assert (again.value, again.u) == (cell.value, cell.u)


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (4.4412e-3, 0.0234e-3, "(4.441 ± 0.023) × 10⁻³ kg·m²"),
        (1.5, 0.12, "1.50 ± 0.12 kg·m²"),
        (4.4e-3, 7e-3, "(4.4 ± 7.0) × 10⁻³ kg·m²"),
        (4.4e-3, None, "4.4 × 10⁻³ kg·m²"),
        (9.9996, 0.0996, "10.00 ± 0.10 kg·m²"),
    ],
)
def test_moments_of_inertia_as_they_are_read(
    value: float, u: float | None, text: str
) -> None:
    assert inertia_text(value, u) == text


def test_words_of_the_vocabulary_may_be_separated_by_commas(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    languages = {"en": {"centre": "centre, center"}, "de": {"centre": "Mitte Zentrum"}}
    monkeypatch.setattr(vocabulary, "LANGUAGES", languages)
    assert vocabulary.single_words("centre") == ["centre", "center", "Mitte", "Zentrum"]
