"""The rubric: what it means, and every fault in it told with its line and what to
write.
"""

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from msgspec.structs import astuple
from places import DATA

from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import InputError
from gyrodata.cli import schema
from gyrodata.grading.rubric import default_rubric_text, judge_lateness, read_rubric
from gyrodata.grading.stations import class_references
from gyrodata.grading.submissions import Submission

HEAD = 'schema = 1\npoints = 4\n[[criterion]]\nid = "izz"\ncheck = "own_data"\npoints = 4\n'
TABLE = tomllib.loads((DATA / "lateness.toml").read_text(encoding="utf-8"))
RULES: dict[str, str] = TABLE["rules"]
CHECKS = (
    "log",
    "procedure",
    "own_data",
    "reference",
    "uncertainty",
    "units",
    "constancy",
    "files",
    "manual",
)
STATION = "[reference.3]\ninertia = '4e-3 kg m^2'\nu = '1 %'\n"


def faults(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        read_rubric(text.encode("utf-8", "surrogateescape"), "mine.toml")
    return [str(diagnostic) for diagnostic in caught.value.diagnostics]


def unfit(text: str) -> list[str]:
    """What the schema has against a rubric; a time is a text, as editors of TOML take
    it.
    """
    values = json.loads(json.dumps(tomllib.loads(text), default=str))
    return [
        error.message
        for error in jsonschema.Draft202012Validator(
            schema.json_schema("rubric")
        ).iter_errors(values)
    ]


def test_parts_shown_commented_out_can_be_switched_on() -> None:
    head, late = default_rubric_text().split("# Being late.")
    on = re.sub(r"(?m)^# (?=[\[a-z])", "", late.split("\n", 1)[1])
    head = head.replace('[reference]\nfrom = "class"\n', "").replace(
        '[bench]\nfrom = "class"\n', "[bench]\n"
    )
    rubric = read_rubric(
        (re.sub(r"# (?=\[ref|inertia =|u = |u_)", "", head) + on).encode()
    )
    assert rubric.references["3"].inertia == pytest.approx(4.44e-3)
    assert set(rubric.bench) == {"u_time", "u_spin"}
    assert rubric.late is not None
    late = [
        Submission("a", "a", {}, Path(), late=True, late_seconds=86400.0 * days)
        for days in (1, 3)
    ]
    costs = [judge_lateness(rubric.late, one, 20.0).deduct for one in late]
    assert costs == pytest.approx([2.0, 6.0])


@pytest.mark.parametrize(
    "code", sorted(code for code in explanations() if code.startswith("G72"))
)
def test_example_of_each_code_raises_that_code_alone(code: str) -> None:
    (told,) = faults(explanations()[code].example)
    assert f"error {code}: " in told


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEAD + 'full = "__import__(\'os\')"\nzero = "d >= 1"\n', "is not a condition"),
        (
            HEAD.replace("own_data", "uncertainty")
            + 'full = "ratio outside 0.5..2"\nzero = "ratio in 0.2..8"\n',
            "gives all points to values that are far out",
        ),
        (HEAD.replace("= 4", "= nan"), "points = NaN cannot be used"),
        (HEAD.replace("izz", "total"), '"total" cannot be the id of a criterion'),
        (
            HEAD.replace("own_data", "reference"),
            "compares with a reference, but none is given",
        ),
        (
            HEAD + STATION.replace("4e-3 kg m^2", "4e-3"),
            'mine.toml:8:1: error G723: inertia ± u: "4e-3 ± 1 %" has no unit',
        ),
        (
            HEAD + STATION.replace("u = '1 %'", ""),
            'mine.toml:7:1: error G723: "u" is missing',
        ),
        (
            HEAD + RULES["LATE"].replace("15 min", "1 fortnight"),
            'grace = "1 fortnight" cannot be used',
        ),
        (HEAD + "[late]\ngrase = '1 h'\n", "did you mean grace?"),
        (
            HEAD + "grase = '1 h'\n",
            "\"grase\" is not known here\n   grase = '1 h'\n   ^^^^^  take it out",
        ),
        ("schema = 1\ntitle = '\udcff'\n", "mine.toml:2:1: error G721: is not UTF-8"),
    ],
)
def test_fault_in_a_rubric_is_told_with_its_place(text: str, told: str) -> None:
    assert any(told in one for one in faults(text)), faults(text)


def test_rubric_in_utf_16_as_powershell_writes_it_is_read() -> None:
    text = default_rubric_text("simple")
    assert read_rubric(text.encode("utf-16")) == read_rubric(text.encode())


def test_printed_rubrics_and_one_of_every_part_fit_the_schema() -> None:
    each = "".join(
        f'[[criterion]]\nid = "{check}"\ncheck = "{check}"\npoints = 1\n'
        for check in CHECKS
    )
    every = (
        f'schema = 1\npoints = {len(CHECKS)}\naccept = ["recommended"]\n'
        f"{each}{STATION}{RULES['MARKED']}"
    )
    assert read_rubric(every.encode()).late
    printed = [default_rubric_text(kind) for kind in ("simple", "full", "manual")]
    assert [unfit(text) for text in (*printed, every)] == [[]] * 4


@pytest.mark.parametrize("row", TABLE["rows"])
def test_lateness_follows_from_marks_counts_and_stamps(row: list[Any]) -> None:
    rule, student, late, seconds, submitted, *expected = (
        None if cell == "None" else cell for cell in row
    )
    read = read_rubric((HEAD + RULES[rule]).encode()).late if rule else None
    one = Submission(
        "",
        "",
        {"id": student},
        Path(),
        late=late,
        late_seconds=seconds,
        submitted=submitted,
    )
    assert astuple(judge_lateness(read, one, 4.0)) == pytest.approx(tuple(expected))


def test_station_with_few_logs_has_the_class_as_reference() -> None:
    values = (4.40e-3, 4.43e-3, 4.47e-3, 4.50e-3, 4.60e-3)
    logs = (
        [("a", value, 2e-5) for value in values]
        + [("b", 4.2e-3, 8e-5)] * 4
        + [(None, 4.44e-3, 5e-5)]
    )
    found = class_references(logs)
    # No value is farther than two standard deviations from the median, so that equal
    # u have equal weight; 1.4826 is the scatter of normal values over their median
    # absolute deviation.
    assert {key: one.source for key, one in found.items()} == {
        "a": "the mean of the 5 logs of station a",
        "all": "the mean of all 10 logs",
    }
    far = 2 * 1.4826 * 4e-5
    mean = sum(min(value, 4.47e-3 + far) for value in values) / 5
    assert found["a"].inertia == pytest.approx(mean)
    assert found["a"].u == pytest.approx(1.4826 * 4e-5 / math.sqrt(5))
    assert 4.2e-3 < found["all"].inertia < found["a"].inertia
    assert found["all"].u > found["a"].u
    assert class_references([(None, 4.4e-3, 5e-5)])["all"].source == "this log alone"
