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
from contextlib import suppress
from functools import cached_property
from importlib.resources import files
from typing import Any, Literal, NamedTuple

from msgspec import Struct, to_builtins

from gyrodata.diagnostics import (
    CONDITION_CANNOT_BE_USED,
    CRITERION_KIND_UNKNOWN,
    NO_UNLOADED_RUN,
    OUTLIER_BEFORE_LEAVING,
    RUBRIC_PARTS_CONTRADICT,
    RUBRIC_POINTS_DO_NOT_ADD_UP,
    SPIN_FALLS_TOO_MUCH,
    SPINS_TOO_CLOSE,
    TIMES_TOO_SHORT,
    TOO_FEW_RUNS,
    TOO_FEW_WEIGHTS,
)
from gyrodata.errors import InputError
from gyrodata.grading.late import LateRule, read_late
from gyrodata.grading.toml_table import Faults, Shape, Table, nearest, read_toml
from gyrodata.grading.yardsticks import FIT_WORDS, Bench, Reference, read_bench, read_references
from gyrodata.quantities import parse_quantity
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
    "weights": TOO_FEW_WEIGHTS,
    "runs": TOO_FEW_RUNS,
    "spins": SPINS_TOO_CLOSE,
    "unloaded": NO_UNLOADED_RUN,
    "times": TIMES_TOO_SHORT,
    "falling_spin": SPIN_FALLS_TOO_MUCH,
    "odd_runs": OUTLIER_BEFORE_LEAVING,
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
    references: Mapping[str, Reference]  # by station; "all" holds for every other
    class_reference: bool  # True where the class itself gives the reference
    bench: Bench  # uncertainties of the readings for logs that state none
    class_scatter: bool  # True where the class itself tells how far such readings scatter

    @cached_property
    def digest(self) -> str:
        """Hash of all that can change a grade: remarks and blanks of the file do not."""
        content = to_builtins(self, builtin_types=(dt.datetime,))
        del content["name"]
        return hashlib.sha256(json.dumps(content, sort_keys=True, default=dt.datetime.isoformat).encode()).hexdigest()


def default_rubric_text(kind: Literal["simple", "full", "manual"] = "full") -> str:
    """Give a rubric to begin with as its author wrote it, with remarks; "full" is the built-in one."""
    name = "rubric.toml" if kind == "full" else f"rubric-{kind}.toml"
    return files("gyrodata.grading").joinpath(name).read_text("utf-8")


def default_rubric() -> Rubric:
    """Give the built-in rubric."""
    return read_rubric(default_rubric_text().encode(), "built-in rubric")


def read_rubric(data: bytes, name: str = "rubric.toml") -> Rubric:
    """Read a rubric."""
    return _rubric(read_toml(data, name), name)


def rubric_shape() -> Shape:
    """Give the JSON Schema of a rubric: what is asked for where one has every table and every kind of criterion."""
    values: dict[str, Any] = {
        "criterion": [{"check": kind} for kind in KINDS],
        "late": {"tier": [{}], "exception": [{}]},
        "reference": {"all": {}},
        "bench": {},
    }
    top = Table(values, (), Faults("", ""))
    # It lacks every value that a rubric must have.
    with suppress(InputError):
        _rubric(top, "")
    return top.shape


def _rubric(top: Table, name: str) -> Rubric:
    schema = top.number("schema", "1", required=True)
    top.asked["schema"]["const"] = 1
    if schema not in (None, 1.0):
        top.wrong("schema", f"schema {schema:g} is not known to this version", "write schema = 1")
    title = top.text("title", '"Gyroscope lab"') or "Gyroscope lab"
    points = top.number("points", "20", required=True)
    accept = top.choices("accept", ACCEPTED, ACCEPTED)
    no_report = top.choice("no_report", ("look", "zero"), "look")
    tables = top.tables("criterion")
    criteria = _criteria(top, tables)
    # A criterion that has another fault counts, and nothing is said of a sum that cannot be made.
    stated = [table.values.get("points") for table in tables]
    numbers = [one for one in stated if isinstance(one, int | float) and not isinstance(one, bool)]
    each = [float(one) for one in numbers if 0 <= one < 1e9]
    total = math.fsum(each)
    if each and len(each) == len(stated) and points is not None and abs(total - points) > 1e-9:
        parts = " + ".join(f"{one:g}" for one in each)
        hint = f"write points = {total:g}, or change the points of a criterion"
        top.wrong(
            "points",
            f"points = {points:g}, but the criteria add up to {parts} = {total:g}",
            hint,
            RUBRIC_POINTS_DO_NOT_ADD_UP,
        )
    late = read_late(top, points or 0.0)
    references, from_class = read_references(top)
    bench, from_scatter = read_bench(top)
    asked = next((c for c in criteria if c.check == "reference"), None)
    if asked and not references and not from_class and "reference" not in top.values:
        hint = '[reference.3] with inertia = "4.44e-3 kg m^2" and u = "1 %", or [reference] with from = "class"'
        top.faults.add(
            RUBRIC_PARTS_CONTRADICT, (), f'criterion "{asked.id}" compares with a reference, and none is given', hint
        )
    top.done()
    top.faults.stop_if_any()
    return Rubric(
        name=name,
        title=title,
        points=points or 0.0,
        accept=accept,
        no_report="zero" if no_report == "zero" else "look",
        criteria=criteria,
        late=late,
        references=references,
        class_reference=from_class,
        bench=bench,
        class_scatter=from_scatter,
    )


