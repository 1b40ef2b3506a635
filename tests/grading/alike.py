"""Classes with copies of every kind, and all that is found in them: the golden text of the flags and their chances."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np
from grading.students import Course, Row, honest_class, print_of, prints_of, text, with_times
from msgspec import Struct

from gyrodata.grading import Fingerprint, flag_class
from gyrodata.grading.forensics import put_beside
from gyrodata.grading.forensics.flags import flag_pairs
from gyrodata.grading.forensics.logs import lay_out

Logs = dict[str, list[Row]]


class Scene(Struct, frozen=True):
    """A class, who works together, and earlier logs."""

    name: str
    prints: Mapping[str, Fingerprint]
    partners: tuple[frozenset[str], ...] = ()
    previous: Mapping[str, Fingerprint] = {}


def drawn(seed: int, students: int, course: Course) -> Logs:
    return honest_class(np.random.default_rng(seed), course, students)


def nudged(rows: list[Row], which: Iterable[int], rpm: float = 9.0, factor: float = 1.03) -> list[Row]:
    """Give other spins and times to some rows."""
    chosen = set(which)
    return [
        (m, x, f"{float(spin) + rpm:g}", f"{factor * float(time):.2f}", turns)
        if i in chosen
        else (m, x, spin, time, turns)
        for i, (m, x, spin, time, turns) in enumerate(rows)
    ]


def retimed(rows: list[Row], which: Iterable[int], by: float = 0.2) -> list[Row]:
    """Give other times to some rows."""
    chosen = set(which)
    return [(*row[:3], f"{float(row[3]) + by:.2f}", row[4]) if i in chosen else row for i, row in enumerate(rows)]


def respun(rows: list[Row], spin: Callable[[float], str]) -> list[Row]:
    return [(m, x, spin(float(rpm)), t, f) for m, x, rpm, t, f in rows]


def scenes() -> Iterator[Scene]:
    """Scenes in which the chances, limits and words of all kinds of flags are met."""
    plain, near = Course(), Course(missed=1.0, hand=(0.05, 0.08))
    logs = drawn(1, 14, plain)
    names = list(logs)
    one = logs[names[2]]
    copies = {f"k{n}": nudged(one, range(9 - n)) for n in range(2, 8)}
    copies |= {f"t{n}": retimed(one, range(9 - n)) for n in range(0, 6, 2)}
    for name, rows in copies.items():
        yield Scene(f"one copy: {name}", prints_of(logs | {name: rows}))
    yield Scene("rounded, turned round", prints_of(logs | {"zz": with_times(one[::-1], lambda time: time, 1)}))
    yield Scene("later, turned round", prints_of(logs | {"zz": with_times(one[::-1], lambda time: time + 0.3)}))
    yield Scene("a copy of four rows", prints_of(logs | {"zz": one[:2] + one[5:7]}))
    yield Scene("spins rounded to 5", prints_of(logs | {"zz": respun(one, lambda rpm: f"{5 * round(rpm / 5):.0f}")}))
    for factor in (1.09, 1.12):
        heavier = [(f"{float(m) * factor:.2f}", *row) for m, *row in one]
        yield Scene(f"a copy at {factor} times the weight", prints_of(logs | {"zz": heavier}))  # type: ignore[dict-item]
    ring = {f"z{n}": nudged(one, (n, n + 1)) for n in range(4)}
    yield Scene("a ring", prints_of(logs | ring), (frozenset({"z0", "z1", "nobody"}), frozenset({"z1", "z2"})))
    early = {"2023/a": print_of(text(one)), "2022/b": print_of(text(one)), "2022/c": print_of(text(logs[names[5]]))}
    yield Scene("earlier logs", prints_of(logs), (), early)
    yield Scene("earlier logs alone", prints_of({"a": one}), (), early)
    two = {"a": one, "b": retimed(one, (0, 1, 2))}
    yield Scene("two", prints_of(two))
    yield Scene("two partners", prints_of(two), (frozenset({"a", "b"}),))
    alike = drawn(4, 16, Course(missed=0.0, stations=2, hand=(0.05, 0.08)))
    yield Scene("spins that all hit", prints_of(alike | {"zz": retimed(alike["s00003"], (1, 2))}))
    crowd = drawn(5, 14, near)
    rows = crowd["s00001"][:4]
    yield Scene(
        "rows left in by four",
        prints_of(
            {k: rows[: 4 - n] + v[4 - n :] for n, (k, v) in enumerate(crowd.items()) if n < 4}
            | {k: v for n, (k, v) in enumerate(crowd.items()) if n >= 4}
        ),
    )
    habit = {
        name: [(*mine[:2], theirs[2], *mine[3:]) for mine, theirs in zip(rows, one, strict=True)]
        for name, rows in list(logs.items())[:7]
    }
    for many in (4, 5, 6, 7):
        yield Scene(f"spins of {many}", prints_of(logs | dict(list(habit.items())[:many])))
    repeats = drawn(6, 6, Course(repeats=2, same_spin=True, missed=3.0, rpm_decimals=1))
    yield Scene(
        "repeats", prints_of(repeats | {"zz": repeats["s00004"][::-1], "zy": retimed(repeats["s00001"], range(7))})
    )
    for hand in (0.0, 0.02, 0.03, 0.05):
        yield Scene(f"a hand of {hand} s", prints_of(drawn(7, 5, Course(hand=(hand, hand), rpm_decimals=1))))
    exact = {f"p{n}": print_of(periods(rows)) for n, rows in enumerate([*logs.values()][:6])}
    yield Scene("periods", exact | {"zz": print_of(periods(one[::-1]))})
    yield Scene(
        "tens",
        prints_of(
            {name: respun(rows, lambda rpm: f"{10 * round(rpm / 10):.0f}") for name, rows in logs.items()}
            | {"zz": respun(one, lambda rpm: f"{10 * round(rpm / 10):.0f}")}
        ),
    )


def periods(rows: list[Row]) -> str:
    """The log with periods, which no hand timed."""
    parts = {"1/3": 1 / 3, "2/3": 2 / 3, "1": 1.0}
    lines = [f"{m},{x},{s},{float(t) / parts[f]:.2f}" for m, x, s, t, f in rows]
    return "\n".join(["# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],precession period [s]", *lines, ""])


def number(value: float) -> str:
    return f"{value:.9g}"


def flags_of(scene: Scene) -> Iterator[str]:
    """Tell the flags of a class, to the digit."""
    for flag in flag_class(scene.prints, scene.partners, scene.previous):
        yield f"{flag.kind} {flag.students} {flag.previous} p {number(flag.p)} expected {number(flag.expected)}"
        yield f"  {flag.evidence}"
        yield f"  {' '.join('-'.join(pair) for pair in flag.pairs)}"


def sides(scene: Scene) -> Iterator[str]:
    """Tell how logs lie beside each other."""
    *_, first, last = sorted(every := {**scene.prints, **scene.previous})
    rows = put_beside(every[first], every[last])
    yield " ".join(f"{one.first}:{one.second}{'s' * one.same_spin}{'p' * one.same_period}" for one in rows)


def laid_out(scene: Scene) -> Iterator[str]:
    """Tell the numbers of all logs side by side."""
    logs = lay_out(scene.prints, scene.partners, scene.previous)
    yield f"pairs {logs.pairs}, exempt {logs.exempt.tolist()}, starts {logs.starts.tolist()}"
    scatters = (
        f"{one.times} {one.dof} {number(one.squares)} {number(one.size)}" if one else "-" for one in logs.scatters
    )
    yield f"scatters {'; '.join(scatters)}"
    for name in ("period", "period_step", "spin_step", "noise"):
        yield f"{name} {' '.join(map(number, getattr(logs, name)[:: max(1, len(logs.log) // 9)].tolist()))}"


def told(patch: Callable[[str, Any], None], first: int = 0, step: int = 1) -> Iterator[str]:
    """Tell of each scene what is flagged, and the chances of all pairs where nearly every one is allowed.

    `patch`: Puts something into the place of a name below `gyrodata.grading.forensics`.
    """
    lines: list[str] = []

    def noted(kind: str, pairs: Iterable[tuple[float, int, int]], *rest: Any) -> Any:
        pairs = sorted(pairs)
        lines.append(f"{kind}: " + ", ".join(f"{one}-{other} {number(p)}" for p, one, other in pairs))
        return flag_pairs(kind, pairs, *rest)  # type: ignore[arg-type]

    patch("copies.flag_pairs", noted)
    for scene in islice(scenes(), first, None, step):
        lines.append(f"== {scene.name}")
        lines += [*laid_out(scene), *sides(scene), *flags_of(scene)]
        patch("copies.ALLOWED", 1e3)
        lines += flags_of(scene)
        patch("copies.ALLOWED", 0.05)
        yield "".join(f"{line}\n" for line in lines)
        lines.clear()
