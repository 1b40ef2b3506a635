"""Gate 1: every log in the repository has the same outcome, the same first error, the same I_zz and the same u.

`every_log` collects the logs: those of `logs.txt` (layouts, stated errors, published tables, habits, unfinished logs),
the files in `sample_data` and `tests/fuzz/corpus`, the habits of `tests/sheets.py` before and after the remedy, slips of
unit and column, and the example of each diagnostic code. `texts.csv` contains a thousand headers, cells, lines and
options, each put into the same log. A reader that is rebuilt must read all of them as before, or this gate shows which
not. The answers are in `logs.csv` and `texts.csv`.
"""

from __future__ import annotations

import json
import shlex
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from sheets import HABITS, source
from sheets import lab as sheet
from typer.testing import CliRunner

import gyrodata
from gates.labs import Bench, draw, write
from gates.stored import HERE, ROOT, Found, compare, line_of, read
from gyrodata.cli import app

Given = tuple[bytes, dict[str, str], dict[str, str]]
"""A log, and what is given with --set and --map."""

SLIPS = (
    ("mass [g]", 1, "mass [kg]"), ("mass [g]", 1e-3, "mass [g]"), ("mass [g]", 1 / 28.3495, "mass [g]"),
    ("position [cm]", 1, "position [m]"), ("position [cm]", 1, "position [mm]"), ("position [cm]", 10, "position [cm]"),
    ("position [cm]", 2, "position [cm]"), ("position [cm]", 1 / 2.54, "position [cm]"), ("spin [rpm]", 1, "spin [Hz]"),
    ("spin [rpm]", 1, "spin [rad/s]"), ("spin [rpm]", 0.10472, "spin [rpm]"), ("spin [rpm]", 1 / 60, "spin [rpm]"),
    ("spin [rpm]", 2, "spin [rpm]"), ("time [s]", 1 / 60, "time [s]"), ("time [s]", 1e3, "time [s]"),
    ("time [s]", 1, "time [min]"), ("time [s]", 1, "spin [rpm]"), ("turns", 3, "turns"), ("turns", 360, "turns"),
)  # fmt: skip
"""Column, the factor on its numbers, and the header that is written over it."""


def every_log() -> dict[str, Given]:
    """Collect the logs by name."""
    logs: dict[str, Given] = {}
    for head, text in read("logs.txt").items():
        name, _, options = head.partition(" --")
        logs[name] = text.replace("⇥", "\t").encode(), *given(f"--{options}" if options else "")
    for path in sorted([*ROOT.glob("sample_data/**/*.csv"), *ROOT.glob("tests/fuzz/corpus/*.csv")]):
        if path.parent.name != "air_gyroscope-report":
            logs[f"{path.parent.name}/{path.name}"] = path.read_bytes(), {}, {}
    for number, habit in enumerate(HABITS):
        typed = source(habit.make(sheet(number, habit.turns, habit.unloaded)))
        logs[habit.name] = typed, {}, {}
        if habit.asked:
            mended = typed.decode().replace(*habit.edit).encode() if habit.edit else typed
            logs[f"{habit.name}, after the remedy"] = mended, dict(habit.settings), dict(habit.mapping)
    logs.update(slips())
    codes = json.loads(CliRunner().invoke(app, ["schema", "--diagnostics", "--json"]).stdout)["diagnostics"]
    for record in codes:
        code, example = record["code"], record["example"]
        if example.startswith("analyze log.csv --set") or example.startswith("analyze log.csv --map"):
            logs[code] = usual("turns", "1/3"), *given(example.removeprefix("analyze log.csv "))
        elif "\n" in example and code < "G5":
            logs[code] = example.encode("latin-1" if code in ("G107", "G109") else "utf-8"), {}, {}
    return logs


