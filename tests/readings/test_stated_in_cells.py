"""Constants in two cells, as in a workbook, or in a line without #, count as they do
behind #.
"""

import io

import openpyxl
import pytest

import gyrodata

TABLE = """mass [g],position [cm],spin [rpm],time [s],turns
20.1,14.8,212,6.95,1/3
40.3,14.8,398,6.71,1/3
60.2,14.8,604,20.12,1
"""
STATED = {
    "u_mass": "2 %",
    "u_time": "0.5 s",
    "u_position_zero": "3 mm",
    "u_imbalance": "2 mN*m",
    "balance_drift": "5 deg in 60 s at 400 rpm",
    "motion": "steady",
    "balanced": "no",
    "spin_down": "612 rpm to 540 rpm in 120 s",
    "ball_diameter": "101.6 mm",
}


def constants_of(log: str | bytes) -> list[object]:
    names = (
        "constants",
        "uncertainties",
        "motion",
        "balanced",
        "balance_drift",
        "spin_down",
    )
    readings = gyrodata.read_log(log.encode() if isinstance(log, str) else log)
    return [getattr(readings, name) for name in names]


def answer(log: str | bytes) -> gyrodata.Analysis:
    return gyrodata.analyze(log.encode() if isinstance(log, str) else log)


def in_a_workbook(*above: list[str]) -> bytes:
    book = openpyxl.Workbook()
    for row in [*above, *(line.split(",") for line in TABLE.splitlines())]:
        book.active.append(row)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize("key", STATED)
def test_constant_in_cells_counts_as_it_does_behind_a_hash(key: str) -> None:
    value = STATED[key]
    expected = constants_of(f"# {key}: {value}\n{TABLE}")
    assert expected != constants_of(TABLE)
    number, _, unit = value.partition(" ")
    logs = [
        f"{key},{value}\n{TABLE}",
        f"{key}: {value}\n{TABLE}",
        f"{TABLE}\n{key} = {value}\n",
    ]
    logs.append(in_a_workbook([key, value]))
    logs += [in_a_workbook([key, number, unit])] if unit and " " not in unit else []
    for log in logs:
        assert constants_of(log) == expected


@pytest.mark.slow
def test_row_of_uncertainties_is_still_a_row_of_a_table() -> None:
    rows = [line.split(",") for line in TABLE.splitlines()]
    for row, cell in zip(rows, ["u_time [s]", "0.2", "0.3", "0.4"], strict=True):
        row.append(cell)
    with pytest.raises(gyrodata.LogError) as caught:
        answer("\n".join(map(",".join, zip(*rows, strict=True))))
    (fault,) = caught.value.diagnostics
    assert (fault.code, "Transpose" in fault.hint) == ("G201", True)


def test_uncertainty_that_cannot_be_read_is_an_error_with_its_place() -> None:
    with pytest.raises(gyrodata.LogError) as caught:
        answer(f"u_time,0.5 cm\n{TABLE}")
    (fault,) = [one for one in caught.value.diagnostics if one.severity == "error"]
    assert (fault.line, fault.message.startswith("# u_time")) == (1, True)
