"""The rubric: what it means, and every fault in it told with its line and what to write."""

from __future__ import annotations

import contextlib
import datetime as dt
import json
import math
import re
import tomllib
from typing import Literal

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import astuple

from gyrodata import schema
from gyrodata.diagnostics import CODES
from gyrodata.errors import InputError
from gyrodata.grading import (
    Rubric,
    class_references,
    default_rubric,
    default_rubric_text,
    judge_lateness,
    read_rubric,
)
from gyrodata.grading.rubric import make_curve, parse_condition
from gyrodata.reporting import duration_text
from gyrodata.toml_table import UnfitError, find_places

HEAD = 'schema = 1\npoints = 4\n[[criterion]]\nid = "izz"\ncheck = "own_data"\npoints = 4\n'
LATE = """
[late]
due = 2026-03-09T23:59:00+01:00
grace = "15 min"
beyond = "100 %"
[[late.tier]]
until = "1 day"
deduct = "10 %"
[[late.tier]]
until = "3 days"
deduct = 2
[[late.exception]]
student = "s001"
extra = "2 days"
[[late.exception]]
student = "Doe, Jane"
waive = true
[[late.exception]]
student = "s003"
due = 2026-03-16T23:59:00+01:00
"""
BARE = """
[late]
grace = "1 min"
marked = 1
beyond = 3
[[late.tier]]
until = "1 h"
deduct = 0.5
[[late.exception]]
student = "x"
extra = "1 h"
[[late.exception]]
student = "y"
due = 2026-03-16T23:59:00
[[late.exception]]
student = "z"
waive = true
"""
NAIVE = "[late]\ndue = 2026-03-09T23:59:00\n"


def faults(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        read_rubric(text.encode(), "mine.toml")
    return [str(diagnostic) for diagnostic in caught.value.diagnostics]


class TestDefault:
    def test_it_is_worth_twenty_points_and_says_so(self) -> None:
        rubric = default_rubric()
        assert rubric.points == 20 == sum(criterion.points for criterion in rubric.criteria)
        assert len({criterion.check for criterion in rubric.criteria}) == 7
        assert rubric.class_reference
        assert rubric.late is None

    def test_what_it_shows_commented_out_can_be_switched_on(self) -> None:
        head, late = default_rubric_text().split("# Being late.")
        on = re.sub(r"(?m)^# (?=[\[a-z])", "", late.split("\n", 1)[1])
        stations = head.replace('[reference]\nfrom = "class"\n', "").replace("# [ref", "[ref")
        stations = stations.replace("# inertia =", "inertia =").replace("# u = ", "u = ")
        stations = stations.replace('[bench]\nfrom = "class"\n', "[bench]\n").replace("# u_", "u_")
        rubric = read_rubric((stations + on).encode())
        assert rubric.references["3"].inertia == pytest.approx(4.44e-3)
        assert {key: text for key, (text, _) in rubric.bench.items()} == {"u_time": "0.3 s", "u_spin": "1 % + 0.5 rpm"}
        assert rubric.late is not None
        assert [tier.deduct for tier in rubric.late.tiers] == pytest.approx([2.0, 6.0])
        assert rubric.late.marked == pytest.approx(2.0)

    def test_leaving_everything_out_means_the_same(self) -> None:
        short = "schema = 1\npoints = 20\nreference.from = 'class'\nbench.from = 'class'\n" + "".join(
            f"[[criterion]]\nid = '{c.id}'\ncheck = '{c.check}'\npoints = {c.points}\n"
            + ("gate = ['1e-6 kg m^2', '100 kg m^2']\n" if c.gate else "")
            for c in default_rubric().criteria
        )
        assert read_rubric(short.encode()) == read_rubric(default_rubric_text().encode())


class TestDigest:
    def test_remarks_and_the_name_of_the_file_do_not_matter(self) -> None:
        text = default_rubric_text()
        bare = re.sub(r"(?m)\s*#.*$", "", text)
        assert read_rubric(bare.encode(), "other.toml").digest == default_rubric().digest

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ('full = "d <= 0.3"', 'full = "d <= 0.4"'),
            ('zero = "d >= 3"', 'zero = "d >= 3.1"'),
            ('no_report = "look"', 'no_report = "zero"'),
            ('slip = "50 %"', "slip = 2"),
            ('title = "Gyro', 'title = "The gyro'),
            ('[bench]\nfrom = "class"', '[bench]\nu_time = "0.3 s"'),
        ],
    )
    def test_what_changes_points_does(self, old: str, new: str) -> None:
        changed = default_rubric_text().replace(old, new)
        assert changed != default_rubric_text()
        assert read_rubric(changed.encode()).digest != default_rubric().digest


