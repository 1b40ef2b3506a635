"""Gate 9: what a report says of a changed log is what `gyro analyze` says if the file
is changed in this way.

A report contains answers to "what would I_zz be if …?": without each weight, the hand
0.1 s late or early, times twice as uncertain, a ball that is balanced or not, one more
digit, a balance test, three times the turns. Here each change is made in the file and
the file is analysed: the value must agree within 0.03 u, and u within 3 %."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import islice
from typing import Any, NamedTuple

import gyrodata
from gates.drawn_logs import Bench, typed
from gates.logs import every_log
from gates.stored import Found

DRAWN = {
    "nine runs": Bench(),
    "27 runs": Bench(repeats=3, lines="# u_time: 0.14 s\n"),
    "thirds": Bench(thirds=True),
    "rod at 30 deg": Bench(pitch=30.0),
}
KNOWN = (
    "sample_data/air_gyroscope.csv",
    "sample_data/heidelberg_ball.csv",
    "tilted",
    "released",
    "followed",
)


class Told(NamedTuple):
    """One answer of a report, and the text of the file that it is about.

    The value is I_zz [kg*m^2], or None if the report tells u over I_zz only; `half` is
    half of the last digit printed."""

    change: str
    text: str
    u: float
    value: float | None = None
    half: float = 0.0


def edited(text: str, header: str, change: Callable[[str, int], str]) -> str:
    """Change the cells of a column, or the line in its place: `change` takes a cell and
    the number of its line.
    """
    lines = text.splitlines()
    top = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    column = next(
        (
            at
            for at, head in enumerate(lines[top].split(","))
            if head.startswith(header)
        ),
        None,
    )
    if column is None:
        return re.sub(
            rf"(?m)^# {header}: (.*)$", lambda m: f"# {header}: {change(m[1], 0)}", text
        )
    for i in range(top + 1, len(lines)):
        cells = lines[i].split(",")
        cells[column] = change(cells[column], i + 1)
        lines[i] = ",".join(cells)
    return "\n".join(lines) + "\n"


def stated(text: str, line: str) -> str:
    """State something, in place of what the log says of it."""
    return f"{line}\n" + re.sub(rf"(?m)^{line.partition(':')[0]}:.*\n", "", text)


def times(text: str, by: Callable[[float, int], float]) -> str:
    """Change the times, and keep their decimals."""
    return edited(
        text,
        "time",
        lambda cell, line: (
            f"{by(float(cell), line):.{max(1, len(cell.partition('.')[2]))}f}"
        ),
    )


def told(text: str, document: dict[str, Any]) -> Iterator[Told]:
    """List the answers of a report that can be made in the file."""
    result = document["result"]
    known = {
        one["name"]: one["inertia"] for one in result["sensitivity"] if one["inertia"]
    }
    files = {
        "hand_late": stated(
            times(text, lambda value, line: value - 0.1), "# u_time_bias: 0 s"
        ),
        "hand_early": stated(
            times(text, lambda value, line: value + 0.1), "# u_time_bias: 0 s"
        ),
        "balanced": stated(text, "# balanced: yes"),
        "balance_free": stated(text, "# balanced: no"),
        "balance_untouched": stated(text, "# balance: untouched"),
    }
    if (
        told_nothing := re.sub(r"(?m)^# (balanced|balance_|u_imbalance).*\n", "", text)
    ) != text:
        files["balance_free"] = told_nothing
    if found := re.search(r"(?m)^# u_time: ([\d.]+) s$", text):
        files["u_time_twice"] = stated(text, f"# u_time: {2 * float(found[1]):g} s")
    yield from (
        Told(name, files[name], known[name]["u"], known[name]["value"])
        for name in files
        if name in known
    )
    for torque in result["torques"] if len(result["torques"]) > 1 else []:
        if torque["without"]:
            out = {
                run["line"]
                for run in result["runs"]
                if abs(run["torque"] - torque["torque"]) < 1e-9
            }
            left = "".join(
                row
                for i, row in enumerate(text.splitlines(keepends=True), 1)
                if i not in out
            )
            words = f"without {1e3 * torque['torque']:.0f} mN m"
            yield Told(words, left, torque["without"]["u"], torque["without"]["value"])
    for one in document["diagnostics"]:
        say = r"^(\w+) .*I_zz = \(.*\)e(-?\d+) .* as [\d.]+ it would be ([\d.]+) ± ([\d.]+)"
        if found := re.search(say, one["message"]):
            finer = edited(
                text,
                found[1],
                lambda cell, line: f"{cell}0" if "." in cell else f"{cell}.0",
            )
            value, u, last = (
                float(f"{number}e{found[2]}")
                for number in (found[3], found[4], "0.005")
            )
            yield Told("one more digit", finer, u, value, last)
    for advice in result["advice"]:
        if found := re.search(
            r"^(time three times|a balance test).* to (\d+\.?(\d*)) %", advice
        ):
            changed = stated(text, "# balance_drift: 5 deg in 60 s at 400 rpm")
            if found[1].startswith("time"):
                left, b = (
                    {run["line"]: run["residual"] for run in result["runs"]},
                    result["timing_bias"]["value"],
                )
                # The same errors as before, in times three times as long.
                add = {line: 2 * (b + residual) for line, residual in left.items()}
                changed = times(
                    text, lambda value, line, add=add: 3 * value - add[line]
                )  # type: ignore[misc]
                changed = edited(
                    changed,
                    "turns",
                    lambda cell, line: f"{float(3 * Fraction(cell)):.12g}",
                )
            yield Told(
                found[1],
                changed,
                float(found[2]) / 100,
                None,
                0.005 * 10.0 ** -len(found[3]),
            )


def off(
    one: Told, analyze: Callable[[bytes], gyrodata.Analysis] = gyrodata.analyze
) -> tuple[float, float]:
    """Analyse the changed file: how far the report's value is off in u, and its u over
    the right one, minus 1.
    """
    try:
        right = analyze(one.text.encode()).inertia
    except gyrodata.GyroError:
        return math.inf, math.inf
    u = (right.u or 0.0) / (right.value if one.value is None else 1.0)
    far = (
        0.0
        if one.value is None
        else max(0.0, abs(one.value - right.value) - one.half) / u
    )
    return far, max(0.0, abs(one.u / u - 1) - one.half / u) * (1 if one.u > u else -1)


def gate(accept: bool = False, part: bool = False) -> Found:
    """Make all changes, or four in one log."""
    known, pairs, lines = every_log(), 0, []
    logs = {name: known[name].data.decode() for name in KNOWN}
    logs |= {name: typed(bench, 3).decode() for name, bench in DRAWN.items()}
    logs["whole centimetres"] = logs["nine runs"].replace(",15.0,", ",15,")
    for name, text in list(logs.items())[: 1 if part else None]:
        document = gyrodata.analyze(text.encode(), name="log.csv").to_dict()
        for one in islice(told(text, document), 4 if part else None):
            far, wide = off(one)
            pairs += 1
            if far > 0.03 or abs(wide) > 0.03:
                lines.append(
                    f"{name}, {one.change}: 0.03 u, 3 % | off by {far:.2f} u, u by "
                    f"{100 * wide:+.0f} %"
                )
    return Found(
        f"{pairs - len(lines)} of {pairs} changes agree with the changed file",
        "all do",
        not lines,
        lines,
    )
