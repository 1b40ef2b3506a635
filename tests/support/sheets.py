"""Logs as students type them: the habits of typing in `habits.toml`, each laid over a
lab of a known truth.

A habit makes the text of a CSV file, or a workbook, of the runs of a lab. What must
happen to it is beside it: it is read, or it is refused and the remedy is right. Nothing
is stored; every log is made anew."""

from __future__ import annotations

import csv
import datetime
import io
import re
import tomllib
from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from places import DATA

INERTIA = 4.44e-3
IMBALANCE = 0.4e-3
G = 9.803
ARM = 0.148
RADIUS = 0.0508
MASSES, SPINS = ("20.1", "40.3", "60.2"), (212, 398, 604)
HEAD = ["Mass (g)", "Position (cm)", "Spin (rpm)", "Time (s)", "Turns"]


class Run(NamedTuple):
    mass: str
    position: str
    spin: str
    time: str
    turns: str


class Habit(NamedTuple):
    name: str
    text: str = "{head}\n*{row}\n"
    """The template of the log."""
    words: Mapping[str, str] = MappingProxyType({})
    """What is written in place of a cell."""
    change: tuple[str, str] = ("", "")
    """What is written in place of a part of the text."""
    settings: Mapping[str, str] = MappingProxyType({})
    """The remedy: what the message says to give with --set."""
    mapping: Mapping[str, str] = MappingProxyType({})
    """The remedy: what the message says to give with --map."""
    edit: tuple[str, str] | None = None
    """The remedy: what the message says to change in the file."""
    says: str = ""
    """What the message or the note must contain."""
    turns: str = "1/3 1/3 1"
    unloaded: bool = False
    """Whether there is a run without a weight."""
    merges: str = ""
    as_text: bool = False
    language: tuple[str, ...] = (",".join(HEAD), "", "", "", "", ".,")

    @property
    def asked(self) -> bool:
        return bool(self.settings or self.mapping or self.edit)

    def make(self, runs: list[Run]) -> str | bytes:
        text = filled(
            self.text,
            [Run(*(self.words.get(cell, cell) for cell in run)) for run in runs],
            self.language,
        )
        text = text.replace(*self.change) if self.change[0] else text
        if not text.startswith("=== "):
            return text
        parts = re.split(r"(?m)^=== (.*)\n", text)[1:]
        cells = (list(csv.reader(io.StringIO(part))) for part in parts[1::2])
        sheets = dict(zip(parts[::2], cells, strict=True))
        return workbook(sheets, *self.merges.split(), as_text=self.as_text)


def lab(seed: int, turns: str = "1/3 1/3 1", unloaded: bool = False) -> list[Run]:
    """Draw one lab as it is read off: three weights with three spins, timed by hand."""
    random = np.random.default_rng(7000 + seed)
    runs = []
    for mass, count in zip(MASSES, turns.split(), strict=True):
        for spin in SPINS:
            torque = float(mass) / 1000 * G * ARM + IMBALANCE
            exact = (
                2
                * np.pi
                * float(Fraction(count))
                * INERTIA
                * spin
                * np.pi
                / 30
                / torque
            )
            runs.append(
                Run(
                    mass,
                    "14.8",
                    str(spin),
                    f"{exact + 0.14 * random.standard_normal():.2f}",
                    count,
                )
            )
    if unloaded:
        exact = 2 * np.pi / 12 * INERTIA * 398 * np.pi / 30 / IMBALANCE
        runs.append(Run("0", "", "398", f"{exact:.2f}", "1/12"))
    return runs


def source(made: str | bytes) -> bytes:
    return made if isinstance(made, bytes) else made.encode()


def filled(template: str, runs: list[Run], language: tuple[str, ...]) -> str:
    """Write the lines of a template; one with a * for each run, a part in brackets for
    each weight.
    """
    blocks = [
        [run for run in runs if run.mass == mass]
        for mass in dict.fromkeys(run.mass for run in runs)
    ]
    lines = []
    for at, part in enumerate(re.split(r"(?ms)^\[\n(.*?)^\]\n", template)):
        for i, group in enumerate(blocks if at % 2 else [runs], 1):
            common = of_log(group, language) | {"i": i, "m": group[0].mass}
            for line in part.splitlines():
                if starred := re.match(r"\*(?:(\d*):(\d*) )?(.*)", line):
                    first, last = (
                        int(end) if end else None for end in starred.group(1, 2)
                    )
                    of_runs = [
                        common | of_run(group, k, common["sign"])
                        for k in range(len(group))
                    ][first:last]
                    lines += [starred[3].format_map(values) for values in of_runs]
                else:
                    lines.append(line.format_map(common))
    return "\n".join(lines).replace("⏎", "\n") + "\n"


