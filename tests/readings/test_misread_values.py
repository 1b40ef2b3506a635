"""Values that can be misread in silence: g, times with a colon, floats of a DataFrame,
rows typed twice.
"""

from __future__ import annotations

import io
import math
import re
from pathlib import Path

import pandas as pd
import pytest
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app

TRUTH, G = 4.44e-3, 9.81
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"


def rpm(mass: float, time: float) -> float:
    """Spin of a run of a third of a turn."""
    return time * 3 * mass * 1e-3 * G * 0.148 / (TRUTH * (2 * math.pi) ** 2) * 60


# Each time could be one in minutes and seconds; the hand is up to 0.1 s off.
RUNS = [
    (20.12, 6.52, 0.06),
    (20.12, 13.06, -0.1),
    (20.12, 19.54, 0.05),
    (40.31, 3.48, 0.02),
    (40.31, 6.58, 0.08),
    (40.31, 10.06, -0.07),
    (60.25, 2.27, -0.05),
    (60.25, 4.41, 0.03),
    (60.25, 6.53, -0.02),
]
ROWS = [
    [f"{mass:.2f}", "14.8", f"{rpm(mass, time + off):.0f}", f"{time:.2f}", "1/3"]
    for mass, time, off in RUNS
]


def written(
    head: str = HEAD, rows: list[list[str]] = ROWS, above: str = "# g: 9.81 m/s^2"
) -> str:
    return "\n".join([above, head, *map(",".join, rows), ""])


def timed() -> list[list[str]]:
    """Rows whose time has a colon for its point, as a sports stopwatch shows it."""
    return [[*row[:3], row[3].zfill(5).replace(".", ":"), row[4]] for row in ROWS]


def gyro(*arguments: str, stdin: str = "") -> Result:
    return CliRunner().invoke(app, list(arguments), input=stdin, prog_name="gyro")


def answer(log: str, code: str = "G[23]") -> tuple[float, str]:
    """I_zz of a log, and what is said of its values."""
    try:
        done = analyze_briefly(log.encode())
    except gyrodata.LogError as error:
        return math.nan, str(error)
    return done.inertia.value, "\n".join(
        str(one) for one in done.diagnostics if re.match(code, one.code)
    )


def times(log: str) -> list[float | None]:
    """Times as they are read [s]."""
    return [
        reading.value for reading in gyrodata.read_log(log).columns["time"].readings
    ]


def hint(told: str, pattern: str) -> str:
    match = re.search(pattern, told)
    assert match, told
    return match[1]


class TestGravity:
    @pytest.mark.parametrize("typed", ["981", "-9.81 m/s^2", "10", "1.62 m/s^2"])
    def test_g_of_no_place_is_refused_with_a_sample(self, typed: str) -> None:
        value, told = answer(written(above=f"# g: {typed}"))
        assert math.isnan(value)
        assert "usual are 9.7 to 9.9 m/s^2" in told or "is not above zero" in told
        sample = hint(told, r'such as "(.*)"')
        assert answer(written(above=f"# g: {sample.removeprefix('# g: ')}")) == (
            pytest.approx(TRUTH, rel=0.01),
            "",
        )

    @pytest.mark.parametrize("typed", ["9.76 m/s^2", "981 cm/s^2"])
    def test_g_of_any_place_is_read_without_a_note(self, typed: str) -> None:
        assert answer(written(above=f"# g: {typed}")) == (
            pytest.approx(TRUTH, rel=0.01),
            "",
        )

    def test_g_without_unit_is_read_with_a_note(self) -> None:
        value, told = answer(written(above="# g: 9,81"))
        assert "note G309" in told
        assert answer(written(above="# g: " + hint(told, r'write "(.*)"'))) == (
            value,
            "",
        )


class TestColons:
    @pytest.mark.slow
    def test_a_colon_below_seconds_is_asked_about(self) -> None:
        value, told = answer(written(rows=timed()))
        assert math.isnan(value)
        assert told.count("error G233") == 1
        first, head = timed()[0][3], hint(told, r'write the header as "(.*?)"')
        assert (
            f'time "{first}" in a column in seconds can be {ROWS[0][3].zfill(5)} s or '
            in told
        )
        assert hint(told, r"write ([0-9.]+),") == ROWS[0][3].zfill(5)
        assert answer(written()) == (pytest.approx(TRUTH, rel=0.01), "")
        long = written(HEAD.replace("time [s]", head), timed())
        assert gyrodata.analyze(long.encode()).run_table[0].time == 60 * int(
            first[:2]
        ) + int(first[3:])

    @pytest.mark.parametrize("head", ['"t, s"', "Time for 1/3 rev (s)"])
    def test_the_header_asked_for_is_read_as_minutes(self, head: str) -> None:
        rows = [[*row[:3], "2:05", row[4]] for row in ROWS]
        told = answer(written(HEAD.replace("time [s]", head), rows))[1]
        new = hint(told, r'write the header as "(.*?)"')
        assert times(written(HEAD.replace("time [s]", new), rows)) == [125.0] * 9

    def test_colons_above_59_are_asked_about_too(self) -> None:
        value, told = answer(
            written(
                rows=[
                    *timed(),
                    ["20.12", "14.8", f"{rpm(20.12, 7.9):.0f}", "07:90", "1/3"],
                ]
            )
        )
        assert "error G233" in told
        assert math.isnan(value)

    @pytest.mark.parametrize(
        ("head", "cell", "seconds"),
        [
            ("time", "01:06.52", 66.52),
            ("time [min:s]", "01:06.52", 66.52),
            ("t (mm:ss)", "2:05", 125.0),
            ("time [s]", "01:06.52", 66.52),
        ],
    )
    def test_a_clock_time_is_read_in_minutes(
        self, head: str, cell: str, seconds: float
    ) -> None:
        rows = [[*row[:3], cell, row[4]] for row in ROWS]
        assert times(written(HEAD.replace("time [s]", head), rows)) == pytest.approx(
            [seconds] * 9
        )

    def test_a_plain_number_among_colons_is_asked_about(self) -> None:
        value, told = answer(written(rows=[*ROWS[:3], *timed()[3:]]))
        assert math.isnan(value)
        assert timed()[3][3] in told


