"""Gate 9: what a report says of a changed log is what `gyro analyze` says if the file is changed in this way.

A report contains answers to "what would I_zz be if …?": without each weight, the hand 0.1 s late or early, times twice as
uncertain, a balanced ball, one more digit, three times the turns. Here each change is made in the file and the file is analysed: the
value must agree within 0.03 u, and u within 3 %. Not all pairs agree yet: the number of pairs that do may only rise.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import gyrodata
from gates.labs import Bench, typed
from gates.stored import ROOT, Found, at_best, read

LEVEL = ("air_gyroscope", "heidelberg_ball", "nine runs", "27 runs", "thirds", "whole centimetres")
TILTED = ("tilted", "tilted by 30 deg")
RELEASED = ("released", "followed", "let go")


def logs() -> Iterator[tuple[str, str]]:
    """Give the logs by name: level, tilted and released ones."""
    stored = read("logs.txt")
    drawn = {
        "nine runs": Bench(), "27 runs": Bench(repeats=3, lines="# u_time: 0.14 s\n"), "thirds": Bench(thirds=True),
        "whole centimetres": Bench(), "tilted by 30 deg": Bench(pitch=30.0),
    }  # fmt: skip
    for name in (*LEVEL, *TILTED, *RELEASED):
        if name in drawn:
            text = typed(drawn[name], 3).decode()
            yield name, text.replace(",15.0,", ",15,") if name == "whole centimetres" else text
        elif (path := ROOT / "sample_data" / f"{name}.csv").is_file():
            yield name, path.read_text(encoding="utf-8")
        elif name in stored:
            yield name, stored[name]


class Told(NamedTuple):
    """One answer of a report, and the file that it is about."""

    change: str
    value: float | None
    """I_zz [kg*m^2]; None: the report says u only."""
    u: float
    text: str
    step: float = 0.0
    """Half of the last digit that is printed [kg*m^2]."""


def edited(text: str, header: str, change: Callable[[str, int], str]) -> str:
    """Change the cells of a column: `change` takes a cell and the number of its line."""
    lines = text.splitlines()
    top = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    heads = lines[top].split(",")
    at = next(i for i, head in enumerate(heads) if head.startswith(header))
    for i in range(top + 1, len(lines)):
        cells = lines[i].split(",")
        if len(cells) == len(heads):
            cells[at] = change(cells[at], i + 1)
            lines[i] = ",".join(cells)
    return "\n".join(lines) + "\n"


def stated(text: str, line: str) -> str:
    """State something, in place of what the log says of it."""
    key = line.partition(":")[0]
    return f"{line}\n" + "".join(one for one in text.splitlines(keepends=True) if not one.startswith(f"{key}:"))


def without(text: str, lines: set[int]) -> str:
    """Put # before some lines."""
    rows = text.splitlines(keepends=True)
    return "".join(f"# left out {row}" if i in lines else row for i, row in enumerate(rows, 1))


def times(text: str, by: Callable[[float, int], float]) -> str:
    """Change the times."""
    return edited(text, "time", lambda cell, line: f"{by(float(cell), line):.{max(1, len(cell.partition('.')[2]))}f}")


def turned(text: str) -> str:
    """Write three times the turns, in the column or in the line above."""
    if found := re.search(r"^# turns: (.*)$", text, re.MULTILINE):
        return text.replace(found[0], f"# turns: {3 * fraction(found[1]):.12g}")
    return edited(text, "turns", lambda cell, line: f"{3 * fraction(cell):.12g}")


def told(text: str, result: dict[str, Any], diagnostics: list[dict[str, Any]]) -> Iterator[Told]:
    """List the answers of a report that can be made in the file."""
    known = {one["name"]: one["inertia"] for one in result["sensitivity"] if one["inertia"]}
    for name, late in (("hand_late", 0.1), ("hand_early", -0.1)):
        if name in known:
            digits = times(text, lambda value, line, late=late: value - late)
            yield Told(name, known[name]["value"], known[name]["u"], stated(digits, "# u_time_bias: 0 s"))
    if "u_time_twice" in known and (found := re.search(r"^# u_time: ([\d.]+) s$", text, re.MULTILINE)):
        twice = stated(text, f"# u_time: {2 * float(found[1]):g} s")
        yield Told("u_time_twice", known["u_time_twice"]["value"], known["u_time_twice"]["u"], twice)
    if "balanced" in known:
        yield Told("balanced", known["balanced"]["value"], known["balanced"]["u"], stated(text, "# balanced: yes"))
    weights = result["torques"] if len(result["torques"]) > 1 else []
    for torque in weights:
        if torque["without"]:
            lines = {run["line"] for run in result["runs"] if abs(run["torque"] - torque["torque"]) < 1e-9}
            words = f"without {1e3 * torque['torque']:.0f} mN m"
            yield Told(words, torque["without"]["value"], torque["without"]["u"], without(text, lines))
    for one in diagnostics:
        found = re.search(r"^(\w+) .* as ([\d.]+) it would be ([\d.]+) ± ([\d.]+)", one["message"])
        if power := re.search(r"I_zz = \([^)]*\)e(-?\d+)", one["message"]) if found else None:
            scale = 10.0 ** int(power[1])
            finer = edited(text, found[1], lambda cell, line: f"{cell}0" if "." in cell else f"{cell}.0")
            yield Told("one more digit", float(found[3]) * scale, float(found[4]) * scale, finer, 0.005 * scale)
    for advice in result["advice"]:
        if found := re.search(r"^three times the turns.* to ([\d.]+) %", advice):
            b, left = result["timing_bias"]["value"], {run["line"]: run["residual"] for run in result["runs"]}
            # The same errors as before, in times three times as long.
            longer = times(text, lambda value, line: 3 * (value - left[line] - b) + b + left[line])
            longer = turned(longer)
            yield Told("three times the turns", None, float(found[1]) / 100, longer, half(found[1]) / 100)


def half(text: str) -> float:
    """Give half of the last digit of a number."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def fraction(text: str) -> float:
    """Read 1/3."""
    top, _, bottom = text.partition("/")
    return float(top) / float(bottom or 1)


def off(one: Told, name: str) -> tuple[float, float]:
    """Analyse the changed file: how far the report's value is off in u, and its u over the right one, minus 1."""
    inertia = gyrodata.analyze(one.text.encode(), name=name).inertia
    u = inertia.u if one.value is not None else inertia.u / inertia.value
    far = 0.0 if one.value is None else max(0.0, abs(one.value - inertia.value) - one.step) / inertia.u
    return far, max(0.0, abs(one.u / u - 1) - one.step / u) * (1 if one.u > u else -1)


def gate(accept: bool = False, part: bool = False) -> Found:
    """Make all changes, or those of the first log."""
    pairs, good, lines = 0, 0, []
    for name, text in list(logs())[: 1 if part else None]:
        analysis = gyrodata.analyze(text.encode(), name="log.csv").to_dict()
        for one in told(text, analysis["result"], analysis["diagnostics"]):
            pairs += 1
            try:
                far, wide = off(one, "log.csv")
            except gyrodata.GyroError as error:
                lines.append(f"{name}, {one.change}: a value | refused: {error.diagnostics[0].code}")
                continue
            if far <= 0.03 and abs(wide) <= 0.03:
                good += 1
            else:
                lines.append(f"{name}, {one.change}: 0.03 u, 3 % | {far:.2f} u, u {100 * wide:+.0f} %")
    measured = f"{good} of {pairs} changes agree with the changed file"
    if part:
        return Found(measured, "", True, lines)
    return at_best("what-if: changes that agree", good, measured, accept, lines)
