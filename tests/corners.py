"""What the reader makes of texts by the hundred, each beside its answer, in `expected/corners.txt`.

A block begins with ``== KIND``. Of most kinds each line is a text and, behind the arrow, what is read of it; of a log
the lines with a bar are its text, and those below are what is read and what is written of it, or what was measured.
``⇥`` is a tab.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from golden import as_read

from gyrodata.errors import GyroError
from gyrodata.measurements import measure
from gyrodata.quantities import Quantity, parse_uncertainty, read_quantity
from gyrodata.readings import (
    CellError,
    blank_log,
    check_value,
    find_inertia,
    parse_header,
    read_cell,
    read_log,
    read_reported,
    rounded_turns,
    stated_turns,
    write_log,
)
from gyrodata.units import Uncertainty, UnitError

CORNERS = Path(__file__).parent / "expected" / "corners.txt"
ARROW = " → "
HEADERS = {"mass": "mass [g]", "position": "position [cm]", "spin": "spin [rpm]", "time": "time [s]", "turns": "turns"}
ROWS = [
    {"mass": "20.1", "position": "14.8", "spin": "212", "time": "6.95", "turns": "1/3"},
    {"mass": "40.3", "position": "14.8", "spin": "398", "time": "6.71", "turns": "1/3"},
    {"mass": "60.2", "position": "14.8", "spin": "604", "time": "20.12", "turns": "1"},
]


def log(headers: dict[str, str], cells: dict[str, str], above: str = "") -> bytes:
    """The usual log, with other headers, other cells in its second row, and lines above."""
    rows = [{**ROWS[0]}, {**ROWS[1], **cells}, {**ROWS[2]}]
    table = [[headers.get(role, header) for role, header in HEADERS.items()], *([*row.values()] for row in rows)]
    return (above + "".join(";".join(row) + "\n" for row in table)).encode()


def in_log(source: bytes, above: str = "", **given: dict[str, str]) -> str:
    """What is read otherwise than of the usual log."""
    usual = set(as_read(log({}, {}, above)))
    return " ¦ ".join(line.strip().replace("\n", " ⏎ ") for line in as_read(source, **given) if line not in usual)


def in_column(role: str, text: str) -> str:
    return in_log(log({}, {role: text}))


def as_header(role: str, text: str) -> str:
    return in_log(log({role: text}, {}))


def as_option(option: str, text: str) -> str:
    key, _, value = text.partition("=")
    return in_log(log({}, {}), **{option: {key: value}})


def header(_: str, text: str) -> str:
    found = parse_header(text)
    number = "" if found.number is None else f" no. {found.number}"
    spread = f" ±{found.spread}" if found.spread else ""
    return f"{'/'.join(found.roles) or '-'} [{found.unit}]{spread}{number} {stated_turns(text)}".rstrip()


def size(u: Uncertainty | None) -> str:
    return "" if u is None else f" ±{u.absolute:.9g}|{u.relative:.9g}"


def read_as(read: Quantity) -> str:
    step = "" if read.step is None else f" ~{read.step:.6g}"
    return f"{read.value:.9g}{step} [{read.unit}]{size(read.uncertainty)}"


def cell(given: str, text: str) -> str:
    kind, unit, ask = (*given.split(" "), "", "")[:3]
    try:
        read = read_cell(text, kind, unit.strip("-") or (None if unit != "-" else ""), bool(ask))
    except CellError as error:
        return f"{error.code} {error} | {error.hint}"
    return read_as(read)


def quantity(given: str, text: str) -> str:
    kind, _, unit = given.partition(" ")
    try:
        read = read_quantity(text, kind, unit or None)
    except UnitError as error:
        return f"{error.reason}: {error} | {error.hint}"
    return read_as(read)


def uncertainty(given: str, text: str) -> str:
    kind, _, unit = given.partition(" ")
    try:
        return size(parse_uncertainty(text, kind, unit)).strip()
    except UnitError as error:
        return f"{error.reason}: {error} | {error.hint}"


def reported(key: str, text: str) -> str:
    read = read_reported(key, text)
    value = "-" if read.value is None else f"{read.value:.9g}"
    u = "-" if read.u is None else f"{read.u:.9g}"
    steps = " ".join("-" if step is None else f"{step:.3g}" for step in (read.step, read.u_step))
    whole = f"{value} ± {u} ({read.number} {read.unit}; digits {read.digits} {read.u_digits}; steps {steps})"
    return whole + (f" {read.fault}: {read.problem}" if read.fault or read.problem else "")


def possible(role: str, text: str) -> str:
    return " | ".join(check_value(role, float(text)))


TELLERS: dict[str, Callable[[str, str], str]] = {
    "header": header,
    "cell": cell,
    "quantity": quantity,
    "uncertainty": uncertainty,
    "reported": reported,
    "possible": possible,
    "answer": lambda _, text: find_inertia(text),
    "rounded": lambda _, text: "{} {:.6g}".format(*rounded_turns(text)),
    "in column": in_column,
    "as header": as_header,
    "with line": lambda _, text: in_log(log({}, {}, text + "\n"), "#\n"),
    "with option": as_option,
}


def blocks(text: str) -> list[tuple[str, list[str]]]:
    """The head of each block, and its lines."""
    parts = re.split(r"^== (.*)\n", text, flags=re.MULTILINE)[1:]
    return [(head, body.splitlines()) for head, body in zip(parts[::2], parts[1::2], strict=True)]


def told(head: str, lines: list[str]) -> Iterator[str]:
    """A block as it should stand in the file."""
    yield f"== {head}"
    if head.startswith("template"):
        yield from template_told(*re.split("; ?", head.partition(": ")[2]))
    elif head.startswith(("log", "measured")):
        typed = [line for line in lines if line.startswith("|")]
        yield from typed
        text = "".join(line[1:] + "\n" for line in typed).replace("⇥", "\t")
        yield from (log_told if head.startswith("log") else measured_told)(text.encode(), options(head))
    else:
        kind, _, given = head.partition(": ")
        for line in lines:
            text = line.partition(ARROW)[0].removesuffix(ARROW.rstrip())
            yield f"{text}{ARROW}{TELLERS[kind](given, text.replace('⇥', chr(9)))}".rstrip() if text else ""
    yield ""


def options(head: str) -> dict[str, dict[str, str]]:
    """What stands behind the name of a log: --set and --map."""
    found: dict[str, dict[str, str]] = {"settings": {}, "mapping": {}}
    words = shlex.split(head.partition(" --")[2] and "--" + head.partition(" --")[2])
    for option, value in zip(words[::2], words[1::2], strict=True):
        key, _, text = value.partition("=")
        found[{"--set": "settings", "--map": "mapping"}[option]][key] = text
    return found


def log_told(text: bytes, given: dict[str, dict[str, str]]) -> Iterator[str]:
    """All that is read of a log, where each of its cells stands, and how it is written."""
    yield from (line.rstrip().replace("\n", " ⏎ ") for line in as_read(text, 2000, **given))
    try:
        readings = read_log(text, **given)
    except GyroError:
        return
    for column in (*readings.columns.values(), *readings.others):
        places = [column.place(run) for run in range(len(readings.runs))]
        at = " ".join("-" if place is None else f"{place.line}:{place.column}" for place in places)
        yield f"  {column.role} at {at}".rstrip()
    if readings.ok:
        yield from (f"  > {line}" for line in write_log(readings).splitlines())


def template_told(weights: str, position: str, spins: str) -> Iterator[str]:
    """A log to fill in, or why there is none."""
    try:
        blank = blank_log(weights.split(", ") if weights else [], position, spins.split(", ") if spins else [])
    except GyroError as error:
        blank = "".join(f"{d.code} {d.message} | {d.hint}\n" for d in error.diagnostics)
    yield from (f"  > {line}".rstrip() for line in blank.removesuffix("\n").split("\n"))


def measured_told(text: bytes, given: dict[str, dict[str, str]]) -> Iterator[str]:
    """All that was measured in a log, every source of its errors, and what is said of them."""
    m = measure(read_log(text, **given))
    for name in (*m.__struct_fields__, "product", "own_relative", "time_u", "by_torque"):
        value = getattr(m, name)
        if name in ("sources", "diagnostics") or value is None:
            continue
        if name == "imbalance_u":
            value = np.array([value(1.0), value(0.005)])
        if not isinstance(value, np.ndarray) or not np.isnan(value).all():
            yield f"  {name} {numbers_of(value)}"
    for s in m.sources:
        yield f"  {s.name} of {s.quantity}: {s.described}; {s.shared_by or 'each its own'}, {s.shared_count} shared"
        yield f"    {s.groups.tolist()} {numbers_of(s.absolute)} {numbers_of(s.relative)}"
    yield from (f"  {d.code} {d.line}:{d.column}+{d.width} {d.message} | {d.hint}" for d in m.diagnostics)


def numbers_of(value: object) -> str:
    """Numbers with the digits that no processor changes."""
    if isinstance(value, np.ndarray):
        return " ".join(f"{number + 0.0:.7g}" for number in value.tolist())
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def whole(text: str) -> str:
    """The file with every answer anew."""
    return "".join("\n".join(told(head, lines)).rstrip() + "\n\n" for head, lines in blocks(text))
