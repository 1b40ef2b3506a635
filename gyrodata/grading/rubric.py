"""Read the rubric: the criteria with their points, the deductions for being late, and the reference for I_zz.

A rubric is a TOML file. The file ``rubric.toml`` in this folder is used if no other is given; it explains every key.
"""

from __future__ import annotations

import datetime as dt
import difflib
import hashlib
import json
import math
import re
from collections.abc import Mapping
from functools import cached_property
from importlib.resources import files
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import msgspec
from msgspec import Meta, Struct, field, to_builtins
from msgspec.structs import asdict, force_setattr

from gyrodata import diagnostics
from gyrodata.errors import Diagnostic
from gyrodata.grading.criteria import ASKS, KINDS, MEANINGS
from gyrodata.grading.late import Deduction, LateRule, points_of
from gyrodata.grading.yardsticks import APPARATUS, BENCH, FIT_WORDS, Reference, Station, read_bench, station_key
from gyrodata.toml_table import Number, Path, Text, TomlFile, UnfitError

if TYPE_CHECKING:
    from gyrodata.grading.submissions import Submissions

ACCEPTED = tuple(FIT_WORDS)
"""Fits of a student's own runs that a rubric may accept."""


# --- conditions, "d <= 0.3" or "ratio in 0.5..2", and the points between two of them ------------------------

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
CONDITION = (
    rf"^\s*(?P<name>{'|'.join(MEANINGS)})\s*"
    rf"(?:(?P<sign><=|>=|≤|≥)\s*(?P<bound>{_NUMBER})|(?P<word>in|outside)\s+(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER}))\s*$"
)
_OPPOSITE = {"<=": ">= NUMBER", ">=": "<= NUMBER", "in": "outside LOW..HIGH"}


class Curve(NamedTuple):
    """Share of the points as a function of a variable: 1 in `full`, 0 outside `zero`, linear in between."""

    variable: str
    full: tuple[float, float]  # lower and upper end of the values with all points; infinite if there is none
    zero: tuple[float, float]  # ends of the values with some points

    def share(self, value: float) -> float:
        """Return the share of the points for a value."""
        (low, high), (least, most) = self.full, self.zero
        if low <= value <= high:
            return 1.0
        near, far = (low, least) if value < low else (high, most)
        # The value may be "not a number", and the two ends may be equal.
        return max(0.0, (far - value) / (far - near)) if least < value < most else 0.0


def _unfit(message: str, hint: str, key: str, code: str = diagnostics.CONDITION_CANNOT_BE_USED) -> UnfitError:
    return UnfitError(message, hint, code, key)


def parse_condition(text: str, key: str) -> tuple[str, str, float, float]:
    """Read a condition; return its variable, "<=", ">=", "in" or "outside", and the ends, infinite if there is none."""
    match = re.fullmatch(CONDITION, text)
    if match is None:
        hint = 'write it like "d <= 0.6", "z >= 5" (not < or >), "ratio in 0.5..2" or "ratio outside 0.2..5"'
        raise _unfit(f'"{text[:60]}" is not a condition', hint, key)
    name, relation = match["name"], match["word"] or match["sign"].replace("≤", "<=").replace("≥", ">=")
    low, high = float(match["low"] or match["bound"]), float(match["high"] or match["bound"])
    if match["word"] and not low < high:
        hint = f'write "{name} {relation} {match["high"]}..{match["low"]}"'
        raise _unfit(f'"{text}": {match["low"]} is not below {match["high"]}', hint, key)
    return name, relation, -math.inf if relation == "<=" else low, math.inf if relation == ">=" else high


RESERVED = (
    "student", "name", "status", "total", "late_deduction", "late", "matched", "d", "z", "slips", "flags", "look",
    "by_hand", "why_not_graded", "section", "reported", "station", "partner", "flag", "comment", "hold",
    "excuse", "bonus",
)  # fmt: skip
"""Ids that a criterion cannot have: columns of ``grades.csv``, and words of ``desk.csv``."""


# --- the file -----------------------------------------------------------------------------------------------

_PATTERN = {"pattern": re.sub(r"\?P<\w+>", "", CONDITION), "description": str(MEANINGS)}
ConditionText = Annotated[str, Meta(examples=["d <= 0.6"], extra_json_schema=_PATTERN)]