def as_frame(log: str, **options: object) -> pd.DataFrame:
    return pd.read_csv(io.StringIO(log), comment=("#"), **options)  # type: ignore[call-overload, no-any-return]


def typed(position: str = "15.0") -> str:
    """Write a log with other digits."""
    return written(rows=[[row[0], position, *row[2:]] for row in ROWS])


class TestFloats:
    @pytest.mark.slow
    @pytest.mark.parametrize(
        "log",
        [
            typed(),
            typed(position="15.00"),
            typed().replace(",15.0,", ",,", 1).replace("20.12,,", "0,,"),
        ],
    )
    def test_u_of_a_frame_is_that_of_the_file(self, log: str) -> None:
        file = analyze_briefly(log.encode()).inertia
        frame = analyze_briefly(as_frame(log), settings={"g": "9.81 m/s^2"}).inertia
        assert frame.value == pytest.approx(file.value, rel=2e-3)
        assert 0.95 < frame.u / file.u < 1.05
        text = analyze_briefly(
            as_frame(log, dtype=str), settings={"g": "9.81 m/s^2"}
        ).inertia
        assert text.u == pytest.approx(file.u, rel=1e-9)

    @pytest.mark.slow
    def test_a_note_names_the_columns_without_digits(self) -> None:
        done = gyrodata.analyze(as_frame(typed()), settings={"g": "9.81 m/s^2"})
        note = next(one for one in done.diagnostics if one.code == "G235")
        assert note.message.endswith("no rounding error is in time, mass, position")
        stated = {
            "g": "9.81 m/s^2",
            "u_position": "0.3 mm",
            "u_mass": "0.1 g",
            "u_time": "0.1 s",
        }
        done = gyrodata.analyze(as_frame(typed()), settings=stated)
        assert "G235" not in [one.code for one in done.diagnostics]
        done = gyrodata.analyze(
            as_frame(typed(), dtype=str), settings={"g": "9.81 m/s^2"}
        )
        assert "G235" not in [one.code for one in done.diagnostics]


class TestIdenticalRows:
    @pytest.mark.slow
    def test_a_copied_row_is_named_and_deleted(self) -> None:
        value, told = answer(written(rows=[*ROWS, ROWS[4]]), "G408")
        assert "warning G408: lines 7 and 12 are identical" in told
        assert "delete one of them" in told
        assert answer(written(rows=ROWS), "G408") == (
            pytest.approx(value, rel=0.005),
            "",
        )
        assert "G408" in gyro("check", "-", stdin=written(rows=[*ROWS, ROWS[4]])).output

    def test_two_equal_times_in_one_row_are_not_copied_rows(self) -> None:
        rows = "".join(
            f"{mass},15.0,400,{time},{time},1\n"
            for mass, time in ((20, "39.13"), (40, "19.62"))
        )
        log = "mass [g],position [cm],spin [rpm],time_1 [s],time_2 [s],turns\n" + rows
        assert answer(log, "G408")[1] == ""
        assert "G408" in answer(log + rows, "G408")[1]

    def test_coarse_times_may_agree_by_chance(self) -> None:
        for digits in (0, 1):
            rows = [
                [*r[:3], f"{float(r[3]):.{digits}f}", r[4]] for r in [*ROWS, ROWS[4]]
            ]
            assert answer(written(rows=rows), "G408")[1] == ""
        rows = [[*row[:3], f"{float(row[3]):.1f}", row[4]] for row in ROWS]
        assert "G408" in answer(written(rows=rows * 2), "G408")[1], (
            "but not all of them"
        )


class TestDigitsShown:
    @pytest.mark.slow
    def test_loads_have_the_digits_of_the_log(self, tmp_path: Path) -> None:
        (tmp_path / "log.csv").write_text(typed(), encoding="utf-8")
        done = gyro(
            "analyze",
            str(tmp_path / "log.csv"),
            "-v",
            "--out",
            str(tmp_path / "report"),
        )
        page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
        assert "run 1: 20.12 g at 15.0 cm from the centre" in done.output
        assert not re.search(r"\b15 cm|> ?15</data>", done.output + page)