# --- criteria -----------------------------------------------------------------------------------------------


def _criteria(top: Table, tables: list[Table]) -> tuple[Criterion, ...]:
    if not tables and "criterion" not in top.values:
        hint = 'write at least one: [[criterion]], id = "log", check = "log", points = 2'
        top.faults.add(RUBRIC_PARTS_CONTRADICT, (), "there is not one criterion", hint)
    criteria: list[Criterion] = []
    for table in tables:
        criterion = _criterion(table)
        if criterion is None:
            continue
        if any(other.id == criterion.id for other in criteria):
            table.wrong("id", f'two criteria have the id "{criterion.id}"', "give each its own id")
        criteria.append(criterion)
    return tuple(criteria)


def _criterion(table: Table) -> Criterion | None:
    check = table.text("check", " or ".join(f'"{kind}"' for kind in KINDS), required=True)
    if check is not None and check not in KINDS:
        table.wrong("check", f'there is no check "{check}"', nearest(check, tuple(KINDS)), CRITERION_KIND_UNKNOWN)
        check = None
    name = table.text("id", f'"{check or "log"}"', required=True)
    points = table.number("points", "2", required=True)
    if check is None:
        table.asked |= {key: {} for key in ("title", "full", "zero", "slip", "gate", "asks")}
        table.done()
        return None
    table.asked["check"]["const"] = check
    table.shape["title"] = KINDS[check].title
    title = table.text("title", f'"{KINDS[check].title}"') or KINDS[check].title
    curve, told = _curve(table, check) if KINDS[check].variables else (Curve("", (0.0, 0.0), (0.0, 0.0)), "")
    slip = 0.0
    gate = None
    if check == "own_data":
        slip = table.deduction("slip", points or 0.0, (points or 0.0) / 2)
    if check in ("own_data", "reference", "uncertainty"):
        gate = _gate(table)
    asks = table.choices("asks", tuple(ASKS), tuple(ASKS)[:3]) if check == "procedure" else ()
    table.done()
    if name is None or points is None or curve is None:
        return None
    return Criterion(name, title, check, points, curve, told, slip, gate, asks)  # type: ignore[arg-type]


def _curve(table: Table, check: str) -> tuple[Curve | None, str]:
    """The conditions for all points and for none, both by default or both written."""
    default = KINDS[check].full, KINDS[check].zero
    texts = [table.text(key, f'"{default[i]}"') for i, key in enumerate(("full", "zero"))]
    pattern = _CONDITION.pattern.replace(_NAME, f"({'|'.join(KINDS[check].variables)})")
    meanings = "; ".join(f"{variable}: {MEANINGS[variable]}" for variable in KINDS[check].variables)
    for key in ("full", "zero"):
        table.asked[key] |= {"pattern": f"^{pattern}$", "description": f"{table.asked[key]['description']}; {meanings}"}
    table.shape["dependentRequired"] = {"full": ["zero"], "zero": ["full"]}
    given = [key for key in ("full", "zero") if key in table.values]
    if len(given) == 1:
        other = {"full": "zero", "zero": "full"}[given[0]]
        hint = f'write {other} too, or leave both out: then full = "{default[0]}" and zero = "{default[1]}" hold'
        table.wrong(given[0], f'"{given[0]}" is given, and "{other}" is not', hint, CONDITION_CANNOT_BE_USED)
        return None, ""
    full, zero = (text or default[i] for i, text in enumerate(texts))
    conditions = []
    for key, text in (("full", full), ("zero", zero)):
        try:
            condition = parse_condition(text)
        except ConditionError as error:
            table.wrong(key, str(error), error.hint, CONDITION_CANNOT_BE_USED)
            continue
        if condition.variable not in KINDS[check].variables:
            known = " or ".join(KINDS[check].variables)
            message = f'"{condition.variable}" means nothing in a criterion with check = "{check}"'
            table.wrong(key, message, f"write a condition on {known}", CONDITION_CANNOT_BE_USED)
            continue
        conditions.append(condition)
    if len(conditions) < 2:
        return None, ""
    try:
        told = f"all points for {full}, none for {zero}; {conditions[0].variable}: {MEANINGS[conditions[0].variable]}"
        return make_curve(*conditions), told.replace("<=", "≤").replace(">=", "≥").replace("..", " to ")
    except ConditionError as error:
        table.wrong("zero" if "zero" in table.values else "full", str(error), error.hint, CONDITION_CANNOT_BE_USED)
        return None, ""


