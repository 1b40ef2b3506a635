"""No input makes a traceback or hangs; whatever is read is finite and complete."""

import gzip
import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrodata.diagnostics import CODES
from gyrodata.errors import InputError
from gyrodata.readings import read_log

BOUNDED = settings(derandomize=True, deadline=None, max_examples=300, suppress_health_check=list(HealthCheck))

HEADERS = st.sampled_from(
    [
        "mass [g]",
        "m, г",
        "position [cm]",
        "x (mm)",
        "spin [rpm]",
        "n [obr/min]",
        "N",
        "N (rpm)",
        "ω0 RPM",
        "ω1 RPM",
        "T [s]",
        "t, c",
        "time",
        "time_1 [s]",
        "time_2 [s]",
        "turns",
        "angle [°]",
        "M, Н·м",
        "σ_M, Н·м",
        "Ω, с^-1",
        "u_time [s]",
        "u_spin [%]",
        "Δt (s)",
        "run",
        "note",
        "spin_sense",
        "pitch [deg]",
        "I [kg m^2]",
        "spin [s]",
        "",
        "9**9**9*m",
        "spin [9**9**9*m]",
        "±",
        "time (±0.2 s)",
        "[",
        "(((",
        "period",
        "№",
        "spin_start [rpm]",
        "spin_end [rpm]",
    ]
)
CELLS = st.one_of(
    st.sampled_from(
        [
            "",
            "-",
            "20",
            "15,0",
            "1/3",
            "1/0",
            "03:36.26",
            "99:99",
            "343±0.3",
            "7(1)",
            "56O",
            "nan",
            "inf",
            "1e400",
            "03.Jan",
            "-5",
            "0",
            "76г",
            "400 rpm",
            "0.1 s per turn",
            "ccw",
            "1e-400",
            "½",
            "1½",
            "1ª",
            "'",
            '"',
            "±",
            "2026-01-03",
            "#1",
        ]
    ),
    st.floats().map(repr),
    st.integers(-(10**6), 10**6).map(str),
    st.text(max_size=12),
)


def check(readings):
    """A log without errors gives every run what the analysis needs."""
    for diagnostic in readings.diagnostics:
        assert diagnostic.code in CODES
        assert str(diagnostic)
    n = len(readings.runs)
    assert len(set(readings.runs)) == n
    for column in (*readings.columns.values(), *readings.others):
        assert len(column.readings) == len(column.spots) == n, column.role
        assert all((column.place(i) is None) <= (column.spots[i] < 0 or not column.readings[i].text) for i in range(n))
        assert all(value is None or math.isfinite(value) for value in column.values)
    if not readings.ok:
        return
    assert n
    has = {role: [value is not None for value in column.values] for role, column in readings.columns.items()}
    no = [False] * n
    for run in range(n):

        def there(role, run=run):
            return has.get(role, no)[run]

        assert (
            there("precession_period")
            or there("precession_rate")
            or (there("time") and (there("turns") or there("angle")))
        )
        assert (
            there("spin")
            or there("spin_period")
            or (
                (there("spin_start") and there("spin_end")) or (there("spin_period_start") and there("spin_period_end"))
            )
        )
        weightless = there("mass") and readings.columns["mass"].values[run] == 0
        assert there("torque") or weightless or (there("position") and (there("mass") or there("force")))


def read(source, **options):
    try:
        readings = read_log(source, **options)
    except InputError as error:
        refusal = error
    else:
        return check(readings)
    assert refusal.diagnostics
    assert str(refusal)
    return None


@given(st.binary(max_size=400))
@BOUNDED
def test_any_bytes(data):
    read(data)


@given(
    st.binary(max_size=60),
    st.sampled_from([b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf", b"\x1f\x8b\x08", b"PK\x03\x04", b"%PDF"]),
)
@BOUNDED
def test_any_bytes_behind_a_signature(data, signature):
    read(signature + data)


@given(st.text(max_size=300))
@BOUNDED
def test_any_text(text):
    read(text.encode("utf-8", "surrogatepass"))


@given(
    st.lists(HEADERS, min_size=1, max_size=9).flatmap(
        lambda heads: st.tuples(st.just(heads), st.lists(st.lists(CELLS, max_size=len(heads) + 1), max_size=6))
    ),
    st.sampled_from([",", ";", "\t"]),
    st.sampled_from(["\n", "\r\n", "\r"]),
    st.booleans(),
)
@BOUNDED
def test_near_valid_logs(table, delimiter, end, quoted):
    heads, rows = table

    def cell(text):
        return '"' + text.replace('"', '""') + '"' if quoted else text

    lines = [delimiter.join(map(cell, row)) for row in [heads, *rows]]
    read(end.join(lines).encode("utf-8", "surrogatepass"))


@given(
    st.dictionaries(st.sampled_from(["turns", "spin", "mass", "g", "u_time", "balance_tilt", "x"]), CELLS, max_size=3),
    st.dictionaries(st.sampled_from(["time", "spin", "u_mass", "time_2", "x"]), HEADERS, max_size=2),
    st.lists(
        st.tuples(st.sampled_from(["g", "spin", "u_mass", "u_tme", "time", "balance_drift", "note"]), CELLS), max_size=3
    ),
)
@BOUNDED
def test_any_options(given_settings, mapping, metadata):
    head = "".join(f"# {key}: {value}\n" for key, value in metadata)
    body = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
    read((head + body).encode("utf-8", "surrogatepass"), settings=given_settings, mapping=mapping)


LOG = b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"x" * 10_000_001, "G106"),
        (LOG + b"x" * 9_900_000, "G225"),
        (LOG + b'"' + b"x" * 9_900_000, "G226"),
        (b"a," * 1_000_000, "G224"),
        (LOG + b"1," * 1_000_000, "G224"),
        (LOG + b"20,15,400,7,1\n" * 100_001, "G223"),
        (gzip.compress(b"\n" * 50_000_000), "G106"),
        (LOG + b'"' * 5_000_001, "G226"),
        (LOG.replace(b"g", b"\x00"), "G105"),
        (LOG.decode().encode("utf-16-le"), "G105"),
    ],
)
def test_limits(data, code):
    with pytest.raises(InputError) as caught:
        read_log(data)
    assert [d.code for d in caught.value.diagnostics if d.severity == "error"] == [code]


@pytest.mark.parametrize(
    "data", [b"\n" * 5_000_000, b",\n" * 3_000_000, b"#" * 9_000_000, b"# a: b\n" * 100_000, b"( " * 4000]
)
def test_large_nothings(data):
    read(data)
