"""A quantity is read alike wherever it stands, and whatever this tool prints of a value it reads."""

import json
import math
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata.cli.options import quantity
from gyrodata.errors import InputError
from gyrodata.quantities import parse_quantity, parse_uncertainty, read_quantity, take_apart
from gyrodata.readings import Uncertainty, read_cell, read_log, read_reported, write_log
from gyrodata.reporting.values import CENTIMETRE, RPM, SECOND, inertia_text, number_text, torque_scale, value_text
from gyrodata.units import UnitError

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"
ROW = "20,15.0,406,13.06,1/3"

Read = tuple[float, float | None]


def by_cell(text: str) -> Read:
    quoted = '"' + text.replace('"', '""') + '"'
    readings = read_log(f"{HEAD},transverse_inertia [kg m^2]\n{ROW},{quoted}\n")
    assert readings.ok, readings.diagnostics
    return by_column(readings)


def by_line(text: str) -> Read:
    readings = read_log(f"# transverse_inertia: {text}\n{HEAD}\n{ROW}\n")
    assert readings.ok, readings.diagnostics
    return by_column(readings)


def by_setting(text: str) -> Read:
    return by_column(read_log(f"{HEAD}\n{ROW}\n", settings={"transverse_inertia": text}))


def by_column(readings: object) -> Read:
    column = readings.columns["transverse_inertia"]  # type: ignore[attr-defined]
    value, uncertainty = column.values[0], column.readings[0].u
    return value, None if uncertainty is None else uncertainty.at(value)


def by_option(text: str) -> Read:
    found = read_quantity(text, "inertia")
    assert quantity("--inertia", text, "inertia") == found.value
    return found.value, None if found.uncertainty is None else found.uncertainty.at(found.value)


def by_report(text: str) -> Read:
    reported = read_reported("inertia", text)
    assert reported.problem is None
    assert reported.value is not None
    return reported.value, reported.u


READERS: list[Callable[[str], Read]] = [by_cell, by_line, by_setting, by_option, by_report]

