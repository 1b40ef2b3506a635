"""gyrodata in Python: what goes in, what comes out, what an `Analysis` shows of itself,
and wrong arguments.
"""

from __future__ import annotations

import doctest
import json
import math
import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pint
import pytest
from matplotlib.figure import Figure
from msgspec.structs import replace
from places import SAMPLES, TESTS
from python_page import reference, section
from uncertainties import ufloat
from users_script import everything

import gyrodata
from gyrodata import Analysis
from gyrodata.api import in_python
from gyrodata.results import TABLES, encode

SAMPLE = SAMPLES / "air_gyroscope.csv"
UNITS = {"time": "s", "spin": "rpm", "mass": "g", "position": "cm"}


def test_examples_in_docstrings_print_what_they_say() -> None:
    rooms = [
        import_module(module.name)
        for module in walk_packages(gyrodata.__path__, "gyrodata.")
        if not module.name.endswith("__main__")
    ]
    results = [doctest.testmod(room) for room in (gyrodata, *rooms)]
    assert sum(result.failed for result in results) == 0
    assert sum(result.attempted for result in results) >= 3


@pytest.fixture(scope="module")
def lab() -> Analysis:
    return gyrodata.analyze(SAMPLE)


def table() -> pd.DataFrame:
    time, spin = (
        [6.74, 10.05, 13.31, 3.40, 5.03, 6.69],
        [205.0, 305.0, 404.0, 206.0, 305.0, 405.0],
    )
    mass = [20.0, 20.0, 20.0, 40.0, 40.0, 40.0]
    return pd.DataFrame(
        {"time": time, "spin": spin, "mass": mass, "position": 15.0, "turns": 1 / 3}
    )


@pytest.mark.slow
def test_an_analysis_is_a_line_and_a_screen(lab: Analysis) -> None:
    answer = "I_zz = 0.004416±0.000033 kg·m²; 10 runs, 0 diagnostics"
    assert repr(lab) == f"<Analysis of air_gyroscope.csv: {answer}>"
    assert "I_zz = (4.416 ± 0.033) × 10⁻³ kg·m²" in str(lab)
    assert len(str(lab).splitlines()) < 15
    assert "gyro analyze" not in str(lab)
    assert lab._repr_markdown_().startswith("# Gyroscope lab report")


@pytest.mark.slow
def test_a_result_is_text_and_a_number(lab: Analysis) -> None:
    assert f"{lab.inertia:.2u}" == "0.004416+/-0.000033 kg*m^2"
    assert f"{lab.inertia:.1uS}" == "0.00442(3) kg*m^2"
    assert str(lab.inertia) == f"{lab.inertia}" == "0.004416±0.000033 kg·m²"
    assert float(lab.inertia) == lab.inertia.value


def test_a_figure_is_drawn_on_axes_that_are_given(lab: Analysis) -> None:
    ax = Figure().add_subplot()
    assert lab.plot("torque", ax=ax) is ax
    labels = [
        "60.04 g at 15.00 cm",
        "39.99 g at 15.00 cm",
        "20.00 g at 15.00 cm",
        "no weight",
    ]
    assert ax.get_legend_handles_labels()[1] == [
        *labels,
        "fitted line",
        "through the origin",
    ]
    drawn = np.concatenate(
        [line.get_ydata() for line in ax.lines if line.get_marker() != "None"]
    )
    assert sorted(drawn) == pytest.approx(sorted(1e3 * lab.runs["torque"]))
    assert ax.get_ylabel() == "torque M [mN·m]"


@pytest.mark.slow
def test_ufloats_have_the_covariance_of_the_fit(lab: Analysis) -> None:
    told = lab.ufloats()
    in_cgs = lab.inertia.to_pint(pint.UnitRegistry()).to("g*cm^2").magnitude
    assert in_cgs.nominal_value == pytest.approx(1e7 * lab.inertia.value)
    assert list(told) == ["inertia", "residual_torque", "timing_bias"]
    for name, one in told.items():
        result = getattr(lab, name)
        assert one.nominal_value == result.value
        assert one.std_dev == pytest.approx(result.u, rel=1e-9)
    covariance = lab.fit.covariance
    expected = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    both = (
        told["inertia"] / lab.inertia.u
        + told["residual_torque"] / lab.residual_torque.u
    )
    assert both.std_dev == pytest.approx(np.sqrt(2 + 2 * expected), rel=1e-6)


