"""Gate 1: every log in the repository has the same outcome, the same first code, the
same I_zz and the same u.

The logs are those of `logs.txt` (layouts, stated errors, published tables, habits,
unfinished logs), the files in `sample_data` and `tests/acceptance/fuzz/corpus`, the
habits of `tests/support/sheets.py` before and after the remedy, slips of unit and
column, and the example of each diagnostic code. `texts.csv` contains a thousand
headers, cells, lines and options, each put into the same log. A reader that is rebuilt
must read all of them as before, or this gate shows which not. The answers are in
`logs.csv` and `texts.csv`, with a digest of all that is said of each log."""

from __future__ import annotations

import shlex
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from typing import NamedTuple

import sheets
from places import ROOT

import gyrodata
from gates import stored
from gates.drawn_logs import Bench, draw, write
from gates.stored import Found, line_of
from gyrodata.base.diagnostics import explanations

MASS, POSITION, SPIN, TIME, TURNS = (
    "mass [g]",
    "position [cm]",
    "spin [rpm]",
    "time [s]",
    "turns",
)
SLIPS = (
    (MASS, 1, "mass [kg]"),
    (MASS, 1e-3, MASS),
    (MASS, 1 / 28.3495, MASS),
    (POSITION, 1, "position [m]"),
    (POSITION, 1, "position [mm]"),
    (POSITION, 10, POSITION),
    (POSITION, 2, POSITION),
    (POSITION, 1 / 2.54, POSITION),
    (SPIN, 1, "spin [Hz]"),
    (SPIN, 1, "spin [rad/s]"),
    (SPIN, 0.10472, SPIN),
    (SPIN, 1 / 60, SPIN),
    (SPIN, 2, SPIN),
    (TIME, 1 / 60, TIME),
    (TIME, 1e3, TIME),
    (TIME, 1, "time [min]"),
    (TIME, 1, SPIN),
    (TURNS, 3, TURNS),
    (TURNS, 360, TURNS),
)
"""Column, the factor on its numbers, and the header that is written over it; SPIN over
TIME exchanges the two."""


class Log(NamedTuple):
    """A log, and what is given with --set and --map."""

    data: bytes
    settings: dict[str, str] | None = None
    mapping: dict[str, str] | None = None

    def analyze(self) -> gyrodata.Analysis:
        return gyrodata.analyze(
            self.data, name="log.csv", settings=self.settings, mapping=self.mapping
        )


def given(data: bytes, options: str) -> Log:
    """Read --set and --map."""
    found: dict[str, dict[str, str]] = {"--set": {}, "--map": {}}
    words = shlex.split(options)
    for option, value in zip(words[::2], words[1::2], strict=True):
        found[option][value.partition("=")[0]] = value.partition("=")[2]
    return Log(data, found["--set"], found["--map"])


@cache
def every_log() -> dict[str, Log]:
    """Collect the logs by name."""
    logs = {}
    for head, text in stored.read("logs.txt").items():
        name, dashes, options = head.partition(" --")
        logs[name] = given(text.replace("⇥", "\t").encode(), dashes + options)
    for path in sorted(
        [
            *ROOT.glob("sample_data/**/*.csv"),
            *ROOT.glob("tests/acceptance/fuzz/corpus/*.csv"),
        ]
    ):
        if path.parent.name != "air_gyroscope-report":
            logs[f"{path.parent.name}/{path.name}"] = Log(path.read_bytes())
    for number, habit in enumerate(sheets.HABITS):
        data = sheets.source(
            habit.make(sheets.lab(number, habit.turns, habit.unloaded))
        )
        logs[habit.name] = Log(data)
        if habit.asked:
            mended = data.decode().replace(*habit.edit).encode() if habit.edit else data
            logs[f"{habit.name}, after the remedy"] = Log(
                mended, dict(habit.settings), dict(habit.mapping)
            )
    good = write(
        draw(Bench(), 5), "# ball_mass: 4.31 kg\n# ball_diameter: 10.16 cm\n"
    ).splitlines()
    for column, factor, header in SLIPS:
        at = good[3].split(",").index(column)
        rows = [row.split(",") for row in good[4:]]
        for row in rows:
            row[at] = f"{float(row[at]) * factor:.6g}"
        head = [
            {column: header, header: column}.get(one, one) for one in good[3].split(",")
        ]
        text = "\n".join([*good[:3], *map(",".join, [head, *rows])]) + "\n"
        logs[f"slip: {column} x {factor:.6g} as {header}"] = Log(text.encode())
    for code, entry in explanations().items():
        example = entry.example
        if example.startswith(("analyze log.csv --set", "analyze log.csv --map")):
            logs[code] = given(
                usual("", "").data, example.removeprefix("analyze log.csv ")
            )
        elif "\n" in example and code < "G5":
            logs[code] = Log(
                example.encode("latin-1" if code in ("G107", "G109") else "utf-8")
            )
    return logs


