"""A station on several days: a drift of its I_zz is found, and honest classes have none.

All logs are simulated: 9 runs, an M0 and a hand for each, true I_zz 4.44e-3 kg·m² on the
first day.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.test_class_page import Lab
from msgspec.structs import replace
from schemas import assert_valid
from test_days import HEADER, TRUTH, file, rows_of_day

from gyrodata.analysis import fit_log
from gyrodata.grading.grade import Grade, grade_submission
from gyrodata.grading.rubric import default_rubric_text, read_rubric
from gyrodata.grading.stations import (
    DayValue,
    StationFigures,
    class_references,
    each_log_once,
    station_figures,
)
from gyrodata.grading.submissions import Submission
from gyrodata.readings import read_log
from gyrodata.readings.together import read_together
from gyrodata.results import FittedLog, Options

pytestmark = pytest.mark.filterwarnings("ignore")

RUBRIC = read_rubric(default_rubric_text().encode())
NOBODY = grade_submission(
    Submission("nobody", "Nobody", {}, Path(), problem="none"), RUBRIC
)


def logs_of_days(
    days: Sequence[str], fall: float, students: int = 3, head: str = "# date: {}"
) -> dict[str, str]:
    """Draw the logs of a station whose I_zz falls by a share each day."""
    logs = {}
    for number, (day, student) in enumerate(
        itertools.product(range(len(days)), range(students))
    ):
        m0 = np.random.default_rng([1, number]).normal(0, 1e-3)
        rows = rows_of_day(m0, 100 + number, TRUTH * (1 - fall * day))
        lines = ["# station: 3", head.format(days[day])]
        logs[f"s{day}{student}/lab.csv"] = file(rows, *lines).decode()
    return logs


MARCH = ["2026-03-02", "3.3.2026", "4 March 2026", "2026/03/05", "March 6, 2026"]


def graded(home: Path, logs: dict[str, str]) -> tuple[dict[str, Any], str, str]:
    """Grade a class: its JSON, what the terminal shows, and the page."""
    lab = Lab(home, logs)
    shown = lab.grade().stdout
    document = json.loads(lab.read("grades.json"))
    assert_valid(document, "grades")
    return document, shown, lab.read("class.html")


@pytest.mark.slow
def test_a_station_that_drifts_is_named_and_costs_no_points(tmp_path: Path) -> None:
    fall = 0.02
    document, shown, page = graded(tmp_path, logs_of_days(MARCH, fall))
    [station] = document["stations"]
    assert abs(station["slope"] + fall) < 3 * station["slope_u"]
    assert station["p"] < 0.01
    assert [day["day"] for day in station["days"]] == [
        f"2026-03-0{day}" for day in range(2, 7)
    ]
    assert [day["logs"] for day in station["days"]] == [3] * 5
    for number, day in enumerate(station["days"]):
        assert abs(day["inertia"] - TRUTH * (1 - fall * number)) < 3 * day["u"]
    for text in (shown, page):
        assert "tation 3: I_zz falls by" in text
        assert "look at the ball or its balance" in text
    # Without days, all have the same points, and nothing is said.
    plain, silent, _ = graded(
        tmp_path / "plain", logs_of_days(MARCH, fall, head="# {} runs")
    )
    assert not plain["stations"]
    assert "look at the ball" not in silent
    points = [[one["points"] for one in each["students"]] for each in (document, plain)]
    assert points[0] == points[1]


@pytest.mark.slow
def test_a_column_with_one_day_is_the_day_of_a_log(tmp_path: Path) -> None:
    logs = {}
    for name, log in logs_of_days(["Mon", "Fri"], 0.06, 5, "# remark: {}").items():
        day = "Mon" if name < "s1" else "Fri"
        head, rows = log.split(HEADER)
        typed = [f"{day},{row}" for row in rows.split()]
        logs[name] = "\n".join([f"{head}day,{HEADER}", *typed, ""])
    document, shown, _ = graded(tmp_path, logs)
    [station] = document["stations"]
    assert station["slope"] is None
    assert [day["day"] for day in station["days"]] == ["fri", "mon"]
    assert "I_zz differs between the days (fri: " in shown
    notes = [one for each in document["students"] for one in each["diagnostics"]]
    assert not [one for one in notes if "not used" in one["message"]]


# The figures alone: values as the fits of simulated logs have them


def log_of(student: int, day: str, value: float, u: float = 1.3e-2 * TRUTH) -> Grade:
    """Return a grade of station 3 with one value of I_zz."""
    return replace(
        NOBODY,
        student=f"s{student:04d}",
        station="3",
        own={"recommended": {"value": value, "u": u}},
        inertia=value,
        inertia_u=u,
        days=(DayValue(day, value, u),),
    )


def drawn(seed: int, fall: float = 0.0, wrong: float = 0.0) -> list[Grade]:
    """Draw three logs on each of five days; some have a wrong unit."""
    random = np.random.default_rng([2, seed])
    logs = []
    for number in range(15):
        value = TRUTH * (1 - fall * (number // 3)) * (1 + random.normal(0, 0.01))
        if random.random() < wrong:
            value *= random.choice([0.1, 1.5, 3.0])
        logs.append(log_of(number, f"2026-03-0{2 + number // 3}", value))
    return logs


def figures(logs: Iterable[Grade]) -> StationFigures:
    [station] = station_figures(logs)
    return station


@pytest.mark.parametrize("wrong", [0.0, 0.05], ids=["honest", "wrong logs"])
def test_classes_without_a_drift_have_no_note(wrong: float) -> None:
    noted = sum(figures(drawn(seed, wrong=wrong)).differs for seed in range(200))
    assert noted <= 4


def test_a_balance_that_all_students_of_a_day_share_is_no_drift() -> None:
    noted = 0
    for seed in range(200):
        random = np.random.default_rng([5, seed])
        days = random.normal(0, 0.25 * 0.013, 3)
        logs = [
            log_of(at, f"2026-03-0{2 + at % 3}", TRUTH * (1 + days[at % 3] + error))
            for at, error in enumerate(random.normal(0, 0.01, 75))
        ]
        noted += figures(logs).differs
    assert noted <= 4


@pytest.mark.parametrize("wrong", [0.0, 0.05], ids=["honest", "wrong logs"])
def test_a_drift_has_its_size_and_uncertainty(wrong: float) -> None:
    fall = 0.012
    found = [figures(drawn(seed, fall, wrong)) for seed in range(200)]
    noted = [one for one in found if one.differs]
    assert len(noted) >= (180 if wrong == 0 else 160)
    slopes = [(one.slope, one.slope_u) for one in noted if one.slope is not None]
    assert len(slopes) >= 0.95 * len(noted)
    away = [abs(slope + fall) / u for slope, u in slopes]
    assert np.mean(np.array(away) < 2) >= 0.88
    assert np.median([slope for slope, _ in slopes]) == pytest.approx(-fall, rel=0.06)


def test_one_wrong_day_is_named_by_its_values() -> None:
    logs = []
    for number in range(40):
        value = TRUTH * (1 + np.random.default_rng([3, number]).normal(0, 0.01))
        day = number % 5
        logs.append(
            log_of(number, f"2026-03-0{2 + day}", value * (1 + 0.04 * (day == 2)))
        )
    station = figures(logs)
    assert station.differs
    assert station.slope is None
    means = [day.inertia / TRUTH for day in station.days]
    assert means == pytest.approx([1, 1, 1.04, 1, 1], abs=0.012)
    assert "2026-03-04: (4.5" in station.words


def test_figures_do_not_depend_on_order_scale_or_first_day() -> None:
    logs = drawn(1, 0.012)
    first = figures(logs)
    assert figures(logs[::-1]) == first
    later = [
        replace(log, days=(day._replace(day=day.day.replace("-03-", "-04-")),))
        for log in logs
        for day in log.days
    ]
    larger = [
        log_of(at, log.days[0].day, 2 * log.inertia, 2 * log.inertia_u)
        for at, log in enumerate(logs)
    ]
    for other in (figures(later), figures(larger)):
        assert other.slope == pytest.approx(first.slope, rel=1e-6)
        assert other.slope_u == pytest.approx(first.slope_u, rel=1e-6)
        assert other.p == pytest.approx(first.p, rel=1e-6)


def test_a_day_with_a_wrong_log_alone_is_no_drift() -> None:
    logs = [log_of(at, "2026-03-02", log.inertia) for at, log in enumerate(drawn(1))]
    logs += [log_of(99, "2026-03-09", 10 * TRUTH)]
    station = figures(logs)
    assert not station.differs
    assert station.p == 1
    # One log a day shows no scatter, and so no difference that is beyond it.
    alone = [log_of(at, f"day {at}", log.inertia) for at, log in enumerate(drawn(1))]
    assert figures(alone).p == 1


def test_hundreds_of_days_are_not_compared() -> None:
    logs = [log_of(at, f"day {at // 2}", TRUTH) for at in range(400)]
    assert not list(station_figures(logs))


def test_equal_logs_and_copies_count_once() -> None:
    logs = drawn(1, 0.012)
    equal = [replace(logs[0], student=f"t{at}") for at in range(9)]
    assert figures(each_log_once([*logs, *equal])) == figures(logs)
    copies = [
        log_of(1000 + at, "2026-03-02", (1 + 1e-3 * at) * logs[0].inertia)
        for at in range(9)
    ]
    flagged = [(logs[0].student, *(one.student for one in copies))]
    assert figures(each_log_once([*logs, *copies], flagged)) == figures(logs)
    assert figures(each_log_once([*logs, *copies])) != figures(logs)


# The reference


def fits(seed: int, count: int) -> tuple[list[FittedLog], FittedLog]:
    """Fit the logs of a station alone, and all of them together."""
    random = np.random.default_rng([4, seed])
    logs = []
    for number in range(count):
        rows = rows_of_day(random.normal(0, 1e-3), 1000 * seed + number)
        log = file(rows)
        logs.append(read_log(log, name=f"{number}.csv"))
    together = fit_log(read_together(logs), Options())
    return [fit_log(log, Options()) for log in logs], together


def reference(alone: Iterable[FittedLog]) -> Any:
    values = [("3", one.inertia.value, one.inertia.u) for one in alone]
    return class_references(values)["3"]


@pytest.mark.slow
def test_reference_of_a_station_is_the_joint_fit_of_its_logs() -> None:
    away = []
    for seed in range(2):
        alone, together = fits(seed, 5)
        away.append(
            (reference(alone).inertia - together.inertia.value) / together.inertia.u
        )
    assert math.sqrt(np.mean(np.square(away))) < 0.2


@pytest.mark.parametrize("factor", [0.1, 1.5, 3.0])
def test_one_wrong_log_does_not_shift_the_reference(factor: float) -> None:
    values = [("3", log.inertia, log.inertia_u) for log in drawn(1)[:8]]
    right = class_references(values)["3"]
    station, value, u = values[0]
    # A tiny uncertainty gives a log no more weight than the others have.
    for stated in (u, factor * u, 1e-3 * u):
        wrong = [(station, factor * value, stated), *values[1:]]
        assert abs(class_references(wrong)["3"].inertia - right.inertia) < right.u