# text, I [kg*m^2], its standard uncertainty
WAYS: list[tuple[str, float, float | None]] = [
    ("4.441(23)e-3 kg·m²", 4.441e-3, 2.3e-5),
    ("(4.441 ± 0.023) × 10⁻³ kg·m²", 4.441e-3, 2.3e-5),
    ("4.63×10⁻³ ± 0.06×10⁻³ kg m^2", 4.63e-3, 6e-5),
    ("4.63e-3 ± 2 % kg m^2", 4.63e-3, 9.26e-5),
    ("4.63e-3 kg m^2 ± 2 %", 4.63e-3, 9.26e-5),
    ("4.4e-3 ± 0.196e-3 kg m^2 (95 %)", 4.4e-3, 1e-4),
    ("(4.4 ± 0.196) × 10⁻³ kg m² (95% CI)", 4.4e-3, 1e-4),
    ("4.4e-3 ± 0.2e-3 kg m^2 (k = 2)", 4.4e-3, 1e-4),
    ("4.4e-3 ± 0.2e-3 kg m^2, k=2", 4.4e-3, 1e-4),
    ("4.4 ± 0.2 (k = 2) g m^2", 4.4e-3, 1e-4),
    ("4.4×10⁻³ kg·m²", 4.4e-3, None),
    ("4.4 x 10^-3 kg m^2", 4.4e-3, None),
    ("4.4*10**-3 kg*m**2", 4.4e-3, None),
    ("4.4·10^{-3} kg m^2", 4.4e-3, None),
    ("4.4 10^-3 kg m^2", 4.4e-3, None),
    ("4.4 × 10-3 kg m2", 4.4e-3, None),
    ("(4.4 ± 0.1)e-3 kg m^2", 4.4e-3, 1e-4),
    ("(4.4 ± 0.1) 10^-3 kg m^2", 4.4e-3, 1e-4),
    ("(4.4e-3 ± 0.1e-3) kg m^2", 4.4e-3, 1e-4),
    ("(4.4 × 10⁻³ ± 0.1 × 10⁻³) kg m²", 4.4e-3, 1e-4),
    ("(4.4e-3 kg m^2 ± 0.1e-3 kg m^2)", 4.4e-3, 1e-4),
    ("4.4 ± 0.1 × 10⁻³ kg m²", 4.4e-3, 1e-4),
    ("4.4(1)e-3 kg m^2", 4.4e-3, 1e-4),
    ("4.4(0.1)e-3 kg m^2", 4.4e-3, 1e-4),
    ("4.4(1) × 10⁻³ kg m²", 4.4e-3, 1e-4),
    ("4.4e-3(1) kg m^2", 4.4e-3, 1e-4),
    ("4.4e-3 +/- 0.1e-3 kg m^2", 4.4e-3, 1e-4),
    ("4.4e-3 +- 0.1e-3 kg m^2", 4.4e-3, 1e-4),
    (r"4.4e-3 \pm 0.1e-3 kg m^2", 4.4e-3, 1e-4),
    ("4.4e-3 ± 0.1e-3 [kg m^2]", 4.4e-3, 1e-4),
    ("4.4e-3 (kg m^2)", 4.4e-3, None),
    ("4,4e-3 ± 0,1e-3 кг·м²", 4.4e-3, 1e-4),
    ("0,0044 kg m^2", 4.4e-3, None),
    ("4,440 ± 0,023 g m^2", 4.44e-3, 2.3e-5),
    ("4.4 ± 0.1 g m^2", 4.4e-3, 1e-4),
    ("4.4e-3 kg m^2 ± 0.1 g m^2", 4.4e-3, 1e-4),
    ("4.4e-3 kg-m^2", 4.4e-3, None),
    ("4.4E-3 kg⋅m²", 4.4e-3, None),
    ("44000 g cm^2", 4.4e-3, None),
    ("1/200 kg m^2", 5e-3, None),
    ("½ g m^2", 5e-4, None),
]


@pytest.mark.parametrize(("text", "value", "u"), WAYS, ids=[text for text, _, _ in WAYS])
def test_every_reader_reads_it_alike(text: str, value: float, u: float | None) -> None:
    for read in READERS:
        found, spread = read(text)
        assert found == pytest.approx(value, rel=1e-14), read.__name__
        assert spread == (None if u is None else pytest.approx(u, rel=1e-12)), read.__name__


@pytest.mark.parametrize(
    ("text", "kind", "value", "u"),
    [
        ("12,5 cm", "length", 0.125, None),
        ("12.5 ± 0.1 cm", "length", 0.125, 0.001),
        ("−12.5 cm", "length", -0.125, None),
        ("76 g", "mass", 0.076, None),
        ("76г", "mass", 0.076, None),
        ("10 ± 0.5 % g", "mass", 0.01, 5e-5),
        ("1/3", "number", 1 / 3, None),
        ("2 1/2", "number", 2.5, None),
        ("10 ± 0.5 %", "number", 10.0, 0.05),
        ("0.10(5) mN m", "torque", 1e-4, 5e-5),
        ("9,803 m/s^2", "acceleration", 9.803, None),
    ],
)
def test_other_kinds(text: str, kind: str, value: float, u: float | None) -> None:
    found = read_quantity(text, kind)
    assert found.value == pytest.approx(value, rel=1e-15)
    assert (found.uncertainty and found.uncertainty.at(found.value)) == (None if u is None else pytest.approx(u))
    cell = read_cell(text, kind, None)
    assert (cell.value, cell.uncertainty) == (found.value, found.uncertainty)


def test_the_unit_of_the_column_holds_where_none_is_written() -> None:
    assert read_quantity("12.5 ± 0.1", "length", "cm").value == pytest.approx(0.125)
    assert read_cell("10 ± 0.5 %", "mass", "g").uncertainty == Uncertainty(0.0, 0.005)
    assert read_cell("4.4×10⁻³", "inertia", "kg*m^2").step == pytest.approx(1e-4)