ROLES = ("mass", "position", "spin", "time", "turns")


def usual(place: str, text: str) -> Log:
    """Put a text into a log of three runs: into the second run, the header, a line
    above, or an option.
    """
    if place in ("set", "map"):
        return given(usual("", "").data, f"--{place} {shlex.quote(text)}")
    text = text.replace("⇥", "\t")
    rows = [
        [MASS, POSITION, SPIN, TIME, TURNS],
        ["20.1", "14.8", "212", "6.95", "1/3"],
        ["40.3", "14.8", "398", "6.71", "1/3"],
        ["60.2", "14.8", "604", "20.12", "1"],
    ]
    if (role := place.removeprefix("header ")) in ROLES:
        rows[2 if role == place else 0][ROLES.index(role)] = text
    above = f"{text}\n" if place == "line" else ""
    return Log((above + "".join(";".join(row) + "\n" for row in rows)).encode())


def outcome(log: Log) -> str:
    """Analyse a log: answer, warned, refused (an error in the log) or unreadable; code;
    I_zz, u; all that is said.

    The last cell is a digest of all diagnostics with their places.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", gyrodata.GyroWarning)
            analysis = log.analyze()
    except gyrodata.GyroError as error:
        word = "refused" if isinstance(error, gyrodata.LogError) else "unreadable"
        code = next(d.code for d in error.diagnostics if d.severity == "error")
        return line_of(word, code, "", "", digest(error.diagnostics))
    except Exception as error:  # a fault of the tool: a row that nobody should accept
        return line_of("FAULT", type(error).__name__, "", "")
    code = next((d.code for d in analysis.diagnostics if d.severity == "warning"), "")
    size = f"{analysis.inertia.value:.7g}", f"{analysis.inertia.u:.4g}"
    return line_of(
        "warned" if code else "answer", code, *size, digest(analysis.diagnostics)
    )


def digest(diagnostics: tuple[gyrodata.Diagnostic, ...]) -> str:
    """Give four letters that differ for nearly every other list of diagnostics."""
    said = "".join(
        f"{one.severity}{one.code}{one.line}:{one.column}{one.message}{one.hint}"
        for one in diagnostics
    )
    return stored.digest(said) if said else ""


def gate(accept: bool = False, part: bool = False) -> Found:
    """Analyse all of them, or one in 300."""
    tables: dict[str, dict[str, Log]] = {"logs.csv": every_log(), "texts.csv": {}}
    tables["texts.csv"] = {
        key: usual(*key.split(": ", 1)) for key in stored.read("texts.csv")
    }
    lines, counts, faults = [], [], 0
    with ProcessPoolExecutor(2) as pool:
        for name, logs in tables.items():
            keys = list(logs)[:: 300 if part else 1]
            answers = list(pool.map(outcome, [logs[key] for key in keys], chunksize=20))
            new = dict(zip(keys, answers, strict=True))
            lines += stored.compare(
                name, new, accept, part, "key,outcome,code,I_zz,u,said"
            )
            counts.append(len(keys))
            faults += sum(answer.startswith("FAULT") for answer in answers)
    measured = (
        f"{counts[0]} logs, {counts[1]} texts: {len(lines)} differ, {faults} end in a "
        f"fault of the tool"
    )
    return Found(measured, "none differs", not lines, lines)