class TestFaults:
    @pytest.mark.parametrize("code", sorted(code for code in CODES if code.startswith("G72")))
    def test_the_example_of_each_code_raises_it_alone(self, code: str) -> None:
        (told,) = faults(CODES[code].example)
        assert f"error {code}: " in told

    def test_all_in_one_pass_in_the_order_of_the_file(self) -> None:
        text = (
            HEAD.replace("points = 4\n[", "points = 5\n[")
            + 'full = "d < 0.3"\nzero = "z >= 3"\ngate = ["1 kg", "2 kg"]\n'
            + '[[criterion]]\nid = "log"\nchek = "log"\npoints = 1\n[lat]\n'
        )
        assert "\n".join(faults(text)) == (
            'mine.toml:7:1: error G726: "d < 0.3" is no condition\n   full = "d < 0.3"\n   ^^^^  write "d <= 0.3"\n'
            'mine.toml:8:1: error G726: "z" means nothing in a criterion with check = "own_data"\n'
            '   zero = "z >= 3"\n'
            "   ^^^^  write a condition on d or percent\n"
            'mine.toml:9:1: error G723: gate: "kg" is no unit of a moment of inertia\n'
            '   gate = ["1 kg", "2 kg"]\n'
            '   ^^^^  write gate = ["1e-6 kg m^2", "100 kg m^2"]\n'
            'mine.toml:10:1: error G723: "check" is missing\n'
            "   [[criterion]]\n"
            '   ^^^^^^^^^^^^^  write check = "log" or "procedure" or "own_data" or "reference" or "uncertainty" or '
            '"units" or "constancy" or "files" or "manual"\n'
            'mine.toml:12:1: error G722: "chek" is not known in [criterion]\n'
            '   chek = "log"\n'
            "   ^^^^  did you mean check?\n"
            'mine.toml:14:1: error G722: "lat" is not known\n   [lat]\n   ^^^^^  did you mean late?'
        )

    @pytest.mark.parametrize(
        ("text", "told"),
        [
            ("schema = 1\npoints 3\n", "mine.toml:2:8: error G721: this is not TOML"),
            ("schema = 1\n[[criterion]\n", "mine.toml:2:"),
            ("schema = 2\npoints = 4" + HEAD[21:], "write schema = 1"),
            ("", '"schema" is missing'),
            (HEAD + HEAD[21:], "two criteria have the id"),
            (HEAD + 'full = "d <= 3"\nzero = "d >= 1"\n', "mine.toml:8:1: error G726: full and zero overlap"),
            (HEAD + 'full = "d <= 3"\nzero = "d <= 1"\n', 'write zero = "d >= NUMBER"'),
            (HEAD + 'full = "__import__(\'os\')"\nzero = "d >= 1"\n', "is no condition"),
            (HEAD + 'full = "d <= 1 and d <= 2"\nzero = "d >= 3"\n', "is no condition"),
            (HEAD + 'slip = "150 %"\n', 'write at most slip = "100 %"'),
            (HEAD + "slip = true\n", "slip = true cannot be used"),
            (HEAD + 'slip = "half"\n', 'write slip = "10 %" or 2'),
            (HEAD + 'asks = ["weights"]\n', '"asks" is not known in [criterion]'),
            (HEAD.replace("= 4", "= nan"), "points = NaN cannot be used"),
            (HEAD.replace("= 4", "= -4"), "points = -4 cannot be used"),
            (HEAD.replace("= 4", "= " + "9" * 400), "points = 999"),
            (HEAD.replace("= 4", "= " + "9" * 5000), "this is not TOML"),
            (HEAD + f"slip = {'9' * 400}\n", "slip = 999"),
            ('accept = ["orign"]\n' + HEAD, 'accept = "orign" cannot be used'),
            ("accept = []\n" + HEAD, "accept = [] cannot be used"),
            (HEAD.replace("own_data", "reference"), "compares with a reference, and none is given"),
            (HEAD + "[reference]\n", "both the class and stated values, or neither"),
            (HEAD + "[reference]\ninertia = '4e-3 kg m^2'\n", "head the values of station 3 with [reference.3]"),
            (
                HEAD + "[reference.3]\ninertia = '4e-3'\nu = '1 %'\n",
                'mine.toml:8:1: error G723: inertia: "4e-3" has no unit',
            ),
            (HEAD + "[reference.3]\ninertia = '4e-3 kg m^2'\n", 'mine.toml:7:1: error G723: "u" is missing'),
            (HEAD + "[late]\ngrace = '15'\n", 'grace = "15" is no duration'),
            (HEAD + "[late]\ndue = '2026-03-09'\n", "write due = 2026-03-09T23:59:00+01:00"),
            (HEAD + "[[late.tier]]\nuntil = '1 day'\n", 'mine.toml:7:1: error G723: "deduct" is missing'),
            (
                HEAD + "".join(f"[[late.tier]]\nuntil = '{n} days'\ndeduct = 1\n" for n in (2, 1)),
                "a tier is not later than the one before it",
            ),
            (HEAD + "[[late.exception]]\nstudent = 's1'\n", "exactly one of due, extra and waive"),
            (HEAD + "[[late.exception]]\nstudent = 7\nwaive = true\n", "student = 7 cannot be used"),
            ("schema = 1\npoints = 4\ncriterion = 3\n", "write a table, headed [[criterion]]"),
            ("schema = 1\npoints = 4\ncriterion = [3]\n", "criterion = [3] cannot be used"),
            ("schema = 1\npoints = 4\n", '"criterion" is missing'),
        ],
    )
    def test_each_says_where_and_what_to_write(self, text: str, told: str) -> None:
        assert any(told in one for one in faults(text)), faults(text)

    def test_bytes_that_are_no_text(self) -> None:
        with pytest.raises(InputError, match=r"mine\.toml:2:1: error G721: is not UTF-8"):
            read_rubric(b"schema = 1\ntitle = '\xff'\n", "mine.toml")

    def test_line_ends_and_a_mark_of_byte_order_do_not_matter(self) -> None:
        text = default_rubric_text()
        assert read_rubric(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode()) == read_rubric(text.encode())

    @given(st.text(max_size=80))
    def test_no_text_is_a_traceback(self, text: str) -> None:
        with contextlib.suppress(InputError):
            read_rubric((HEAD + text).encode("utf-8", "surrogatepass"))

    @given(st.sampled_from(default_rubric_text().splitlines()), st.text(max_size=12), st.integers(0, 80))
    def test_no_slip_of_the_pen_is_a_traceback(self, line: str, more: str, at: int) -> None:
        text = default_rubric_text().replace(line, line[:at] + more + line[at:], 1)
        with contextlib.suppress(InputError):
            read_rubric(text.encode("utf-8", "surrogatepass"))