def slips() -> Iterator[tuple[str, Given]]:
    """Make the same lab with one column in another unit, and a ball in the log that tells."""
    good = write(draw(Bench(), 5), "# ball_mass: 4.31 kg\n# ball_diameter: 10.16 cm\n").splitlines()
    heads, rows = good[3].split(","), [row.split(",") for row in good[4:]]
    for column, factor, header in SLIPS:
        at = heads.index(column)
        changed = [[*row[:at], f"{float(row[at]) * factor:.6g}", *row[at + 1 :]] for row in rows]
        head = [header if one == column else column if one == header else one for one in heads]
        text = "\n".join([*good[:3], *(",".join(row) for row in [head, *changed])]) + "\n"
        yield f"slip: {column} x {factor:.6g} as {header}", (text.encode(), {}, {})


def given(options: str) -> tuple[dict[str, str], dict[str, str]]:
    """Read --set and --map."""
    found: dict[str, dict[str, str]] = {"--set": {}, "--map": {}}
    words = shlex.split(options)
    for option, value in zip(words[::2], words[1::2], strict=True):
        key, _, text = value.partition("=")
        found[option][key] = text
    return found["--set"], found["--map"]


ROLES = ("mass", "position", "spin", "time", "turns")


def usual(place: str, text: str) -> bytes:
    """Put a text into a log of three runs: into the second run, into the header, or as a line above."""
    head = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]
    rows = [["20.1", "14.8", "212", "6.95", "1/3"], ["40.3", "14.8", "398", "6.71", "1/3"],
            ["60.2", "14.8", "604", "20.12", "1"]]  # fmt: skip
    if place in ROLES:
        rows[1][ROLES.index(place)] = text
    elif place.startswith("header "):
        head[ROLES.index(place.removeprefix("header "))] = text
    above = f"{text}\n" if place == "line" else ""
    return (above + "".join(";".join(row) + "\n" for row in [head, *rows])).encode()


def text_log(key: str) -> Given:
    """Make the log of a row of `texts.csv`, whose key is "place: text"."""
    place, _, text = key.partition(": ")
    if place in ("set", "map"):
        name, _, value = text.partition("=")
        one, none = {name: value}, {}
        return usual("", ""), one if place == "set" else none, one if place == "map" else none
    return usual(place, text.replace("⇥", "\t")), {}, {}


HEAD = "log,outcome,code,I_zz,u"


def outcome(log: Given) -> str:
    """Analyse a log: answer, warned, refused (an error in the log) or unreadable; the first error or warning; I_zz; u."""
    data, settings, mapping = log
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            analysis = gyrodata.analyze(data, name="log.csv", settings=settings, mapping=mapping)
    except gyrodata.GyroError as error:
        word = "refused" if isinstance(error, gyrodata.LogError) else "unreadable"
        return line_of([word, next(d.code for d in error.diagnostics if d.severity == "error"), "", ""])
    except Exception as error:  # a fault of the tool: a row that nobody should accept
        return line_of(["FAULT", type(error).__name__, "", ""])
    code = next((d.code for d in analysis.diagnostics if d.severity == "warning"), "")
    return line_of(["warned" if code else "answer", code, f"{analysis.inertia.value:.8g}", f"{analysis.inertia.u:.8g}"])


def gate(accept: bool = False, part: bool = False) -> Found:
    """Analyse all of them, or one in eight."""
    logs, texts = every_log(), {key: text_log(key) for key in read("texts.csv")}
    step = 8 if part else 1
    chosen = {name: logs[name] for name in list(logs)[::step]}
    keys = list(texts)[::step]
    everything = [*chosen.values(), *(texts[key] for key in keys)]
    if part:
        answers = [outcome(log) for log in everything]
    else:
        with ProcessPoolExecutor(2) as pool:
            answers = list(pool.map(outcome, everything, chunksize=20))
    of_logs = dict(zip(chosen, answers, strict=False))
    of_texts = dict(zip(keys, answers[len(chosen) :], strict=True))
    same = partial(compare, accept=accept, part=part, head=HEAD)
    lines = same("logs.csv", of_logs) + same("texts.csv", of_texts)
    faults = sum(answer.startswith("FAULT") for answer in answers)
    measured = (
        f"{len(of_logs)} logs and {len(of_texts)} texts: {len(lines)} differ, {faults} end in a fault of the tool"
    )
    return Found(measured, "none differs", not lines, lines)
