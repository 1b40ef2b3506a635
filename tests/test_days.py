"""Several days or groups of one gyroscope: one I_zz, and an M0 for each day.

All logs are simulated: 9 runs a day at 15 cm, true I_zz 4.44e-3 kg·m², M0 as stated.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from analyzed_once import analyzed_once
from typer.testing import CliRunner

import gyrodata
from gyrodata import Analysis
from gyrodata.analysis import fit_log
from gyrodata.base.errors import LogError
from gyrodata.cli import app
from gyrodata.readings import read_log
from gyrodata.readings.together import read_together
from gyrodata.results import FittedLog, Options

TRUTH = 4.44e-3
G = 9.80665
HEADER = "mass [g],position [cm],spin [rpm],time [s],turns"
MOTION = "# motion: steady"
"""A silent log is fitted for other motions too, which takes five times as long."""
BALANCES = 1.5e-3, -1.5e-3

pytestmark = pytest.mark.filterwarnings("ignore")


def rows_of_day(
    m0: float, seed: int, inertia: float = TRUTH, press: float = 0.14
) -> list[str]:
    """Draw the rows of a day with a residual torque [N*m] and an I_zz [kg*m^2]."""
    random = np.random.default_rng([74, seed])
    late = 0.08 * random.standard_normal()
    rows = []
    for grams in (20, 40, 60):
        for rpm in (200, 400, 600):
            torque = 1e-3 * grams * G * 0.15 + m0
            time = 2 * np.pi * inertia * rpm * np.pi / 30 / torque
            time += late + press * random.standard_normal()
            read = rpm * (1 + 0.002 * random.standard_normal())
            rows.append(f"{grams}.0,15.0,{read:.0f},{time:.2f},1")
    return rows


def file(rows: list[str], *lines: str) -> bytes:
    return "\n".join([*lines, MOTION, HEADER, *rows, ""]).encode()


def with_column(name: str, days: dict[str, list[str]]) -> bytes:
    """Write the rows of several days as one log, with the day in the first column."""
    rows = [f"{day},{row}" for day, each in days.items() for row in each]
    return "\n".join([MOTION, f"{name},{HEADER}", *rows, ""]).encode()


def two_days(**changed: float) -> dict[str, list[str]]:
    return {
        "Mon": rows_of_day(BALANCES[0], 1),
        "Fri": rows_of_day(BALANCES[1], 2, **changed),
    }


def u(analysis: Analysis | FittedLog) -> float:
    return float(analysis.inertia.u or 0.0)


def fitted(log: bytes) -> FittedLog:
    return fit_log(read_log(log, name="log.csv"), Options())


def test_one_log_with_a_column_is_two_logs_together() -> None:
    days = two_days()
    silent = f"{MOTION}\n".encode(), b""
    one = gyrodata.analyze(with_column("day", days).replace(*silent))
    logs = [file(rows).replace(*silent) for rows in days.values()]
    both = gyrodata.analyze(logs, together=True)
    for name in ("inertia", "residual_torque", "timing_bias"):
        first, second = getattr(one, name), getattr(both, name)
        assert first.value == pytest.approx(second.value, rel=1e-9)
        assert first.u == pytest.approx(second.u, rel=1e-9)
    for first, second in zip(one.blocks, both.blocks, strict=True):
        assert first.inertia == second.inertia
        assert first.residual_torque == second.residual_torque


def test_two_days_are_better_than_the_better_day() -> None:
    days = two_days()
    alone = [gyrodata.analyze(file(rows)) for rows in days.values()]
    both = gyrodata.analyze(with_column("day", days))
    assert u(both) < 0.97 * min(map(u, alone))
    low, high = both.inertia.interval_95
    assert low < TRUTH < high
    # Each day alone is what its own log gives, and M0 of each is near the truth.
    for block, lab, m0 in zip(both.blocks, alone, BALANCES, strict=True):
        assert block.inertia.value == pytest.approx(lab.inertia.value, rel=1e-9)
        assert abs(block.residual_torque.value - m0) < 3 * block.residual_torque.u
    assert not [found for found in both.diagnostics if found.code == "G460"]
    assert both.blocks_agreement.p > 0.01


@pytest.mark.parametrize(
    "lines", [("# ruler: 2",), ("# u_position_zero: 1.0001 mm",)], ids=str
)
def test_another_ruler_has_its_own_zero(lines: tuple[str, ...]) -> None:
    monday, friday = two_days().values()
    same = gyrodata.analyze([file(monday), file(friday)], together=True)
    other = gyrodata.analyze([file(monday), file(friday, *lines)], together=True)
    alone = gyrodata.analyze(file(monday))
    assert u(other) < 0.88 * u(alone)
    assert u(other) < 0.95 * u(same)


def test_the_order_of_days_does_not_matter() -> None:
    monday, friday = two_days().values()
    logs = [file(monday), file(friday)]
    first = gyrodata.analyze(logs, together=True)
    second = gyrodata.analyze(logs[::-1], together=True)
    assert first.inertia.value == pytest.approx(second.inertia.value, rel=1e-9)
    assert u(first) == pytest.approx(u(second), rel=1e-9)


def test_another_ball_on_one_day_is_a_finding() -> None:
    log = with_column("day", two_days(inertia=1.08 * TRUTH))
    analysis = gyrodata.analyze(log)
    [finding] = [found for found in analysis.diagnostics if found.code == "G460"]
    assert "Mon, Fri" in finding.message
    assert analysis.blocks_agreement.p < 0.01
    assert "contradiction" in [doubt.kind for doubt in analysis.doubts]


def test_three_days_are_compared_with_each_other() -> None:
    days = two_days() | {"Sun": rows_of_day(0.0, 3, 1.1 * TRUTH)}
    agreement = fitted(with_column("day", days)).blocks_agreement
    assert (agreement.dof, agreement.p < 0.01) == (2, True)


@pytest.mark.parametrize("name", ["date", "group", "Tag", "jour", "fecha", "日付"])
def test_days_have_names_in_many_languages(name: str) -> None:
    labels = [block.name for block in fitted(with_column(name, two_days())).blocks]
    assert labels == ["Mon", "Fri"]


def test_cells_of_a_day_can_be_blank_or_have_a_time() -> None:
    days = two_days()
    rows = [
        f"{day} 10:{15 + i}" * (i != 4) + f",{row}"
        for day, each in days.items()
        for i, row in enumerate(each)
    ]
    log = "\n".join([MOTION, f"date,{HEADER}", *rows, ""]).encode()
    assert [block.name for block in fitted(log).blocks] == ["Mon", "Fri"]


@pytest.mark.parametrize(
    "cells",
    [
        ["7"] * 9,
        [f"team {i}" for i in range(9)],
        [f"10:{i + 10}" for i in range(9)],
        [*"aaabbbccc"],
    ],
    ids=["constant", "one for each run", "times of the day", "the weights"],
)
def test_a_column_that_is_no_block_is_named(cells: list[str]) -> None:
    rows = rows_of_day(0.0, 1)
    typed = [f"{cell},{row}" for cell, row in zip(cells, rows, strict=True)]
    log = "\n".join([MOTION, f"group,{HEADER}", *typed, ""]).encode()
    lab = fitted(log)
    assert not lab.blocks
    assert u(lab) == u(fitted(file(rows)))
    assert [each for each in lab.diagnostics if '"group" is not used' in each.message]


@pytest.mark.parametrize("count", [1, 3], ids=["one run", "one weight"])
def test_a_day_with_few_runs_has_an_m0_and_adds_little(count: int) -> None:
    monday, friday = two_days().values()
    lab = fitted(with_column("day", {"Mon": monday, "Fri": friday[:count]}))
    last = lab.blocks[-1]
    assert last.runs == count
    # I_zz of the other day determines M0.
    m0 = last.residual_torque
    assert abs(m0.value - BALANCES[1]) < 3 * m0.u
    assert 0.9 < u(lab) / u(fitted(file(monday))) < 1.1


def test_a_contradiction_is_quoted_from_both_logs(tmp_path: Path) -> None:
    monday, friday = two_days().values()
    logs = tmp_path / "monday.csv", tmp_path / "friday.csv"
    logs[0].write_bytes(file(monday, "# ball_mass: 4.31 kg"))
    logs[1].write_bytes(file(friday, "# ball_mass: 2.10 kg"))
    with pytest.raises(LogError) as caught:
        gyrodata.analyze(list(map(str, logs)), together=True)
    [error] = caught.value.diagnostics
    assert (error.code, error.line) == ("G311", 1)
    assert '"# ball_mass: 4.31 kg"' in error.message
    assert '"# ball_mass: 2.10 kg"' in error.message
    with pytest.raises(LogError, match="given twice"):
        gyrodata.analyze([str(logs[0]), str(logs[0])], together=True)


def test_the_line_of_the_key_is_quoted_and_no_other() -> None:
    rows = rows_of_day(0.0, 1)
    drift = "# balance_drift: 3 deg in 60 s at 400 rpm"
    logs = [
        file(rows, drift, "# balance: untouched"),
        file(rows_of_day(0.0, 2), drift, "# balance: touched"),
    ]
    notes = gyrodata.analyze(logs, together=True).diagnostics
    [note] = [each for each in notes if each.code == "G312"]
    assert '"# balance: untouched"' in note.message
    assert '"# balance: touched"' in note.message


def test_logs_without_common_readings_are_refused() -> None:
    monday, friday = two_days().values()
    other = file(friday).replace(b"spin [rpm]", b"spin_start [rpm]")
    other = other.replace(b"turns\n", b"turns,spin_end [rpm]\n")
    lines = [
        line + b",190" if b",15.0," in line else line for line in other.split(b"\n")
    ]
    with pytest.raises(LogError, match="different readings"):
        gyrodata.analyze([file(monday), b"\n".join(lines)], together=True)


def test_a_finding_has_its_place_in_its_own_log() -> None:
    monday, friday = two_days().values()
    mistaken = friday[4].split(",")
    mistaken[3] = str(10 * float(mistaken[3]))
    logs = [file(monday), file([*friday[:4], ",".join(mistaken), *friday[5:]])]
    analysis = gyrodata.analyze(logs, together=True)
    lines = [found.line for found in analysis.diagnostics if found.line]
    assert 7 in lines
    assert max(lines) <= 11
    columns = [found.column for found in analysis.diagnostics if found.line == 7]
    # The mistaken cell is the fourth one.
    assert 1 + len(",".join(mistaken[:3])) + 1 in columns
    assert analysis.run_table[-1].line == 11


def test_a_copied_row_has_its_line_in_each_log(tmp_path: Path) -> None:
    # With the same M0, the copies are no odd runs.
    monday, friday = rows_of_day(0.0, 1), rows_of_day(0.0, 2)
    names = [tmp_path / "mon.csv", tmp_path / "fri.csv"]
    names[0].write_bytes(file(monday, "# observer: A", "# tachometer: follows"))
    names[1].write_bytes(file([*friday, *monday[2:7]], "# tachometer: follows"))
    done = CliRunner().invoke(app, ["check", *map(str, names), "--together"])
    lines = re.findall(r"rows mon\.csv!(\d+) and fri\.csv!(\d+)", done.output)
    assert lines == [(str(7 + row), str(13 + row)) for row in range(5)]


def test_the_command_writes_table_figure_and_json(tmp_path: Path) -> None:
    names = []
    for day, rows in two_days().items():
        names.append(str(tmp_path / f"{day}.csv"))
        Path(names[-1]).write_bytes(file(rows))
    out = tmp_path / "report"
    run = CliRunner()
    done = run.invoke(app, ["analyze", *names, "--together", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "Mon, Fri: each has its own M0" in done.stdout
    assert (out / "days.svg").exists()
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Days and groups" in page
    done = run.invoke(app, ["analyze", *names, "--together", "-f", "json"])
    result = json.loads(done.stdout)["result"]
    assert [block["name"] for block in result["blocks"]] == ["Mon", "Fri"]
    assert 0.01 < result["blocks_agreement"]["p"] <= 1


def test_check_of_days_says_what_analyze_doubts(tmp_path: Path) -> None:
    names = ["mon.csv", "fri.csv"]
    paths = [str(tmp_path / name) for name in names]
    for path, rows in zip(paths, two_days(inertia=1.08 * TRUTH).values(), strict=True):
        Path(path).write_bytes(file(rows))
    analysis = gyrodata.analyze(paths, together=True)
    ask = ["check", *paths, "--together"]
    with analyzed_once():
        done = CliRunner().invoke(app, [*ask, "--format", "json"])
        shown = CliRunner().invoke(app, ask).stdout
        fixed = CliRunner().invoke(app, [*ask, "--fix", "--exit-zero"])
    document = json.loads(done.stdout)
    assert done.exit_code == 1
    assert document["input"]["rows"] == 18
    words = [doubt["words"] for doubt in document["doubts"]]
    assert words == [doubt.words for doubt in analysis.doubts]
    assert "do not have the same I_zz" in words[0]
    codes = {each["code"] for each in document["diagnostics"]}
    assert {each.code for each in analysis.diagnostics} <= codes
    assert "do not have the same I_zz" in shown
    alone = CliRunner().invoke(app, ["check", *paths]).stdout
    assert "do not have the same I_zz" not in alone
    assert fixed.exit_code == 0
    again = [str(tmp_path / name.replace(".", "-fixed.")) for name in names]
    fixed_logs = read_together([read_log(Path(path)) for path in again])
    fitted_again = fit_log(fixed_logs, Options()).inertia
    assert fitted_again.value == pytest.approx(analysis.inertia.value, rel=1e-9)


def test_a_contradiction_of_logs_is_a_finding_of_check(tmp_path: Path) -> None:
    paths = [tmp_path / "mon.csv", tmp_path / "fri.csv"]
    for path, rows, g in zip(paths, two_days().values(), (9.80, 9.81), strict=True):
        path.write_bytes(file(rows, f"# g: {g} m/s^2"))
    done = CliRunner().invoke(app, ["check", *map(str, paths), "--together"])
    assert done.exit_code == 1
    assert "# g: 9.81 m/s^2" in done.stdout


def test_days_of_rates_have_their_m0() -> None:
    rows = []
    for day, m0 in zip(("Mon", "Fri"), BALANCES, strict=True):
        for row in rows_of_day(m0, 5, press=0.02):
            mass, position, spin, time, _ = row.split(",")
            rows.append(f"{day},{mass},{position},{spin},{60 / float(time):.4f}")
    head = f"{MOTION}\nday,mass [g],position [cm],spin [rpm],precession_rate [rpm]"
    analysis = gyrodata.analyze("\n".join([head, *rows, ""]).encode(), name="log.csv")
    found = [block.residual_torque.value for block in analysis.blocks]
    assert found == pytest.approx(BALANCES, abs=5e-4)
    mean = analysis.residual_torque.value
    assert np.mean(found) == pytest.approx(mean, abs=1e-12)


def test_a_day_without_a_weight_is_not_compared() -> None:
    days = two_days()
    without = {"Mon": days["Mon"], "Wed": ["0,,400,150,1/20"]}
    assert fitted(with_column("day", without)).blocks_agreement is None
    three = days | {"Wed": ["0,,400,150,1/20"]}
    agreement = fitted(with_column("day", three)).blocks_agreement
    assert agreement is not None
    assert agreement.dof == 1
    assert agreement.p > 0.01


def test_a_spin_of_a_whole_log_is_another_reading_on_each_day() -> None:
    head = HEADER.replace("spin [rpm],", "")
    logs = []
    for number, rpm in enumerate((400, 600)):
        rows = [
            ",".join([*row.split(",")[:2], *row.split(",")[3:]])
            for row in rows_of_day(0.0, number)
            if abs(float(row.split(",")[2]) - rpm) < 20
        ]
        logs.append("\n".join([f"# spin: {rpm} rpm", head, *rows, ""]).encode())
    analysis = gyrodata.analyze(logs, together=True)
    [spin] = [each for each in analysis.measurements.sources if each.name == "spin"]
    assert [*spin.groups] == [0, 0, 0, 1, 1, 1]


def test_one_day_has_no_blocks_and_no_figure_of_days() -> None:
    analysis = gyrodata.analyze(gyrodata.sample())
    assert analysis.blocks == ()
    with pytest.raises(ValueError, match="days"):
        analysis.plot("days")
    with pytest.raises(TypeError, match="list"):
        gyrodata.analyze(gyrodata.sample(), together=True)


def test_the_lines_of_the_period_have_the_m0_of_their_day() -> None:
    log = with_column("day", two_days(press=0.02))
    axes = gyrodata.analyze(log, name="log.csv").plot("period")
    # A line for each torque: with one M0 for all days, equal weights had equal lines.
    slopes = [
        line.get_ydata()[1] / line.get_xdata()[1]
        for line in axes.lines
        if len(line.get_xdata()) == 2 and line.get_ydata()[1]
    ]
    expected = [
        2 * np.pi * TRUTH * np.pi / 30 / (1e-3 * grams * G * 0.15 + m0)
        for m0 in BALANCES
        for grams in (20, 40, 60)
    ]
    assert slopes == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_intervals_of_two_days_contain_the_truth() -> None:
    random = np.random.default_rng(74)
    inside = disagree = 0
    for number in range(12):
        days = {
            day: rows_of_day(1.5e-3 * random.standard_normal(), 10 * number + place)
            for place, day in enumerate(("Mon", "Fri"))
        }
        lab = fitted(with_column("day", days))
        low, high = lab.inertia.interval_95
        inside += low < TRUTH < high
        disagree += lab.blocks_agreement.p < 0.01
    assert inside >= 11
    assert disagree <= 1


def test_a_bad_balance_of_one_day_is_a_finding() -> None:
    """M0 of 60 % of the lightest torque on one day, and of -60 % on the other one."""
    rows = []
    lightest = 0.020 * G * 0.15
    for day, share in (("1", 0.6), ("2", -0.6)):
        for grams in (20, 40, 60):
            for rpm in (200, 400, 600):
                torque = grams * 1e-3 * G * 0.15 + share * lightest
                spin = rpm * np.pi / 30
                rows.append(
                    f"{day},{grams},15.0,{rpm},{2 * np.pi * TRUTH * spin / torque:.2f},1"
                )
    header = "day,mass [g],position [cm],spin [rpm],time [s],turns"
    log = "\n".join([f"# g: {G} m/s^2", header, *rows]) + "\n"
    lab = gyrodata.analyze(log.encode(), name="log.csv")
    poor = [one for one in lab.diagnostics if one.code == "G433"]
    assert len(poor) == 1
    assert poor[0].doubt == "size"
