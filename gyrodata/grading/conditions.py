"""Conditions of a rubric, "d <= 0.3" or "ratio in 0.5..2", read by rule, and the points between two of them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_CONDITION = re.compile(
    rf"\s*([A-Za-z_]\w*)\s*(?:(<=|>=|≤|≥)\s*({_NUMBER})|(in|outside)\s+({_NUMBER})\s*\.\.\s*({_NUMBER}))\s*"
)
_STRICT = re.compile(rf"\s*([A-Za-z_]\w*)\s*([<>])\s*({_NUMBER})\s*")
_SIGNS = {"≤": "<=", "≥": ">="}


class ConditionError(ValueError):
    """A condition that cannot be used."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Condition:
    """One comparison of a variable with numbers."""

    variable: str
    relation: str
    """"<=", ">=", "in" or "outside"."""
    low: float
    """Lower end; -inf for "<="."""
    high: float
    """Upper end; inf for ">="."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Share of the points against a variable: 1 where `full` holds, 0 where `zero` does, linear in between."""

    variable: str
    full: tuple[float, float]
    """All points from the first to the second; ±inf where there is no end."""
    zero: tuple[float, float]
    """No points up to the first and from the second on; ±inf where there is no end."""

    def share(self, value: float) -> float:
        """Give the share of the points.

        Gives: From 0 to 1; 0 for a value that is not a number.
        """
        if self.full[0] <= value <= self.full[1]:
            return 1.0
        near, far = (self.full[0], self.zero[0]) if value < self.full[0] else (self.full[1], self.zero[1])
        if math.isnan(value) or math.isinf(far) or near == far:
            return 0.0
        return max(0.0, (far - value) / (far - near))


def parse_condition(text: str) -> Condition:
    """Read one condition.

    `text`: ``NAME <= NUMBER``, ``NAME >= NUMBER``, ``NAME in LOW..HIGH`` or ``NAME outside LOW..HIGH``.
    """
    match = _CONDITION.fullmatch(text)
    if match is None:
        hint = 'write it like "d <= 0.3", "z >= 5", "ratio in 0.5..2" or "ratio outside 0.2..5"'
        if strict := _STRICT.fullmatch(text):
            hint = f'write "{strict[1]} {strict[2]}= {strict[3]}"'
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
    """Join the condition for all points and the one for none.

    `full`, `zero`: Of one variable, and the zero one farther out than the full one.
    """
    if full.variable != zero.variable:
        raise ConditionError(
            f'full speaks of "{full.variable}" and zero of "{zero.variable}"', "write both with the same name"
        )
    name = full.variable
    opposite = {"<=": ">=", ">=": "<=", "in": "outside"}
    if full.relation not in opposite:
        raise ConditionError('full is "… outside …"', f'write full = "{name} in LOW..HIGH"')
    if zero.relation != opposite[full.relation]:
        sample = "LOW..HIGH" if full.relation == "in" else "NUMBER"
        raise ConditionError(
            f'full with "{full.relation}" does not go with zero with "{zero.relation}"',
            f'write zero = "{name} {opposite[full.relation]} {sample}"',
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
