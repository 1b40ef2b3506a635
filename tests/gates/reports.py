"""Gates 2 and 3: what `gyro analyze` says of a log, as JSON to 8 digits and as it is printed.

`numbers.txt` contains the numbers of 30 logs that matter: I_zz, M0, b, goodness, fits, budget, effects, sensitivity,
torques, power laws, codes and places of diagnostics, advice. `printed.txt` contains what ``gyro analyze -v`` and ``gyro
check`` print for eight logs. A short digest of each section is stored for Markdown and LaTeX: their numbers are those
of the JSON, and their words those of the text.
"""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from functools import reduce
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

import gyrodata
from gates.labs import Bench, typed
from gates.logs import Log, every_log
from gates.stored import Found, compare
from gyrodata.cli import app

KNOWN = (
    "sample_data/air_gyroscope.csv", "sample_data/heidelberg_ball.csv", "sample_data/salort_one_torque.csv",
    "class/adlernina_101_9001_lab.csv", "contradicting", "falling", "few", "followed", "forces", "odd", "rates",
    "released", "tilted", "unloaded", "half way", "published: stacked timings with merged cells",
    "published: one torque with an uncertainty in each row", "en: xlsx, one table a weight",
    "turns became dates, d-mmm", "corpus/three-weights-in-turn.csv",
    "corpus/released-half-a-turn-of-nutation.csv", "slip: time [s] x 0.0166667 as time [s]",
)  # fmt: skip
DRAWN = {
    "27 runs": Bench(repeats=3, lines="# u_time: 0.14 s\n"), "thirds": Bench(thirds=True),
    "one torque, balanced": Bench(masses=(40,), lines="# balanced: yes\n"),
    "balance test": Bench(lines="# balance_drift: 5 deg in 60 s at 400 rpm\n"), "hand 0.5 s": Bench(hand=0.5),
    "M0 20 %": Bench(imbalance=0.2), "tilted by 30 deg": Bench(pitch=30.0),
    "two runs": Bench(masses=(20, 60), spins=(400,)),
}  # fmt: skip
PARTS = {
    "inertia": "value u interval_95", "residual_torque": "value u", "timing_bias": "value u", "goodness": "chi2 dof p",
    "fits": "name inertia.value constant.value", "budget": "source share", "effects": "effect bias kept",
    "sensitivity": "name inertia.value inertia.u", "torques": "torque product.value product.u",
    "power_law": "torque exponent u", "model": "", "advice": "", "doubts": "kind",
}  # fmt: skip
"""What is kept of each part of the result."""


def kept(part: Any, fields: str) -> Any:
    """Keep some fields of a record, or of each of a list, with eight digits; zero but for rounding is 0."""
    if isinstance(part, list):
        return [kept(one, fields) for one in part]
    if isinstance(part, float):
        return 0.0 if abs(part) < 1e-13 else float(f"{part:.8g}")
    if not fields or not isinstance(part, dict):
        return part
    return [kept(reduce(lambda one, key: one and one[key], field.split("."), part), "") for field in fields.split()]


def numbers(log: Log) -> str:
    """Analyse a log, and keep what matters, a line for each part."""
    try:
        document = log.analyze().to_dict()
    except gyrodata.GyroError as error:
        return f"refused: {' '.join(found.code for found in error.diagnostics)}\n"
    lines = {name: kept(document["result"][name], fields) for name, fields in PARTS.items()}
    lines["diagnostics"] = [[one["code"], one["line"], one["column"]] for one in document["diagnostics"]]
    return "".join(f"{name}: {json.dumps(value, separators=(',', ':'))}\n" for name, value in lines.items())


def gate_json(accept: bool = False, part: bool = False) -> Found:
    """Compare the JSON of thirty logs."""
    known = every_log()
    logs = {**{name: known[name] for name in KNOWN}, **{name: Log(typed(bench, 1)) for name, bench in DRAWN.items()}}
    lines = compare("numbers.txt", {name: numbers(log) for name, log in logs.items()}, accept)
    return Found(f"JSON of {len(logs)} logs: {len(lines)} lines differ", "none differs", not lines, lines)


SHOWN = ("sample_data/air_gyroscope.csv", "sample_data/heidelberg_ball.csv", "sample_data/salort_one_torque.csv",
         "tilted", "released", "odd", "rates", "half way")  # fmt: skip
COMMANDS = {
    "text": "analyze -v --no-report --format text", "check": "check", "markdown": "analyze --format markdown",
    "latex": "analyze --format latex", "csv": "analyze --format csv",
}  # fmt: skip


def gate_printed(accept: bool = False, part: bool = False) -> Found:
    """Compare text, Markdown, LaTeX and the words of ``gyro check`` for eight logs, or for two; CSV for the sample."""
    known, table = every_log(), {}
    with tempfile.TemporaryDirectory() as folder:
        for name in SHOWN[: 2 if part else None]:
            path = Path(folder) / "log.csv"
            path.write_bytes(known[name].data)
            for form, command in list(COMMANDS.items())[: None if name == SHOWN[0] else -1]:
                done = CliRunner().invoke(app, [*command.split(), str(path)], prog_name="gyro")
                text = done.output.replace(f"{folder}/", "").replace(gyrodata.__version__, "VERSION")
                text = f"exit code {done.exit_code}\n{text.strip()}\n"
                if form in ("markdown", "latex"):
                    sections = re.split(r"^(?=## |\\(?:sub)?section)", text, flags=re.MULTILINE)
                    digests = {one: hashlib.sha256(one.encode()).hexdigest()[:8] for one in sections}
                    text = "".join(f"{digests[one]} {one.splitlines()[0][:40]}\n" for one in sections)
                table[f"{name}, {form}"] = text
    lines = compare("printed.txt", table, accept, part)
    return Found(f"{len(table)} outputs of commands: {len(lines)} places differ", "none differs", not lines, lines)