CHECKS = ("log", "procedure", "own_data", "reference", "uncertainty", "units", "constancy", "files", "manual")
STATION = "[reference.3]\ninertia = '4e-3 kg m^2'\nu = '1 %'\n"


def unfit(text: str) -> list[str]:
    """What the schema has against a rubric; a time is a text, as editors of TOML take it."""
    values = json.loads(json.dumps(tomllib.loads(text), default=str))
    return [error.message for error in jsonschema.Draft202012Validator(schema.rubric_schema()).iter_errors(values)]


class TestSchema:
    @pytest.mark.parametrize("kind", ["simple", "full", "manual"])
    def test_the_rubrics_to_begin_with_fit(self, kind: Literal["simple", "full", "manual"]) -> None:
        assert unfit(default_rubric_text(kind)) == []

    def test_every_part_and_every_kind_of_criterion_fits(self) -> None:
        each = "".join(f'[[criterion]]\nid = "{check}"\ncheck = "{check}"\npoints = 1\n' for check in CHECKS)
        late = LATE.replace("[late]", "[late]\nmarked = 0.5")
        text = f'schema = 1\npoints = {len(CHECKS)}\naccept = ["recommended"]\n{each}{STATION}{late}'
        assert read_rubric(text.encode()).late
        assert unfit(text) == []

    @pytest.mark.parametrize(
        "text",
        [
            # keys that are not known
            "titel = 'x'\n" + HEAD, HEAD + "ponits = 4\n", HEAD + "asks = ['weights']\n", HEAD + "[lat]\n",
            HEAD + "[late]\nduo = 1\n", HEAD + LATE + "more = 1\n", HEAD + STATION + "v = 1\n",
            HEAD.replace("own_data", "manual") + "full = 'd <= 1'\nzero = 'd >= 2'\n",
            # values of another type
            HEAD.replace("points = 4", "points = '4'"), HEAD.replace("points = 4", "points = true"),
            HEAD.replace("points = 4", "points = -4"), HEAD.replace('"izz"', "3"), "title = ''\n" + HEAD,
            "accept = 'recommended'\n" + HEAD, "schema = 1\npoints = 4\ncriterion = 3\n",
            "schema = 1\npoints = 4\ncriterion = [3]\n", "late = 3\n" + HEAD, HEAD + "slip = true\n",
            HEAD + "slip = 'half'\n", HEAD + "gate = '1 kg m^2'\n", HEAD + "gate = ['1 kg m^2']\n",
            HEAD + "gate = [1, 2]\n", HEAD + "[late]\ndue = '2026-03-09'\n", HEAD + "[late]\ngrace = 15\n",
            HEAD + "[[late.exception]]\nstudent = 7\nwaive = true\n",
            HEAD + "[[late.exception]]\nstudent = 's'\nwaive = 1\n", HEAD + "[reference]\n3 = '4e-3 kg m^2'\n",
            HEAD + STATION.replace("'1 %'", "0.01"),
            # words out of their list
            HEAD.replace("own_data", "own-data"), "accept = ['orign']\n" + HEAD, "accept = []\n" + HEAD,
            "no_report = 'maybe'\n" + HEAD, HEAD.replace("own_data", "procedure") + "asks = ['wieghts']\n",
            HEAD + "[reference]\nfrom = 'clas'\n", HEAD.replace("schema = 1", "schema = 2"),
            # conditions
            HEAD + "full = 'd < 0.3'\nzero = 'd >= 3'\n", HEAD + "full = 'z <= 1'\nzero = 'z >= 3'\n",
            # what is missing
            HEAD.replace("schema = 1\n", ""), HEAD.replace('id = "izz"\n', ""), HEAD.replace("check", "# check"),
            HEAD + "[[late.tier]]\nuntil = '1 day'\n", HEAD + STATION.replace("u = '1 %'\n", ""),
        ],
    )  # fmt: skip
    def test_what_the_reader_refuses_for_its_shape_does_not_fit(self, text: str) -> None:
        assert faults(text)
        assert unfit(text)