def _gate(table: Table) -> tuple[float, float] | None:
    sample = '["1e-6 kg m^2", "100 kg m^2"]'
    value = table.take("gate", (list,), sample)
    table.asked["gate"] |= {"items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    if value is None:
        return None
    if len(value) != 2 or not all(isinstance(end, str) for end in value):
        table.wrong("gate", "gate needs two moments of inertia with their unit", f"write gate = {sample}")
        return None
    try:
        low, high = (parse_quantity(end, "inertia") for end in value)
    except UnitError as error:
        table.wrong("gate", f"gate: {error}", f"write gate = {sample}")
        return None
    if not low < high:
        table.wrong("gate", "gate: the first is not below the second", f"write gate = {sample}")
    return low, high


# --- conditions, "d <= 0.3" or "ratio in 0.5..2", and the points between two of them ------------------------


_NAME = r"([A-Za-z_]\w*)"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_CONDITION = re.compile(
    rf"\s*{_NAME}\s*(?:(<=|>=|≤|≥)\s*({_NUMBER})|(in|outside)\s+({_NUMBER})\s*\.\.\s*({_NUMBER}))\s*"
)
_STRICT = re.compile(rf"\s*{_NAME}\s*([<>])\s*({_NUMBER})\s*")
_SIGNS = {"≤": "<=", "≥": ">="}


class ConditionError(ValueError):
    """A condition that cannot be used."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint


class Condition(Struct, frozen=True):
    """One comparison of a variable with numbers."""

    variable: str
    relation: str  # "<=", ">=", "in" or "outside"
    low: float  # lower end; -inf for "<="
    high: float  # upper end; inf for ">="


class Curve(Struct, frozen=True):
    """Share of the points against a variable: 1 where `full` holds, 0 where `zero` does, linear in between."""

    variable: str
    full: tuple[float, float]  # all points from the first to the second; ±inf where there is no end
    zero: tuple[float, float]  # no points up to the first and from the second on; ±inf where there is no end

    def share(self, value: float) -> float:
        """Give the share of the points, from 0 to 1; 0 for a value that is not a number."""
        if self.full[0] <= value <= self.full[1]:
            return 1.0
        near, far = (self.full[0], self.zero[0]) if value < self.full[0] else (self.full[1], self.zero[1])
        if math.isnan(value) or math.isinf(far) or near == far:
            return 0.0
        return max(0.0, (far - value) / (far - near))


def parse_condition(text: str) -> Condition:
    """Read ``NAME <= NUMBER``, ``NAME >= NUMBER``, ``NAME in LOW..HIGH`` or ``NAME outside LOW..HIGH``."""
    match = _CONDITION.fullmatch(text)
    if match is None:
        hint = 'write it like "d <= 0.3", "z >= 5", "ratio in 0.5..2" or "ratio outside 0.2..5"'
        if strict := _STRICT.fullmatch(text):
            name, sign, limit = strict[1], strict[2], float(strict[3])
            if name in COUNTED:
                # Below 1 warning is none, and none is what "<= 0" says.
                limit = math.ceil(limit) - 1 if sign == "<" else math.floor(limit) + 1
            hint = f'write "{name} {sign}= {limit:g}"'
        raise ConditionError(f'"{text[:60]}" is no condition', hint)
    name, sign, bound, word, first, last = match.groups()
    if word:
        low, high = float(first), float(last)
        if not low < high:
            raise ConditionError(f'"{text}": {first} is not below {last}', f'write "{name} {word} {last}..{first}"')
        return Condition(name, word, low, high)
    number = float(bound)
    relation = _SIGNS.get(sign, sign)
    return Condition(name, relation, *((-math.inf, number) if relation == "<=" else (number, math.inf)))


def make_curve(full: Condition, zero: Condition) -> Curve:
    """Join the condition for all points and the one for none, of one variable and farther out."""
    if full.variable != zero.variable:
        raise ConditionError(
            f'full speaks of "{full.variable}" and zero of "{zero.variable}"',
            f"write zero on {full.variable} as well, or full on {zero.variable}",
        )
    name = full.variable
    opposite = {"<=": ">=", ">=": "<=", "in": "outside"}
    if full.relation not in opposite:
        raise ConditionError('full is "… outside …"', f'that is for zero: write full = "{name} in LOW..HIGH"')
    if zero.relation != opposite[full.relation]:
        sample, where = {
            "<=": ("NUMBER", f"NUMBER above {full.high:g}"),
            ">=": ("NUMBER", f"NUMBER below {full.low:g}"),
            "in": ("LOW..HIGH", f"LOW below {full.low:g} and HIGH above {full.high:g}"),
        }[full.relation]
        raise ConditionError(
            f'full with "{full.relation}" does not go with zero with "{zero.relation}"',
            f'write zero = "{name} {opposite[full.relation]} {sample}" with {where}',
        )
    if full.relation == "<=":
        ends = (-math.inf, zero.low)
    elif full.relation == ">=":
        ends = (zero.high, math.inf)
    else:
        ends = (zero.low, zero.high)
    if ends[0] > full.low or ends[1] < full.high:
        raise ConditionError(
            "full and zero overlap: some values would earn all points and none",
            "put the limit of zero farther out than the limit of full",
        )
    return Curve(name, (full.low, full.high), ends)
