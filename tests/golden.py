"""Golden text: words to the letter, numbers as far as a processor and a release of numpy leave them alone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby
from typing import Any

import pytest
from sheets import HABITS, lab, source

from gyrodata.diagnostics import CODES
from gyrodata.errors import GyroError
from gyrodata.readings import Reading, read_log
from gyrodata.units import Uncertainty

NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Steady:
    """A text that equals another of the same words and the same numbers, to ten digits; figures by their names."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "FIGURE", text)
        self.words, self.numbers = NUMBER.sub("№", text), [float(number) for number in NUMBER.findall(text)]

    def __eq__(self, other: object) -> bool:
        # What is left where two numbers cancel has fewer digits.
        return (
            isinstance(other, Steady)
            and self.words == other.words
            and other.numbers == pytest.approx(self.numbers, rel=2e-10, abs=1e-12)
        )

    def __repr__(self) -> str:
        numbers = iter(self.numbers)
        return re.sub("№", lambda _: f"{next(numbers):.10g}", self.words)


def numbers(node: Any, place: str = "") -> dict[str, float]:
    """Every number of a JSON by its place, with the digits that no processor changes."""
    if isinstance(node, dict):
        parts = node.items()
    elif isinstance(node, list):
        parts = enumerate(node)
    else:
        return {place: float(f"{node:.8g}")} if isinstance(node, float) else {}
    return {at: value for key, part in parts for at, value in numbers(part, f"{place}.{key}".lstrip(".")).items()}


def every_log_as_read() -> str:
    """Tell what is read of every log that a student may type, and of the example of each diagnostic."""
    logs: dict[str, tuple[bytes, dict[str, Any]]] = {}
    for number, habit in enumerate(HABITS):
        typed = source(habit.make(lab(number, habit.turns, habit.unloaded)))
        logs[habit.name] = typed, {"settings": habit.settings, "mapping": habit.mapping}
        if habit.asked:
            logs[f"{habit.name}, before it is asked about"] = typed, {}
    for code, known in CODES.items():
        if code[1] in "1235" and not known.example.startswith(("analyze ", "template ")):
            logs[code] = known.example.encode("latin-1" if code in ("G107", "G109") else "utf-8"), {}
    return "".join(f"{name}\n" + "".join(as_read(log, **given)) for name, (log, given) in logs.items())


def as_read(log: bytes, longest: int = 300, **given: Any) -> Iterator[str]:
    """Tell all that is read of a log, a line a thing: what is said of it, its runs, its columns, what holds for all."""
    try:
        readings = read_log(log, **given)
        said = readings.diagnostics
    except GyroError as error:
        readings, said = None, error.diagnostics
    yield from (f"  {d.code} {d.line}:{d.column}+{d.width} {d.message[:longest]} | {d.hint[:longest]}\n" for d in said)
    if readings is None:
        return
    yield f"  runs {' '.join(readings.runs)}, lines {' '.join(map(str, readings.lines))}\n"
    yield from (f"  note {note}\n" for note in readings.notes if note)
    for column in (*readings.columns.values(), *readings.others):
        places = [place for run in (0, -1) if column.spots and (place := column.place(run))]
        at = " to ".join(f"{place.line}:{place.column}" for place in places)
        cells = " ".join(f"{cell}x{len(list(same))}" for cell, same in groupby(map(_cell, column.readings)))
        yield f'  {column.role} "{column.header}" [{column.unit}] {at} {cells}\n'.replace("x1 ", " ")
    sizes = {key: _size(u) for key, u in readings.uncertainties.items()}
    reported = {key: f"{one.value} ± {one.u} {one.fault}" for key, one in readings.reported.items()}
    rest = {key: getattr(readings, key) for key in ("balance_tilt", "balance_drift", "motion", "balanced", "origin_u")}
    for key, value in {**readings.constants, **readings.metadata, **sizes, **reported, **rest}.items():
        if value not in (None, 0.0):
            yield f"  {key}: {value}\n"


def _cell(read: Reading) -> str:
    value = "-" if read.value is None else f"{read.value:.9g}"
    return value + (f"~{read.step:.3g}" if read.step else "") + (f"±{_size(read.u)}" if read.u else "")


def _size(u: Uncertainty) -> str:
    return f"{u.absolute:.6g}|{u.relative:.6g}"
