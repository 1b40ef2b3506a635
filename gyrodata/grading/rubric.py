"""The rubric: what is judged, what earns how many points, what being late costs, and what the truth is.

A TOML file; the one that stands beside this module holds where none is given, and explains every key.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import math
import re
from collections.abc import Mapping
from functools import cached_property
from importlib.resources import files
from typing import Annotated, Any, Literal, NamedTuple, Union, cast

import msgspec
from msgspec import Meta, Struct, defstruct, field, to_builtins
from msgspec.structs import replace

from gyrodata import diagnostics
from gyrodata.grading.late import Deduction, LateRule, points_of
from gyrodata.grading.yardsticks import APPARATUS, FIT_WORDS, Bench, BenchTable, Reference, Station, station_key
from gyrodata.quantities import parse_quantity
from gyrodata.toml_table import Number, Path, Text, TomlFile, UnfitError
from gyrodata.units import UnitError

Check = Literal["log", "procedure", "own_data", "reference", "uncertainty", "units", "constancy", "files", "manual"]


class Kind(NamedTuple):
    """One kind of criterion."""

    title: str
    variables: tuple[str, ...]  # what its conditions may speak of, of `MEANINGS`
    full: str  # by default, the condition for all points
    zero: str  # the one for none
    of_report: bool = False  # True where nothing can be judged without a reported I_zz


KINDS: dict[str, Kind] = {
    "log": Kind("The log can be read", ("warnings",), "warnings <= 0", "warnings >= 4"),
    "procedure": Kind("The procedure is complete", ("missing",), "missing <= 0", "missing >= 3"),
    "own_data": Kind("I_zz follows from your own runs", ("d", "percent"), "d <= 0.3", "d >= 3", True),
    "reference": Kind("I_zz agrees with the reference", ("z", "percent"), "z <= 2", "z >= 5", True),
    "uncertainty": Kind(
        "The uncertainty is realistic", ("ratio", "stated"), "ratio in 0.5..2", "ratio outside 0.2..5", True
    ),
    "units": Kind("Unit and digits", ("faults",), "faults <= 0", "faults >= 2", True),
    "constancy": Kind("φ̇ψ̇ is constant for each torque", ("p", "spread"), "p >= 0.001", "p <= 0.000001"),
    "files": Kind("A plot is handed in", ("files",), "files >= 1", "files <= 0"),
    "manual": Kind("Judged by a person", (), "", ""),
}

MEANINGS = {
    "warnings": "the number of things to put right",
    "missing": "the number of things that are missing",
    "d": "the distance from the nearest fit of your own runs, in units of its u",
    "z": "the distance from the reference, in standard uncertainties",
    "percent": "the distance in percent",
    "stated": "1 if an uncertainty is stated, else 0",
    "files": "the number of pictures and PDFs beside the log",
    "ratio": "your u over that of your fits",
    "faults": "the number of faults",
    "p": "the chance of such a scatter",
    "spread": "the largest scatter at one torque, as a share of φ̇ψ̇",
}
"""Each variable in words, to a student."""

COUNTED = ("warnings", "missing", "stated", "files", "faults")
"""Variables that are whole numbers."""

ASKS = {
    "weights": diagnostics.TOO_FEW_WEIGHTS,
    "runs": diagnostics.TOO_FEW_RUNS,
    "spins": diagnostics.SPINS_TOO_CLOSE,
    "unloaded": diagnostics.NO_UNLOADED_RUN,
    "times": diagnostics.TIMES_TOO_SHORT,
    "falling_spin": diagnostics.SPIN_FALLS_TOO_MUCH,
    "odd_runs": diagnostics.OUTLIER,
}
"""What a procedure criterion may ask for, and the diagnostic of a log that lacks it."""

ACCEPTED = tuple(FIT_WORDS)
"""Fits of a student's own runs that a rubric may accept."""


class Criterion(Struct, frozen=True):
    """One thing that is judged."""

    id: str  # unique; the column of the grades
    title: str
    check: Check
    points: float
    curve: Curve
    told: str  # the two conditions in words
    slip: float  # points that a known slip costs, once; only of own_data
    gate: tuple[float, float] | None  # a reported I_zz outside earns nothing here [kg*m^2]
    asks: tuple[str, ...]  # of `ASKS`; only of procedure