class Criterion(Struct, frozen=True, dict=True, forbid_unknown_fields=True):
    """One criterion, as the rubric states it; keys that are not given have the defaults of `KINDS`."""

    id: Text  # unique; the column of the grades
    check: Literal[*KINDS]  # type: ignore[valid-type]
    points: Number
    title: Text = ""
    full: ConditionText = ""
    zero: ConditionText = ""
    slip: Deduction | None = None  # deduction for a common mistake
    asks: Annotated[tuple[Literal[*ASKS], ...], Meta(min_length=1)] = ()  # type: ignore[valid-type]

    def __post_init__(self) -> None:
        kind = KINDS[self.check]
        for key in ("full", "zero", "slip", "asks"):
            if getattr(self, key) and key not in kind.keys:
                message = f'"{key}" is not known in a criterion with check = "{self.check}"'
                raise _unfit(message, "delete this line", key, diagnostics.RUBRIC_KEY_UNKNOWN)
        defaults = {"title": kind.title, "full": kind.full, "zero": kind.zero, "slip": "50 %", "asks": tuple(ASKS)[:3]}
        for key, value in defaults.items():
            if getattr(self, key) in (None, "", ()) and key in ("title", *kind.keys):
                force_setattr(self, key, value)
        if self.curve.variable == "stated" and self.title == kind.title:
            force_setattr(self, "title", "An uncertainty is stated")
        points_of(self.slip or 0.0, self.points, ("slip",))

    @cached_property
    def curve(self) -> Curve:
        """Share of the points as a function of a variable."""
        if self.check == "manual":
            return Curve("", (0.0, 0.0), (0.0, 0.0))
        full, zero = (parse_condition(getattr(self, key), key) for key in ("full", "zero"))
        (name, relation, low, high), kind = full, KINDS[self.check]
        known = (kind.full.split()[0], *kind.variables)
        for key, variable in (("full", name), ("zero", zero[0])):
            if variable not in known:
                message = f'"{variable}" cannot be used in a criterion with check = "{self.check}"'
                raise _unfit(message, f"write a condition for {' or '.join(known)}", key)
        opposite = _OPPOSITE.get(relation)
        if opposite is None:
            raise _unfit('full contains "outside"', f'write full = "{name} in LOW..HIGH"', "full")
        if zero[:2] != (name, opposite.split()[0]):
            message = f'zero = "{self.zero}" does not fit full = "{self.full}"'
            raise _unfit(message, f'write zero = "{name} {opposite}", farther out', "zero")
        # "zero" says from which value on there are no points; the other end is infinite.
        ends = {"<=": (-math.inf, zero[2]), ">=": (zero[3], math.inf), "in": zero[2:]}[relation]
        if ends[0] > low or ends[1] < high:
            hint = "put the limit of zero farther out than the limit of full"
            raise _unfit("full and zero overlap: some values would earn all points and no points", hint, "zero")
        return Curve(name, (low, high), ends)

    @property
    def told(self) -> str:
        """The two conditions in words, for students."""
        name = self.curve.variable
        text = f"all points for {self.full}, none for {self.zero}; {name}: {MEANINGS.get(name, '')}"
        return text.replace("<=", "≤").replace(">=", "≥").replace("..", " to ")