@pytest.mark.slow
def test_settings_are_numbers_ufloats_or_quantities() -> None:
    registry = pint.UnitRegistry()
    written = gyrodata.analyze(SAMPLE, settings={"g": "9.8123456 ± 0.01 m/s^2"})
    quantity = registry.Quantity(ufloat(981.23456, 1.0), "cm/s^2")
    for value in (
        ufloat(9.8123456, 0.01),
        registry.Quantity(ufloat(9.8123456, 0.01), "m/s^2"),
        quantity,
    ):
        given = gyrodata.analyze(SAMPLE, settings={"g": value})
        assert given.inertia.value == pytest.approx(written.inertia.value, rel=1e-12)
        assert given.inertia.u == pytest.approx(written.inertia.u, rel=1e-9)
    assert (
        gyrodata.analyze(SAMPLE, settings={"g": 9.8123456}).measurements.g == 9.8123456
    )


@pytest.mark.slow
def test_columns_have_their_units_in_four_ways() -> None:
    plain = table().rename(
        columns={name: f"{name} [{unit}]" for name, unit in UNITS.items()}
    )
    expected = gyrodata.analyze(plain)
    pairs = table()
    pairs.columns = pd.Index(
        [(name, UNITS.get(name, "")) for name in pairs.columns], tupleize_cols=False
    )
    two_levels = table()
    two_levels.columns = pd.MultiIndex.from_tuples(
        [(name, UNITS.get(name, "")) for name in two_levels.columns]
    )
    beside = table()
    beside.attrs["units"] = UNITS
    registry = pint.UnitRegistry()
    cells = plain.rename(columns={"spin [rpm]": "spin", "time [s]": "time"})
    cells["spin"] = [registry.Quantity(value, "rpm") for value in cells["spin"]]
    cells["time"] = [registry.Quantity(value, "s") for value in cells["time"]]
    for frame in (pairs, two_levels, beside, cells):
        assert gyrodata.analyze(frame).inertia.value == pytest.approx(
            expected.inertia.value, rel=1e-12
        )


WRONG: list[tuple[Callable[[Any], Any], type[Exception], str]] = [
    (lambda g: g.analyze(SAMPLE, model="stedy"), ValueError, "did you mean 'steady'"),
    (lambda g: g.analyze(SAMPLE, keep_flagged="no"), TypeError, "True or False"),
    (lambda g: g.analyze(3), TypeError, "a log is a path"),
    (
        lambda g: g.analyze(SAMPLE, settings={"gg": "9.8 m/s^2"}),
        gyrodata.InputError,
        "did you mean g",
    ),
    (lambda g: g.analyze(SAMPLE, mapping="time=T"), TypeError, "mapping is a mapping"),
    (lambda g: g.analyze(SAMPLE).plot("torq"), ValueError, "did you mean 'torque'"),
    (
        lambda g: g.analyze(SAMPLE).plot("torque", ax=Figure()),
        TypeError,
        "ax is axes of matplotlib",
    ),
    (lambda g: g.fit_line([1, 2], [1, 2, 3]), ValueError, "the same length"),
    (lambda g: g.simulate(g.Truth(inertia=-1.0)), gyrodata.InputError, "be above zero"),
    (lambda g: g.analyze([], together=True), ValueError, "one log or more"),
    (lambda g: g.simulate(noise={"u_tme": 0.1}), ValueError, "did you mean 'u_time'"),
    (lambda g: g.Uncertainty(-1.0), ValueError, "0 or more"),
    (lambda g: g.Uncertainty(math.nan), ValueError, "0 or more"),
    (lambda g: g.Uncertainty("0.1 s"), TypeError, "a number in SI"),
    (lambda g: g.fit_line([1, 2], [1, 2], intercept="no"), TypeError, "True or False"),
    (lambda g: g.grade(SAMPLE.parent, workers=-1), ValueError, "0 or more"),
    (lambda g: g.grade(3), TypeError, "the path of a folder"),
    (lambda g: g.selfcheck(SAMPLE), TypeError, "result of analyze"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("call", "kind", "words"), WRONG)
def test_a_wrong_argument_is_refused(
    call: Callable[[Any], Any], kind: type[Exception], words: str
) -> None:
    with pytest.raises(kind, match=words):
        call(gyrodata)


@pytest.mark.slow
def test_rubric_of_the_package_has_a_name() -> None:
    usual, full, simple = (
        gyrodata.grade(SAMPLE.parent / "class", rubric).rubric
        for rubric in (None, "full", "simple")
    )
    assert usual == full
    assert len(simple.criteria) < len(full.criteria)


USERS = TESTS / "support" / "users_script.py"


@pytest.mark.slow
def test_the_script_of_a_user_runs(tmp_path: Path) -> None:
    matplotlib.use("agg")
    assert everything(
        SAMPLE, SAMPLE.parent / "class", tmp_path / "report"
    ) == pytest.approx(35, abs=1)
    assert (tmp_path / "report" / "report.html").exists()


PAGE = (Path(gyrodata.__file__).parent / "docs" / "python.md").read_text(
    encoding="utf-8"
)


def test_page_describes_every_public_name_and_attribute() -> None:
    assert reference(PAGE) == PAGE, "python tests/make_documents.py updates the page"
    names = set(gyrodata.__all__) - {"__version__"}
    assert set(re.findall(r"^<!-- reference: (\w+) -->$", PAGE, re.MULTILINE)) == names
    examples = "".join(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL))
    assert [
        name for name in names if name.islower() and f".{name}(" not in examples
    ] == []
    assert Analysis.__struct_fields__ == tuple(
        name for name, _, _ in section(Analysis, "Attributes")
    )
    assert all(len(text) > 5 for _, _, text in section(Analysis, "Attributes"))