class Rubric(Struct, frozen=True, dict=True):
    """Everything that decides about points."""

    name: str
    title: str
    points: float
    accept: tuple[str, ...]  # fits of the student's own runs that are right answers, of `ACCEPTED`
    no_report: Literal["look", "zero"]  # what no reported I_zz at all means
    criteria: tuple[Criterion, ...]
    late: LateRule | None
    references: Mapping[str, Reference]  # by station; "all" is for every other
    class_reference: bool  # True where the class itself gives the reference
    bench: Bench  # uncertainties of the readings for logs that state none
    class_scatter: bool  # True if the scatter of such readings is estimated from the class

    @cached_property
    def digest(self) -> str:
        """Hash of all that can change a grade: remarks and blanks of the file do not."""
        content = to_builtins(self, builtin_types=(dt.datetime,))
        del content["name"]
        return hashlib.sha256(json.dumps(content, sort_keys=True, default=dt.datetime.isoformat).encode()).hexdigest()

    @cached_property
    def judged(self) -> str:
        """Digest without the references, which come into a grade once the class is there."""
        return replace(self, references={}, class_reference=False).digest


def default_rubric_text(kind: Literal["simple", "full", "manual"] = "full") -> str:
    """Give a rubric to begin with as its author wrote it, with remarks; "full" is the built-in one."""
    name = "rubric.toml" if kind == "full" else f"rubric-{kind}.toml"
    return files("gyrodata.grading").joinpath(name).read_text("utf-8")


def default_rubric() -> Rubric:
    """Give the built-in rubric."""
    return read_rubric(default_rubric_text().encode(), "built-in rubric")


def read_rubric(data: bytes, name: str = "rubric.toml") -> Rubric:
    """Read a rubric; raise InputError with its first fault."""
    hint = "a line is KEY = VALUE, its texts in quotation marks, or a head, [NAME] or [[criterion]]; no key twice"
    file = TomlFile(data, name, diagnostics.RUBRIC_NO_TOML, hint)
    references, written = {}, file.values.get("reference")
    for station in written if isinstance(written, dict) else ():
        if station != "from":
            words = "the rubric" if station == "all" else f"the rubric, station {station}"
            references[station_key(station)] = file.record(Station, ("reference", station)).reference(words)
    table = file.record(_File)
    source = (table.reference or {}).get("from")
    if source not in ("class", None):
        message = f'from = "{source}" cannot be used'
        raise file.fault(
            diagnostics.RUBRIC_VALUE_CANNOT_BE_USED, ("reference", "from"), message, 'write from = "class"'
        )
    given: Any = table.bench  # a record of `defstruct`
    bench: Bench = given.stated() if given is not None else {}
    class_scatter = given is not None and given.source == "class"
    of_reference = table.reference is not None and (source is not None) == bool(references)
    of_bench = class_scatter and not set(APPARATUS).issuperset(bench)
    if of_reference or of_bench:
        message = "both the class and stated values, or neither"
        hint = 'either write from = "class", or state values and leave that out'
        head = "reference" if of_reference else "bench"
        raise file.fault(diagnostics.RUBRIC_PARTS_CONTRADICT, (head, "from"), message, hint)
    return Rubric(
        name=name,
        title=table.title,
        points=table.points,
        accept=tuple(dict.fromkeys(table.accept)),
        no_report=table.no_report,
        criteria=tuple(one.criterion() for one in table.criteria),
        late=table.late,
        references=references,
        class_reference=source is not None,
        bench=bench,
        class_scatter=class_scatter,
    )


def rubric_shape() -> dict[str, Any]:
    """Give the JSON Schema of a rubric, for editors."""
    return msgspec.json.schema(_File)


# --- conditions, "d <= 0.3" or "ratio in 0.5..2", and the points between two of them ------------------------


_NAME = r"([A-Za-z_]\w*)"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_REST = rf"\s*(?:(<=|>=|≤|≥)\s*({_NUMBER})|(in|outside)\s+({_NUMBER})\s*\.\.\s*({_NUMBER}))\s*"
_STRICT = re.compile(rf"\s*{_NAME}\s*([<>])\s*({_NUMBER})\s*")
_SIGNS = {"≤": "<=", "≥": ">="}


class Condition(Struct, frozen=True):
    """One comparison of a variable with numbers."""

    text: str
    variable: str
    relation: str  # "<=", ">=", "in" or "outside"
    low: float  # lower end; -inf for "<="
    high: float  # upper end; inf for ">="