def of_log(runs: list[Run], language: tuple[str, ...]) -> dict[str, Any]:
    """Give what a template may name of a whole log or of one weight."""
    head, title, average, weight, note, signs = language
    mean = (
        sum(float(run.time) for run in runs) / len(runs)
        if all(run.time for run in runs)
        else 0.0
    )
    heads = {
        f"head{n or ''}": head.split(",", 5 - n)[-1] if n else head for n in (0, 3, 4)
    }
    told = {
        "title": title,
        "average": average,
        "weight": weight,
        "note": note,
        "mean": f"{mean:.3f}",
    }
    return heads | told | {"sign": signs, "local_head": head.replace(",", signs[1])}


def of_run(runs: list[Run], at: int, signs: str) -> dict[str, Any]:
    """Give what a template may name of a run."""
    run = runs[at]
    time, spin = float(run.time), int(run.spin)
    t = [time, time + 0.11, time - 0.09]
    first = [*run] if not at or runs[at - 1].mass != run.mass else [""] * 5
    return run._asdict() | {
        "row": ",".join(run),
        "row4": ",".join(run[1:]),
        "row3": ",".join(run[2:]),
        "row_3": ",".join(sum(runs[at + 3 : at + 4], ())),
        "row_6": ",".join(sum(runs[at + 6 : at + 7], ())),
        "local": signs[1].join(cell.replace(".", signs[0]) for cell in run),
        "mass_once": first[0],
        "position_once": first[1],
        "turns_once": first[4],
        "before": spin + 1,
        "after": spin - 1,
        "ten": f"{600 / spin:.3f}",
        "later": f"{time + 0.1:.2f}",
        "t1": f"{t[0]:.2f}",
        "t2": f"{t[1]:.2f}",
        "t3": f"{t[2]:.2f}",
        "mean_of_2": f"{sum(t[:2]) / 2:.3f}",
        "mean_of_3": f"{sum(t) / 3:.3f}",
        "surface": f"{100 * (ARM - RADIUS):.2f}",
        "tip": f"{25.0 - 100 * ARM:.1f}",
        "period": f"{time / float(Fraction(run.turns)):.2f}"
        if re.fullmatch(r"[\d/]+", run.turns)
        else "",
        "torque": f"{float(run.mass) / 1000 * G * ARM:.4f}"
        if is_plain(run.mass)
        else "",
    }


def is_plain(text: str) -> bool:
    return bool(text) and text.replace(".", "", 1).isdecimal()


def typed(cell: str) -> Any:
    """Give a cell as a workbook contains it: a number, a duration, a date where the
    month comes first, or a text.
    """
    kind, _, value = cell.partition(":")
    if kind == "clock":
        return datetime.timedelta(seconds=float(value))
    if kind == "date":
        return datetime.datetime(2026, *map(int, value.split("/")))
    return (
        (float(cell) if "." in cell else int(cell)) if is_plain(cell) else cell or None
    )


def workbook(
    sheets: dict[str, list[list[str]]], *merges: str, as_text: bool = False
) -> bytes:
    import openpyxl

    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row if as_text else [typed(cell) for cell in row])
        for merge in merges:
            sheet.merge_cells(merge)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


IN_ALL_LANGUAGES = {
    "plain": "{head}\n*{row}\n",
    "decimal sign of the country, BOM": "\ufeff{local_head}\n*{local}\n",
    "xlsx with title, mean and note": (
        "=== Tabelle1\n{title}\n\n{head}\n*{row}\n{average},,,{mean},\n\n{note}\n"
    ),
    "xlsx, one table a weight": (
        "=== Sheet1\n{title}\n[\n{weight} {i}: {m} g\n{head4}\n*{row4}\n\n]\n"
    ),
    "xlsx, one sheet a weight": "[\n=== {m} g\n{head4}\n*{row4}\n]\n",
}
TABLE = tomllib.loads((DATA / "habits_of_typing.toml").read_text(encoding="utf-8"))
LANGUAGES, HEADERS = TABLE.pop("languages"), TABLE.pop("headers")
HABITS = [
    *(
        Habit(f"{code}: {way}", text, language=tuple(words))
        for code, words in LANGUAGES.items()
        for way, text in IN_ALL_LANGUAGES.items()
    ),
    *(
        Habit(
            f"header: {header}",
            f"{','.join(HEAD[:3])},{header}\n*{{mass}},{{position}},{{spin}},{{time}}\n",
            turns=f"{turns} {turns} {turns}",
        )
        for header, turns in HEADERS.items()
    ),
    *(Habit(name, **habit) for name, habit in TABLE.items()),
]