class TestACommaThatMayPartThousands:
    def test_is_asked_about_where_no_column_tells(self) -> None:
        with pytest.raises(UnitError, match=r"46300 or 46\.300"):
            read_quantity("46,300 g cm^2", "inertia")
        with pytest.raises(InputError, match=r"46300 or 46\.300"):
            quantity("--inertia", "46,300 g cm^2", "inertia")
        assert read_reported("inertia", "46,300 g cm^2").fault == "unreadable"
        readings = read_log(f"# transverse_inertia: 46,300 g cm^2\n{HEAD}\n{ROW}\n")
        assert [d.code for d in readings.diagnostics] == ["G306"]
        assert "46300 or 46.300" in readings.diagnostics[0].message

    def test_is_a_decimal_comma_in_a_table_of_decimal_commas(self) -> None:
        rows = "20;15,0;406;13,06;1/3\n"
        readings = read_log(f"# transverse_inertia: 46,300 g cm^2\n{HEAD.replace(',', ';')}\n{rows}")
        assert readings.columns["transverse_inertia"].values == (pytest.approx(4.63e-6),)
        again = read_log(write_log(readings))
        assert again.columns["transverse_inertia"].values == readings.columns["transverse_inertia"].values

    def test_is_written_as_a_point_where_a_line_stands_alone(self) -> None:
        rows = "46,25;15;406;13;1/3\n;15;598;19;1/3\n46,300;15;406;13;1/3\n"
        readings = read_log(f"{HEAD.replace(',', ';')}\n{rows}")
        assert readings.ok
        assert read_log(write_log(readings)).columns["mass"].values == readings.columns["mass"].values

    @pytest.mark.parametrize("text", ["0,300 g m^2", "46,30 g m^2", "4,441e-3 kg m^2", "4,441×10⁻³ kg m²"])
    def test_is_no_question_where_it_can_mean_one_thing_only(self, text: str) -> None:
        assert read_quantity(text, "inertia").value == read_quantity(text.replace(",", "."), "inertia").value


@pytest.mark.parametrize(
    "text",
    [
        "",
        "kg m^2",
        "46 300 g cm^2",
        "46,300.5 g cm^2",
        "5×105 kg m^2",  # 5×10⁵, or 525?
        "5² g m^2",
        "(4.4 ± 0.1) % kg m^2",
        "4.4e-3 ± 0.1e-3 s",
        "4.4e-3 ± 0.1 s kg m^2",
        "(4.4e-3 ± 0.1e-3)e-3 kg m^2",
        "4.4e-3 (95 %) kg m^2",
        "1/0 kg m^2",
        "nan kg m^2",
        "I = 4.4 g m^2 = 5 g m^2",
        "9" * 201,
    ],
)
def test_what_is_no_quantity_is_none_for_every_reader(text: str) -> None:
    with pytest.raises(UnitError):
        read_quantity(text, "inertia")
    assert read_reported("inertia", text).fault is not None
    with pytest.raises(ValueError, match=r".+"):
        read_cell(text, "inertia", None)


def test_a_name_in_front_is_read_of_a_reported_value_only() -> None:
    assert read_reported("inertia", "I = 4.4 g m^2").value == pytest.approx(4.4e-3)
    with pytest.raises(UnitError):
        read_quantity("I = 4.4 g m^2", "inertia")
    with pytest.raises(ValueError, match="not a number"):
        read_cell("I = 4.4 g m^2", "inertia", None)


def test_an_expanded_uncertainty_alone_is_divided_by_its_factor() -> None:
    assert parse_uncertainty("1 mm (k = 2)", "length") == Uncertainty(0.0005)
    assert parse_uncertainty("1 % + 1 mm, k=2", "length") == Uncertainty(0.0005, 0.005)
    assert parse_uncertainty("1.96 mm (95 %)", "length").absolute == pytest.approx(0.001)
    assert parse_uncertainty("2×10⁻³ s", "time") == Uncertainty(0.002)
    with pytest.raises(UnitError, match="a value with one"):
        parse_uncertainty("1.0(1) mm", "length")