class Curve(Struct, frozen=True):
    """Share of the points against a variable: 1 where `full` holds, 0 where `zero` does, linear in between."""

    variable: str
    full: tuple[float, float]  # all points from the first to the second; ±inf without a limit
    zero: tuple[float, float]  # no points up to the first and from the second on; ±inf without a limit

    def share(self, value: float) -> float:
        """Give the share of the points, from 0 to 1; 0 for a value that is not a number."""
        if self.full[0] <= value <= self.full[1]:
            return 1.0
        near, far = (self.full[0], self.zero[0]) if value < self.full[0] else (self.full[1], self.zero[1])
        if math.isnan(value) or math.isinf(far) or near == far:
            return 0.0
        return max(0.0, (far - value) / (far - near))


def parse_condition(text: str, key: str) -> Condition:
    """Read ``NAME <= NUMBER``, ``NAME >= NUMBER``, ``NAME in LOW..HIGH`` or ``NAME outside LOW..HIGH``."""
    match = re.fullmatch(rf"\s*{_NAME}{_REST}", text)
    if match is None:
        hint = 'write it like "d <= 0.3", "z >= 5", "ratio in 0.5..2" or "ratio outside 0.2..5"'
        if strict := _STRICT.fullmatch(text):
            name, sign, limit = strict[1], strict[2], float(strict[3])
            if name in COUNTED:
                # Below 1 warning is none, and none is what "<= 0" says.
                limit = math.ceil(limit) - 1 if sign == "<" else math.floor(limit) + 1
            hint = f'write "{name} {sign}= {limit:g}"'
        raise UnfitError(f'"{text[:60]}" is no condition', hint, diagnostics.CONDITION_CANNOT_BE_USED, key)
    name, sign, bound, word, first, last = match.groups()
    relation = word or _SIGNS.get(sign, sign)
    low, high = float(first or bound), float(last or bound)
    if word and not low < high:
        hint = f'write "{name} {word} {last}..{first}"'
        raise UnfitError(f'"{text}": {first} is not below {last}', hint, diagnostics.CONDITION_CANNOT_BE_USED, key)
    low, high = -math.inf if relation == "<=" else low, math.inf if relation == ">=" else high
    return Condition(text, name, relation, low, high)


_OPPOSITE = {"<=": ">= NUMBER", ">=": "<= NUMBER", "in": "outside LOW..HIGH"}


def make_curve(full: Condition, zero: Condition) -> Curve:
    """Join the condition for all points and the one for none, of one variable and farther out."""
    name, far = full.variable, _OPPOSITE.get(full.relation)
    if far is None:
        hint = f'that is for zero: write full = "{name} in LOW..HIGH"'
        raise UnfitError('full is "… outside …"', hint, diagnostics.CONDITION_CANNOT_BE_USED, "full")
    if (zero.variable, zero.relation) != (name, far.split()[0]):
        message = f'zero = "{zero.text}" does not go with full = "{full.text}"'
        raise UnfitError(
            message, f'write zero = "{name} {far}", farther out', diagnostics.CONDITION_CANNOT_BE_USED, "zero"
        )
    # If zero has no limit, it extends to the other one.
    ends = {"<=": (-math.inf, zero.low), ">=": (zero.high, math.inf), "in": (zero.low, zero.high)}[full.relation]
    if ends[0] > full.low or ends[1] < full.high:
        message = "full and zero overlap: some values would earn all points and none"
        hint = "put the limit of zero farther out than the limit of full"
        raise UnfitError(message, hint, diagnostics.CONDITION_CANNOT_BE_USED, "zero")
    return Curve(name, (full.low, full.high), ends)


# --- the file as it is written ------------------------------------------------------------------------------


class _Criterion(Struct, frozen=True):
    """The keys of every criterion."""

    id: Text
    points: Number

    def __post_init__(self) -> None:
        self.criterion()

    def criterion(self) -> Criterion:
        """Give it as it is judged."""
        given, check = cast(Any, self), cast(Check, self.__struct_config__.tag)
        kind, title = KINDS[check], given.title
        curve, told = Curve("", (0.0, 0.0), (0.0, 0.0)), ""
        if kind.variables:
            full, zero = (_condition(given, key, kind.variables) for key in ("full", "zero"))
            curve = make_curve(full, zero)
            told = f"all points for {full.text}, none for {zero.text}; {curve.variable}: {MEANINGS[curve.variable]}"
            told = told.replace("<=", "≤").replace(">=", "≥").replace("..", " to ")
        if curve.variable == "stated" and title == kind.title:
            title = "An uncertainty is stated"
        slip = points_of(getattr(self, "slip", 0.0), self.points, ("slip",))
        gate = _gate(given.gate) if getattr(self, "gate", None) else None
        asks = tuple(dict.fromkeys(getattr(self, "asks", ())))
        return Criterion(self.id, title, check, self.points, curve, told, slip, gate, asks)