class TestPlaces:
    def test_keys_and_tables_are_found_past_texts_of_several_lines(self) -> None:
        text = (
            'a = """\nb = 1\n"""\nc = [ # [x]\n  1,\n  "]",\n]\n[t."x y"] # remark\n  d.e = \'"""\'\n'
            "[[u]]\nf = 1\n[[u]]\nf = 2\n[u.v]\nw = 3\n"
        )
        places = {path: spot.line for path, spot in find_places(text).items()}
        assert places == {
            ("a",): 1,
            ("c",): 4,
            ("t", "x y"): 8,
            ("t", "x y", "d"): 9,
            ("t", "x y", "d", "e"): 9,
            ("u", 0): 10,
            ("u", 0, "f"): 11,
            ("u", 1): 12,
            ("u", 1, "f"): 13,
            ("u", 1, "v"): 14,
            ("u", 1, "v", "w"): 15,
        }


class TestConditions:
    @pytest.mark.parametrize(
        ("full", "zero", "points"),
        [
            ("d <= 0.3", "d >= 3", {0: 1, 0.3: 1, 1.65: 0.5, 3: 0, 1e300: 0}),
            ("p >= 0.01", "p <= 0", {1: 1, 0.01: 1, 0.005: 0.5, 0: 0}),
            ("r in 0.5..2", "r outside 0.2..5", {0.5: 1, 2: 1, 0.35: 0.5, 3.5: 0.5, 0.2: 0, 5: 0, 0: 0}),
            ("n <= 1", "n >= 1", {1: 1, 1.001: 0}),
        ],
    )
    def test_points_fall_in_a_straight_line(self, full: str, zero: str, points: dict[float, float]) -> None:
        curve = make_curve(parse_condition(full), parse_condition(zero))
        assert {value: curve.share(value) for value in points} == pytest.approx(points)

    @given(st.floats(0, 10), st.floats(0, 10), st.lists(st.floats(0, 20), min_size=2, max_size=2))
    def test_more_distance_never_earns_more(self, full: float, zero: float, d: list[float]) -> None:
        full, zero = sorted((full, zero))
        curve = make_curve(parse_condition(f"d <= {full:f}"), parse_condition(f"d >= {zero:f}"))
        near, far = sorted(d)
        assert 0 <= curve.share(far) <= curve.share(near) <= 1

    def test_not_a_number_earns_nothing(self) -> None:
        assert make_curve(parse_condition("d <= 1"), parse_condition("d >= 2")).share(float("nan")) == 0

    @pytest.mark.parametrize("text", ["", "d", "d <= x", "<= 3", "d in 3..2", "d <= 1e999999x", "lambda: 0", "d<=1;x"])
    def test_anything_else_is_refused(self, text: str) -> None:
        with pytest.raises(UnfitError) as caught:
            parse_condition(text)
        assert caught.value.hint


