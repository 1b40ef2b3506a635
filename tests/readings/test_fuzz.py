"""Any bytes, any text and any option end in readings that can be used, or in words."""

import math

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrodata.errors import GyroError
from gyrodata.readings import read_log

BOUNDED = settings(derandomize=True, deadline=None, max_examples=300, suppress_health_check=list(HealthCheck))
LOG = b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
SIGNATURES = [b"", b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf", b"\x1f\x8b\x08", b"PK\x03\x04", b"%PDF"]
CELLS = st.sampled_from(["", "-", "15,0", "1/0", "03:36.26", "343±0.3", "7(1)", "nan", "1e400", "03.Jan", "ccw", "½"])
CELLS |= st.floats().map(repr) | st.text(max_size=12)


def read(source, **options):
    try:
        readings = read_log(source, **options)
    except GyroError as error:
        in_words = any(one.message for one in error.diagnostics)
    else:
        in_words = True
        usable(readings)
    assert in_words


def usable(readings):
    assert all(str(one) for one in readings.diagnostics)
    for column in (*readings.columns.values(), *readings.others):
        assert len(column.readings) == len(readings.runs)
        assert all(value is None or math.isfinite(value) for value in column.values)


@given(st.binary(max_size=400) | st.text(max_size=300).map(lambda t: t.encode("utf-8", "surrogatepass")),
       st.sampled_from(SIGNATURES))  # fmt: skip
@BOUNDED
def test_any_bytes_are_read_or_refused_in_words(data, signature):
    read(signature + data)


@given(
    st.dictionaries(st.sampled_from(["turns", "spin", "mass", "g", "u_time", "balance_tilt", "x"]), CELLS, max_size=3),
    st.dictionaries(
        st.sampled_from(["time", "spin", "u_mass", "x"]), st.sampled_from(["time [s]", "±", ""]), max_size=2
    ),
    st.lists(st.tuples(st.sampled_from(["g", "spin", "u_mass", "u_tme", "balance_drift", "note"]), CELLS), max_size=3),
)
@BOUNDED
def test_any_option_is_taken_or_refused_in_words(given_settings, mapping, lines):
    head = "".join(f"# {key}: {value}\n" for key, value in lines).encode("utf-8", "surrogatepass")
    read(head + LOG, settings=given_settings, mapping=mapping)