def _condition(given: Any, key: str, variables: tuple[str, ...]) -> Condition:
    condition = parse_condition(getattr(given, key), key)
    if condition.variable not in variables:
        check = given.__struct_config__.tag
        message = f'"{condition.variable}" means nothing in a criterion with check = "{check}"'
        raise UnfitError(
            message, f"write a condition on {' or '.join(variables)}", diagnostics.CONDITION_CANNOT_BE_USED, key
        )
    return condition


def _gate(ends: tuple[str, str]) -> tuple[float, float]:
    """Read two moments of inertia [kg*m^2]."""
    hint = 'write gate = ["1e-6 kg m^2", "100 kg m^2"]'
    try:
        low, high = (parse_quantity(end, "inertia") for end in ends)
    except UnitError as error:
        raise UnfitError(f"gate: {error}", hint, path="gate") from None
    if not low < high:
        raise UnfitError("gate: the first is not below the second", hint, path="gate")
    return low, high


def _keys_of(check: str, kind: Kind) -> Any:
    """Make the record of a kind of criterion."""
    keys: list[Any] = [("title", Text, kind.title)]
    if kind.variables:
        meanings = "; ".join(f"{variable}: {MEANINGS[variable]}" for variable in kind.variables)
        pattern = {"pattern": rf"^\s*({'|'.join(kind.variables)}){_REST}$"}
        condition = Annotated[str, Meta(description=meanings, examples=[kind.full], extra_json_schema=pattern)]
        keys += [("full", condition, kind.full), ("zero", condition, kind.zero)]
    if check == "own_data":
        keys += [("slip", Deduction, "50 %")]
    if check == "procedure":
        asks = Annotated[tuple[Literal[*ASKS], ...], Meta(min_length=1)]  # type: ignore[valid-type]
        keys += [("asks", asks, tuple(ASKS)[:3])]
    if check in ("own_data", "reference", "uncertainty"):
        gate = Annotated[tuple[str, str], Meta(examples=[["1e-6 kg m^2", "100 kg m^2"]])]
        keys += [("gate", gate | None, None)]
    return defstruct(
        check, keys, bases=(_Criterion,), tag_field="check", tag=check, frozen=True, forbid_unknown_fields=True
    )


_Criteria: Any = Union[tuple(_keys_of(check, kind) for check, kind in KINDS.items())]  # noqa: UP007


class _File(Struct, frozen=True, forbid_unknown_fields=True):
    schema: Literal[1]
    points: Number
    criteria: tuple[_Criteria, ...] = field(name="criterion")
    title: Text = "Gyroscope lab"
    accept: Annotated[tuple[Literal[ACCEPTED], ...], Meta(min_length=1)] = ACCEPTED  # type: ignore[valid-type]
    no_report: Literal["look", "zero"] = "look"
    late: LateRule | None = None
    reference: Mapping[str, Station | str] | None = None
    bench: BenchTable | None = None  # type: ignore[valid-type]

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
                raise UnfitError(
                    f'two criteria have the id "{one.id}"', "give each its own id", path=("criterion", at, "id")
                )
            if one.__struct_config__.tag == "reference" and self.reference is None:
                message = f'criterion "{one.id}" compares with a reference, and none is given'
                hint = '[reference.3] with inertia = "4.44e-3 kg m^2" and u = "1 %", or [reference] with from = "class"'
                raise UnfitError(message, hint, diagnostics.RUBRIC_PARTS_CONTRADICT, ("criterion", at))
        late = self.late or LateRule()
        deductions: dict[Path, str | float] = {("late", "beyond"): late.beyond, ("late", "marked"): late.marked or 0.0}
        deductions |= {("late", "tier", at, "deduct"): tier.deduct for at, tier in enumerate(late.tiers)}
        for path, value in deductions.items():
            points_of(value, self.points, path)