class TestLate:
    @pytest.fixture
    def rubric(self) -> Rubric:
        return read_rubric((HEAD + LATE).encode())

    @pytest.mark.parametrize(
        ("student", "submitted", "deduct", "reason"),
        [
            ("s009", "2026-03-09T22:00:00+01:00", 0.0, ""),
            ("s009", "2026-03-09T22:59:00+00:00", 0.0, ""),
            ("s009", "2026-03-10T00:14:00+01:00", 0.0, "15 min after the deadline, within the grace time"),
            ("s009", "2026-03-10T00:14:01+01:00", 0.4, "15 min late"),
            ("s009", "2026-03-10T23:59:00+01:00", 0.4, "1 day late"),
            ("s009", "2026-03-11T03:00:00+01:00", 2.0, "1 day 3 h late"),
            ("s009", "2026-03-20T00:00:00+01:00", 4.0, "10 days late"),
            ("s001", "2026-03-11T23:59:00+01:00", 0.0, ""),
            ("S001", "2026-03-12T23:59:00+01:00", 0.4, "1 day late"),
            ("s003", "2026-03-17T01:59:00+01:00", 0.4, "2 h late"),
            ("Doe, Jane", "2026-05-01T00:00:00+01:00", 0.0, ""),
            ("s009", "2026-03-10T01:59:00", 0.4, "2 h late"),
        ],
    )
    def test_tiers_grace_and_exceptions(
        self, rubric: Rubric, student: str, submitted: str, deduct: float, reason: str
    ) -> None:
        late = judge_lateness(rubric.late, {"id": student}, False, None, submitted)
        assert (late.deduct, late.reason, late.look) == (pytest.approx(deduct), reason, False)

    def test_the_platform_s_own_count_holds_where_no_stamp_is_known(self, rubric: Rubric) -> None:
        assert judge_lateness(rubric.late, {}, True, 7200.0, None).deduct == pytest.approx(0.4)
        assert judge_lateness(rubric.late, {"id": "s001"}, True, 7200.0, None).deduct == 0

    def test_a_bare_mark_is_no_deduction_by_accident(self, rubric: Rubric) -> None:
        late = judge_lateness(rubric.late, {}, True, None, None)
        assert (late.seconds, late.deduct, late.look) == (None, 0.0, True)
        told = read_rubric((HEAD + LATE.replace("beyond", "marked = 1\nbeyond")).encode())
        assert judge_lateness(told.late, {}, True, None, None).deduct == 1.0
        assert judge_lateness(told.late, {"id": "s001"}, True, None, None).look

    def test_nothing_is_taken_off_without_a_rule(self) -> None:
        assert judge_lateness(None, {}, True, 1e6, None).deduct == 0

    def test_a_stamp_that_cannot_be_read_is_none(self, rubric: Rubric) -> None:
        assert judge_lateness(rubric.late, {}, False, None, "yesterday").deduct == 0

    @pytest.mark.parametrize(
        ("rule", "student", "late", "seconds", "submitted", "expected"),
        [
            (None, "a", False, None, None, (None, 0, "", False)),
            (None, "a", True, None, None, (None, 0, "marked late", False)),
            (None, "a", True, 90.0, None, (90.0, 0, "1 min late", False)),
            (None, "a", False, 0.0, None, (0.0, 0, "", False)),
            (None, "a", True, 0.0, None, (0.0, 0, "marked late", False)),
            (LATE, "a", True, None, None, (None, 0, "marked late, but nothing says by how much", True)),
            (LATE, "a", False, None, None, (0.0, 0, "", False)),
            (LATE, "a", True, 900.0, None, (900.0, 0, "15 min after the deadline, within the grace time", False)),
            (LATE, "a", True, 901.0, None, (901.0, 0.4, "15 min late", False)),
            (LATE, "a", True, 86400.0, None, (86400.0, 0.4, "1 day late", False)),
            (LATE, "a", True, 86401.0, None, (86401.0, 2, "1 day late", False)),
            (LATE, "a", True, 259200.0, None, (259200.0, 2, "3 days late", False)),
            (LATE, "a", True, 259201.0, None, (259201.0, 4, "3 days late", False)),
            (LATE, "a", True, 7200.0, "2026-03-10T00:14:00+01:00",
             (900.0, 0, "15 min after the deadline, within the grace time", False)),
            (LATE, "a", False, None, "2026-03-09T23:59:00+01:00", (0.0, 0, "", False)),
            (LATE, "a", False, None, "2026-03-09T23:59:01+01:00",
             (1.0, 0, "1 s after the deadline, within the grace time", False)),
            (LATE, "s001", True, 172800.0, None, (0.0, 0, "", False)),
            (LATE, "s001", True, None, None, (None, 0, "marked late, but nothing says by how much", True)),
            (LATE, "s001", False, None, None, (0.0, 0, "", False)),
            (LATE, "s003", True, 7200.0, None, (None, 0, "marked late, but nothing says by how much", True)),
            (LATE, "s003", False, 7200.0, None, (7200.0, 0.4, "2 h late", False)),
            (LATE, "s003", False, None, "2026-03-16T23:59:30+01:00",
             (30.0, 0, "30 s after the deadline, within the grace time", False)),
            (LATE, "doe, jane", True, None, None, (None, 0, "lateness waived for you", False)),
            (LATE, "doe, jane", False, None, None, (None, 0, "", False)),
            (LATE, "doe, jane", False, 60.0, None, (60.0, 0, "lateness waived for you", False)),
            (BARE, "a", True, None, None, (None, 1, "marked late, without the time", False)),
            (BARE, "x", True, None, None, (None, 0, "marked late, but nothing says by how much", True)),
            (BARE, "y", True, None, None, (None, 0, "marked late, but nothing says by how much", True)),
            (BARE, "y", True, 30.0, None, (None, 0, "marked late, but nothing says by how much", True)),
            (BARE, "y", False, 30.0, None, (30.0, 0, "30 s after the deadline, within the grace time", False)),
            (BARE, "y", True, 300.0, "2026-03-17T00:29:00", (1800.0, 0.5, "30 min late", False)),
            (BARE, "y", False, None, "2026-03-17T00:29:00+05:00", (1800.0, 0.5, "30 min late", False)),
            (BARE, "x", True, 3660.0, None, (60.0, 0, "1 min after the deadline, within the grace time", False)),
            (BARE, "x", True, 3661.0, None, (61.0, 0.5, "1 min late", False)),
            (BARE, "x", True, -60.0, None, (0.0, 0, "", False)),
            (BARE, "z", True, 7.0, None, (7.0, 0, "lateness waived for you", False)),
            (BARE, "a", True, 3600.0, None, (3600.0, 0.5, "1 h late", False)),
            (BARE, "a", True, 3601.0, None, (3601.0, 3, "1 h late", False)),
            (BARE, "a", False, None, "2026-03-17", (0.0, 0, "", False)),
            (NAIVE, "a", False, None, "2026-03-10T00:59:00-05:00", (3600.0, 4, "1 h late", False)),
            (NAIVE, "a", False, None, "2026-03-10T00:59:00", (3600.0, 4, "1 h late", False)),
            (NAIVE, "a", False, None, "2026-03-09T23:59:00", (0.0, 0, "", False)),
        ],
    )  # fmt: skip
    def test_what_is_made_of_marks_counts_and_stamps(
        self, rule: str | None, student: str, late: bool, seconds: float | None, submitted: str | None,
        expected: tuple[float | None, float, str, bool],
    ) -> None:  # fmt: skip
        read = None if rule is None else read_rubric((HEAD + rule).encode()).late
        assert astuple(judge_lateness(read, {"id": student}, late, seconds, submitted)) == pytest.approx(expected)

    def test_what_a_rule_leaves_out(self) -> None:
        rule = read_rubric(
            (HEAD + "[late]\nmarked = 4\n[[late.exception]]\nstudent = 's'\nextra = '1 s'\n").encode()
        ).late
        assert rule is not None
        assert (rule.due, rule.grace, rule.tiers, rule.beyond, rule.marked) == (None, 0, (), 4, 4)
        assert [astuple(one) for one in rule.exceptions] == [("s", None, 1, False)]

    @pytest.mark.parametrize(
        ("rule", "told"),
        [
            ("marked = 4.01", "marked = 4.01 is no share of 4 points"),
            ("marked = '101 %'", "marked = 101 % is no share of 4 points"),
            ("marked = 'some'", 'marked = "some" cannot be used'),
            (
                "[[late.tier]]\nuntil = '1 h'\ndeduct = 1\n[[late.tier]]\nuntil = '60 min'\ndeduct = 2",
                "a tier is not later",
            ),
            ("[[late.exception]]\nstudent = 's'\nextra = '1 h'\nwaive = true", "exactly one of due, extra and waive"),
            ("[[late.exception]]\nstudent = 's'\nwaive = false", "exactly one of due, extra and waive"),
        ],
    )
    def test_a_rule_that_is_refused(self, rule: str, told: str) -> None:
        (fault,) = faults(HEAD + f"[late]\n{rule}\n")
        assert told in fault

    def test_summer_time_at_the_deadline(self) -> None:
        # 2026-03-29 02:00 became 03:00 in Berlin; stamps carry their own offset.
        text = HEAD + "[late]\ndue = 2026-03-29T01:59:00+01:00\n[[late.tier]]\nuntil = '1 h'\ndeduct = 1\n"
        late = judge_lateness(read_rubric(text.encode()).late, {}, False, None, "2026-03-29T03:01:00+02:00")
        assert late.seconds == 120

    @pytest.mark.parametrize(
        ("text", "seconds"),
        [
            ("90 s", 90),
            ("15min", 900),
            ("1.5 h", 5400),
            ("2 sec", 2),
            ("3 minutes", 180),
            ("2 H", 7200),
            ("2 days", 172800),
            ("36 hours", 129600),
            ("1 week", 604800),
        ],
    )
    def test_durations(self, text: str, seconds: float) -> None:
        late = read_rubric((HEAD + LATE.replace('grace = "15 min"', f'grace = "{text}"')).encode()).late
        assert late is not None
        assert late.grace == seconds

    def test_what_is_no_duration(self) -> None:
        with pytest.raises(InputError, match='grace = "1 fortnight" is no duration'):
            read_rubric((HEAD + LATE.replace('grace = "15 min"', 'grace = "1 fortnight"')).encode())

    def test_durations_in_words(self) -> None:
        assert [duration_text(s) for s in (5, 60, 3600, 90061, 172800)] == [
            "5 s",
            "1 min",
            "1 h",
            "1 day 1 h",
            "2 days",
        ]

    def test_the_deadline_is_a_time_with_its_zone(self, rubric: Rubric) -> None:
        assert rubric.late is not None
        assert rubric.late.due == dt.datetime(2026, 3, 9, 22, 59, tzinfo=dt.UTC)