# --- what this tool prints --------------------------------------------------------------------------------------

VALUES = st.floats(1e-6, 1e2).flatmap(lambda size: st.tuples(st.sampled_from([size, -size]), st.floats(1e-5, 2.0)))
MANY = settings(derandomize=True, deadline=None, max_examples=200)


def agrees(text: str, kind: str, value: float, u: float, unit: str = "") -> None:
    """Hold what is read against what was printed: u has two digits, and the value as many places."""
    found = read_quantity(text, kind, unit or None)
    assert found.uncertainty is not None, text
    assert found.uncertainty.absolute == pytest.approx(u, rel=0.051), text
    assert found.value == pytest.approx(value, abs=0.0501 * u, rel=1e-12), text
    cell = read_cell(text, kind, unit or None)
    assert (cell.value, cell.uncertainty) == (found.value, found.uncertainty)


@given(VALUES, st.sampled_from(["plain", "short"]))
@MANY
def test_printed_values_are_read(pair: tuple[float, float], writing: str) -> None:
    value, u = pair[0], pair[1] * abs(pair[0])
    agrees(number_text(value, u, writing=writing), "number", value, u)  # type: ignore[arg-type]
    agrees(inertia_text(abs(value), u, writing), "inertia", abs(value), u)  # type: ignore[arg-type]
    for scale, kind in ((torque_scale(abs(value)), "torque"), (SECOND, "time"), (CENTIMETRE, "length"), (RPM, "rate")):
        agrees(value_text(value, u, scale, writing), kind, value, u)  # type: ignore[arg-type]
    reported = read_reported("inertia", inertia_text(abs(value), u, writing))  # type: ignore[arg-type]
    assert reported.u == pytest.approx(u, rel=0.051)


@given(st.floats(1e-9, 1e3))
@MANY
def test_printed_values_without_u_are_read(value: float) -> None:
    assert parse_quantity(inertia_text(value, None), "inertia") == pytest.approx(value, rel=5.01e-4)
    assert parse_quantity(value_text(value, None, SECOND), "time") == pytest.approx(value, rel=5.01e-4)


@given(VALUES)
@MANY
def test_json_values_are_read(pair: tuple[float, float]) -> None:
    value, u = pair[0], pair[1] * abs(pair[0])
    written = json.loads(json.dumps({"value": value, "u": u, "unit": "kg*m^2"}))
    found = read_quantity("{value!r} ± {u!r} {unit}".format(**written), "inertia")
    assert (found.value, found.uncertainty) == (value, Uncertainty(u))


@given(VALUES, st.sampled_from(["plain", "short"]))
@MANY
def test_printed_values_in_a_log_are_written_and_read(pair: tuple[float, float], writing: str) -> None:
    value = abs(pair[0])
    text = inertia_text(value, pair[1] * value, writing)  # type: ignore[arg-type]
    log = f"# transverse_inertia: {text}\n# reported_inertia: {text}\n{HEAD}\n{ROW}\n"
    readings = read_log(log)
    again = read_log(write_log(readings))
    columns = readings.columns["transverse_inertia"], again.columns["transverse_inertia"]
    assert [(one.value, one.u) for one in columns[0].readings] == [(one.value, one.u) for one in columns[1].readings]
    assert again.reported == {**readings.reported, "inertia": again.reported["inertia"]}
    assert again.reported["inertia"].u == readings.reported["inertia"].u


@given(st.text(max_size=60) | st.text("0123456789.,eE+-±()[]×^*% kgm²·/=k", max_size=60))
@settings(derandomize=True, deadline=None, max_examples=500)
def test_any_text_is_a_quantity_or_a_fault(text: str) -> None:
    written = take_apart(text)
    assert written is None or not math.isnan(written.value)
    try:
        found = read_quantity(text, "inertia")
    except UnitError:
        return
    assert math.isfinite(found.value)