@pytest.mark.slow
def test_warnings_name_each_code_once_with_python_remedies() -> None:
    log = (
        b"mass [g],position [cm],spin [rpm],time [s],foo,bar\n20,15,200,19.6,1,2\n"
        b"40,15,400,19.7,3,4\n"
    )
    with pytest.warns(gyrodata.GyroWarning) as caught:
        lab = gyrodata.analyze(log, settings={"turns": "1"})
    codes = [re.search(r"G\d{3}", str(one.message))[0] for one in caught]  # type: ignore[index]
    assert codes == [
        *dict.fromkeys(one.code for one in lab.diagnostics if one.severity == "warning")
    ]
    assert {one.filename for one in caught} == {__file__}
    text = "\n".join(map(str, lab.diagnostics))
    assert "--" not in text
    assert 'mapping={"role": "HEADER"}' in text
    with pytest.raises(gyrodata.LogError, match=r'settings=\{"turns": "1"\}') as error:
        gyrodata.analyze(log)
    assert "--" not in str(error.value)
    assert (
        in_python('--map time="T (s)" --set turns=5?')
        == 'mapping={"time": "T (s)"}, settings={"turns": "5"}?'
    )


def test_everything_returned_is_readable_text(lab: Analysis) -> None:
    assert lab.summary() == str(lab)
    assert "in 95 %" in str(lab.selfcheck(labs=5))
    simulation = gyrodata.simulate()
    assert str(simulation) == simulation.log
    assert repr(simulation) == "<Simulation of 9 runs>"
    line = gyrodata.fit_line([1.0, 2.0, 3.0], [1.0, 2.1, 2.9], cov_y=0.01)
    assert (
        str(line)
        == "y = (0.950±0.071) x + (0.10±0.15), chi-square 1.5 with 1 degrees of freedom"
    )


def test_package_says_that_it_has_types() -> None:
    assert (Path(gyrodata.__file__).parent / "py.typed").exists()


@pytest.mark.parametrize("text", ["plain", "half of a pair: \udc80", "\x7f"])
def test_json_contains_null_for_a_number_that_is_none(text: str) -> None:
    written = json.loads(encode({"values": [math.nan, math.inf, 1.5], "text": text}))
    assert written == {"values": [None, None, 1.5], "text": text}


def test_equal_analyses_have_equal_hashes(lab: Analysis) -> None:
    value = float(np.nextafter(lab.inertia.value, 1.0))
    other = replace(lab, inertia=replace(lab.inertia, value=value))
    assert other == lab
    assert hash(other) == hash(lab)


@pytest.mark.slow
def test_the_table_of_runs_can_be_analysed_again(lab: Analysis) -> None:
    runs = lab.runs
    assert runs.attrs["units"]["spin"] == "rad/s"
    again = gyrodata.analyze(runs)
    first = gyrodata.analyze(SAMPLE)
    u = first.inertia.u or 0.0
    assert abs(again.inertia.value - first.inertia.value) < 0.01 * u
    assert again.inertia.u == pytest.approx(u, rel=0.01)


def test_every_table_is_a_dataframe(lab: Analysis) -> None:
    for name in TABLES:
        assert len(lab.table(name)) == len(getattr(lab, name)), name
    shares = lab.table("budget")["share"]
    assert shares.sum() == pytest.approx(1.0)
    assert lab.table("fits")["inertia.value"].notna().all()
    with pytest.raises(ValueError, match="did you mean 'budget'"):
        lab.table("budgets")