class TestClassReference:
    def test_one_wild_log_moves_it_by_little(self) -> None:
        logs = [("3", 4.44e-3 + 1e-5 * k, 5e-5) for k in range(-5, 6)]
        plain, wild = class_references(logs)["3"], class_references([*logs[:-1], ("3", 4.4, 1e-3)])["3"]
        assert plain.inertia == pytest.approx(4.44e-3, rel=1e-12)
        assert wild.inertia == pytest.approx(plain.inertia, rel=0.005)

    def test_order_does_not_matter(self) -> None:
        logs = [(str(k % 3), 4.4e-3 + 7e-6 * (k * 37 % 11), 5e-5) for k in range(30)]
        assert class_references(logs) == class_references(reversed(logs))

    def test_few_logs_of_a_station_are_held_against_the_whole_class(self) -> None:
        logs = [("1", 4.4e-3, 5e-5)] * 6 + [("2", 4.5e-3, 5e-5)] * 4
        references = class_references(logs)
        assert set(references) == {"1", "all"}
        assert references["all"].source == "the median of all 10 logs"
        assert references["all"].u > 0
        assert class_references([]) == {}
        assert class_references([(None, 4.4e-3, 5e-5)])["all"].source == "this log alone"

    def test_the_numbers_of_few_and_many_logs(self) -> None:
        values = (4.40e-3, 4.43e-3, 4.47e-3, 4.50e-3, 4.60e-3)
        logs = [("a", value, 2e-5) for value in values] + [("b", 4.2e-3, 8e-5)] * 4 + [(None, 4.44e-3, 5e-5)]
        found = class_references(logs)
        # 1.4826 is the scatter of normal values over their median absolute deviation, 1.2533 as their median is worse.
        assert {key: (one.source, one.inertia) for key, one in found.items()} == {
            "a": ("the median of the 5 logs of station a", 4.47e-3),
            "all": ("the median of all 10 logs", pytest.approx(4.415e-3)),
        }
        assert found["a"].u == pytest.approx(1.2533 * 1.4826 * 4e-5 / math.sqrt(5), rel=1e-4)
        assert found["all"].u == pytest.approx(1.4826 * 0.135e-3, rel=1e-4)
        assert found["a"].words == "(4.470 ± 0.033) × 10⁻³ kg·m² (the median of the 5 logs of station a)"
        same = class_references([("a", 4.4e-3, 1e-4)] * 9)
        assert {key: one.u for key, one in same.items()} == pytest.approx({"a": 1e-4 / 3, "all": 1e-4 / 3})
