"""Whether two logs that mean the same give the same I_zz and u."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from typing import Any, NamedTuple

from gates.stored import Found

import gyrodata
from relations import RELATIONS
from relations.log_tables import LogTable, Rewriting, bases

Analyze = Callable[..., Any]
"""A function that analyses a log, such as `gyrodata.analyze`."""


class Outcome(NamedTuple):
    value: float
    u: float
    failure: str = ""


def outcome(
    log: Any, rewriting: Rewriting | None = None, analyze: Analyze = gyrodata.analyze
) -> Outcome:
    """Analyse a log; an error of gyro is a failure."""
    settings = (rewriting and rewriting.settings) or {}
    mapping = (rewriting and rewriting.mapping) or {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gyrodata.GyroWarning)
        try:
            log = log.encode() if isinstance(log, str) else log
            inertia = analyze(
                log, name="log", settings=settings, mapping=mapping
            ).inertia
        except gyrodata.GyroError as error:
            first = next(one for one in error.diagnostics if one.severity == "error")
            return Outcome(0.0, 0.0, f"{first.code} {first.message}")
    return Outcome(inertia.value, inertia.u)


@cache
def outcome_of(table: LogTable, analyze: Analyze) -> Outcome:
    return outcome(table.text, analyze=analyze)


def rewritings(relation: str) -> dict[str, Rewriting]:
    """Rewrite each log to which a relation applies."""
    changed = {base: RELATIONS[relation](table) for base, table in bases().items()}
    return {
        base: rewriting for base, rewriting in changed.items() if rewriting is not None
    }


def difference(relation: str, base: str, rewriting: Rewriting, analyze: Analyze) -> str:
    """Say how a rewritten log differs from its base; nothing if it does not."""
    before, after = (
        outcome_of(rewriting.same_as or bases()[base], analyze),
        outcome(rewriting.log, rewriting, analyze),
    )
    if before.failure or after.failure:
        return (
            f"{relation}, {base}: {before.failure or 'an answer'} | "
            f"{after.failure or 'an answer'}"
        )
    pairs = zip(before[:2], after[:2], rewriting.tolerance, strict=True)
    if all(abs(new - old) <= limit * abs(old) for old, new, limit in pairs):
        return ""
    return (
        f"{relation}, {base}: {before.value:.7e} ± {before.u:.4e} | {after.value:.7e} "
        f"± {after.u:.4e}: "
        f"I_zz by {after.value / before.value - 1:.1e}, u by {after.u / before.u - 1:.1e}"
    )


def differences(
    relation: str,
    most: int = 99,
    analyze: Analyze = gyrodata.analyze,
    slow: Collection[str] = (),
) -> list[str]:
    """Compare logs to which a relation applies; each relation takes others first.

    Bases that are slow are only taken where a relation applies to no other."""
    changed = rewritings(relation)
    pairs = [pair for pair in changed.items() if pair[0] not in slow]
    pairs = pairs or list(changed.items())
    assert pairs, f"{relation} applies to no log"
    first = list(RELATIONS).index(relation) % len(pairs)
    chosen = [*pairs[first:], *pairs[:first]][:most]
    return [
        difference(relation, base, rewriting, analyze) for base, rewriting in chosen
    ]


def gate(accept: bool = False, part: bool = False) -> Found:
    """Compare all of them; in a part, two logs of each relation."""
    with ProcessPoolExecutor(2) as pool:
        found = list(
            pool.map(differences, RELATIONS, [2 if part else 99] * len(RELATIONS))
        )
    lines = [line for of_relation in found for line in of_relation]
    wrong = [line for line in lines if line]
    measured = f"{len(RELATIONS)} relations: {len(lines) - len(wrong)} of {len(lines)} logs agree"
    return Found(measured, "all, in I_zz and u to 1e-6 or the digits", not wrong, wrong)