class _Table(Struct, frozen=True, dict=True, forbid_unknown_fields=True):
    """The keys of the file."""

    schema: Literal[1]
    points: Number
    criteria: tuple[Criterion, ...] = field(name="criterion")
    title: Text = "Gyroscope lab"
    accept: Annotated[tuple[Literal[ACCEPTED], ...], Meta(min_length=1)] = ACCEPTED  # type: ignore[valid-type]
    no_report: Literal["look", "zero"] = "look"
    late: LateRule | None = None
    reference: Mapping[str, Station | str] | None = None
    bench: Annotated[Mapping[str, str], Meta(extra_json_schema={"propertyNames": {"enum": ["from", *BENCH]}})] = {}

    def __post_init__(self) -> None:
        each = [one.points for one in self.criteria]
        if each and abs(math.fsum(each) - self.points) > 1e-9:
            parts, total = " + ".join(f"{one:g}" for one in each), math.fsum(each)
            message = f"points = {self.points:g}, but the criteria add up to {parts} = {total:g}"
            hint = f"write points = {total:g}, or change the points of a criterion"
            raise UnfitError(message, hint, diagnostics.RUBRIC_POINTS_DO_NOT_ADD_UP, "points")
        ids = [one.id for one in self.criteria]
        for at, one in enumerate(self.criteria):
            if one.id in ids[:at]:
                message = f'two criteria have the id "{one.id}"'
                raise UnfitError(message, "give each criterion its own id", path=("criterion", at, "id"))
            if one.id.casefold() in RESERVED:
                message = f'"{one.id}" cannot be the id of a criterion: grades.csv or desk.csv uses this word'
                raise UnfitError(message, f'write another id, such as "{one.id}_points"', path=("criterion", at, "id"))
            if one.check == "reference" and self.reference is None:
                message = f'criterion "{one.id}" compares with a reference, but none is given'
                hint = 'add [reference] with from = "class", or [reference.3] with inertia and u'
                raise UnfitError(message, hint, diagnostics.RUBRIC_PARTS_CONTRADICT, ("criterion", at))
        late = self.late or LateRule()
        deductions: dict[Path, str | float] = {("late", "beyond"): late.beyond, ("late", "marked"): late.marked or 0.0}
        deductions |= {("late", "tier", at, "deduct"): tier.deduct for at, tier in enumerate(late.tiers)}
        for path, value in deductions.items():
            points_of(value, self.points, path)
        read_bench(self.bench)
        for head, stated in (("reference", self.references), ("bench", set(self.bench) - {"from", *APPARATUS})):
            lines = getattr(self, head) or {}
            if lines.get("from", "class") != "class":
                message = f'from = "{lines["from"]}" cannot be used'
                raise UnfitError(message, 'write from = "class"', path=(head, "from"))
            if lines.get("from") and stated:
                message = f"[{head}] has values from the class and values that are stated here"
                hint = 'either write from = "class", or state values and leave that out'
                raise UnfitError(message, hint, diagnostics.RUBRIC_PARTS_CONTRADICT, (head, "from"))

    @cached_property
    def references(self) -> Mapping[str, Reference]:
        """References that the rubric states, by station; "all" is for all other stations."""
        stated = {name: one for name, one in (self.reference or {}).items() if isinstance(one, Station)}
        words = {name: f"the rubric{'' if name == 'all' else f', station {name}'}" for name in stated}
        return {station_key(name): one.reference(words[name]) for name, one in stated.items()}


class Rubric(_Table, frozen=True, dict=True):
    """Everything that decides about points."""

    name: str = ""

    @property
    def class_reference(self) -> bool:
        """True if the reference is taken from the class."""
        return "from" in (self.reference or {})

    def _hash(self, *left_out: str) -> str:
        content = to_builtins(self, builtin_types=(dt.datetime,))
        content = {key: value for key, value in content.items() if key not in left_out}
        return hashlib.sha256(json.dumps(content, sort_keys=True, default=dt.datetime.isoformat).encode()).hexdigest()

    @cached_property
    def digest(self) -> str:
        """Hash of everything that can change a grade, so not of remarks and spaces in the file."""
        return self._hash("name")

    @cached_property
    def judged(self) -> str:
        """Digest without the references, which are used only when the whole class is graded."""
        return self._hash("name", "reference")


BUILT_IN = ("simple", "full", "manual")


def default_rubric_text(kind: str = "full") -> str:
    """Return the text of a rubric of `BUILT_IN`, with its remarks; "full" is used by default."""
    name = "rubric.toml" if kind == "full" else f"rubric-{kind}.toml"
    return files("gyrodata.grading").joinpath(name).read_text("utf-8")


def default_rubric() -> Rubric:
    """Return the built-in rubric."""
    return read_rubric(default_rubric_text().encode(), "built-in rubric")


def read_rubric(data: bytes, name: str = "rubric.toml") -> Rubric:
    """Read a rubric; raise InputError with its first mistake."""
    hint = "a line is KEY = VALUE, with texts in quotation marks, or a head, [NAME] or [[criterion]]; no key twice"
    file = TomlFile(data, name, diagnostics.RUBRIC_NO_TOML, hint)
    written = file.values.get("reference")
    for station in written if isinstance(written, dict) else ():
        if station != "from":
            file.record(Station, ("reference", station))
    return Rubric(**asdict(file.record(_Table)), name=name)


def unknown_exceptions(rubric: Rubric, submissions: Submissions) -> list[Diagnostic]:
    """Warn of each late exception for a student who is not in the class: it has no effect."""
    items = submissions.items
    known = {name.casefold(): one.student for one in items for name in (one.student, one.name, *one.ids.values())}
    found = []
    for one in rubric.late.exceptions if rubric.late else ():
        if one.student.casefold() not in known:
            close = difflib.get_close_matches(one.student.casefold(), known, n=1)
            hint = f"did you mean {known[close[0]]}?" if close else "write the name, key or id of a student"
            message = f'the late exception for "{one.student}" has no effect: no submission has this name'
            found.append(Diagnostic.of(diagnostics.EXCEPTION_FOR_NOBODY, message, hint, rubric.name))
    return found


def rubric_shape() -> dict[str, Any]:
    """Return the JSON Schema of a rubric, for editors."""
    return msgspec.json.schema(_Table)
