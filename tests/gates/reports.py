"""Gates 2 and 3: what `gyro analyze` says of a log, as JSON to 8 digits and as it is printed.

`numbers.txt` contains the numbers of 30 logs that matter: I_zz, M0, b, goodness, fits, budget, effects, sensitivity,
torques, power laws, codes and places of diagnostics, advice. `printed.txt` contains what ``gyro analyze -v`` and ``gyro
check`` print for eight logs. Markdown and LaTeX are stored as printed for the sample log; for the others a short digest
of each section is enough, because their numbers are those of the JSON and their words those of the sample.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

import gyrodata
from gates.labs import Bench, typed
from gates.logs import every_log
from gates.stored import Found, Table, compare
from gyrodata.cli import app

STORED = (
    "sample_data/air_gyroscope.csv", "sample_data/heidelberg_ball.csv", "sample_data/salort_one_torque.csv",
    "class/adlernina_101_9001_lab.csv", "contradicting", "falling", "few", "followed", "forces", "odd", "rates",
    "released", "tilted", "unloaded", "half way", "published: stacked timings with merged cells",
    "published: one torque with an uncertainty in each row", "en: xlsx, one table a weight", "turns became dates, d-mmm",
    "corpus/all-uncertainties-zero-both-sides.csv", "corpus/released-half-a-turn-of-nutation.csv",
    "slip: time [s] x 0.0166667 as time [s]",
)  # fmt: skip
DRAWN = {
    "27 runs": Bench(repeats=3, lines="# u_time: 0.14 s\n"),
    "thirds": Bench(thirds=True),
    "one torque, balanced": Bench(masses=(40,), lines="# balanced: yes\n"),
    "balance test": Bench(lines="# balance_drift: 5 deg in 60 s at 400 rpm\n"),
    "hand 0.5 s": Bench(hand=0.5),
    "M0 20 %": Bench(imbalance=0.2),
    "tilted by 30 deg": Bench(pitch=30.0),
    "two runs": Bench(masses=(20, 60), spins=(400,)),
}
"""Design and statements of the other logs."""


def logs() -> dict[str, tuple[bytes, dict[str, str], dict[str, str]]]:
    """Give the thirty logs."""
    known = every_log()
    drawn = {name: (typed(bench, 1), {}, {}) for name, bench in DRAWN.items()}
    return {**{name: known[name] for name in STORED}, **drawn}


PARTS = {
    "inertia": "value u interval_95", "residual_torque": "value u", "timing_bias": "value u",
    "goodness": "chi2 dof p", "fits": "name inertia.value constant.value", "budget": "source share",
    "effects": "effect bias kept", "sensitivity": "name inertia.value inertia.u",
    "torques": "torque product.value product.u", "power_law": "torque exponent u", "model": "", "advice": "",
    "doubts": "kind",
}  # fmt: skip
"""What is kept of each part of the result."""


def kept(part: Any, fields: str) -> Any:
    """Keep some fields of a record, or of each record of a list."""
    if isinstance(part, list):
        return [kept(one, fields) for one in part]
    if not fields or part is None:
        return part
    found = []
    for field in fields.split():
        value = part
        for key in field.split("."):
            value = value and value[key]
        found.append(value)
    return found


def rounded(node: Any) -> Any:
    """Round to eight digits; what is zero but for rounding errors is zero."""
    if isinstance(node, list):
        return [rounded(one) for one in node]
    if not isinstance(node, float):
        return node
    return 0.0 if math.isclose(node, 0.0, abs_tol=1e-13) else float(f"{node:.8g}")


def numbers(log: tuple[bytes, dict[str, str], dict[str, str]]) -> str:
    """Analyse a log, and keep what matters, a line for each part."""
    data, settings, mapping = log
    try:
        document = gyrodata.analyze(data, name="log.csv", settings=settings, mapping=mapping).to_dict()
    except gyrodata.GyroError as error:
        return f"refused: {' '.join(found.code for found in error.diagnostics)}\n"
    lines = {name: rounded(kept(document["result"][name], fields)) for name, fields in PARTS.items()}
    lines["diagnostics"] = [[one["code"], one["line"], one["column"]] for one in document["diagnostics"]]
    return "".join(f"{name}: {json.dumps(value, separators=(',', ':'))}\n" for name, value in lines.items())


def gate_json(accept: bool = False, part: bool = False) -> Found:
    """Compare the JSON of thirty logs."""
    table = {name: numbers(log) for name, log in logs().items()}
    lines = compare("numbers.txt", table, accept)
    return Found(f"JSON of {len(table)} logs: {len(lines)} lines differ", "none differs", not lines, lines)


SHOWN = {
    "sample": "sample_data/air_gyroscope.csv", "heidelberg": "sample_data/heidelberg_ball.csv",
    "salort": "sample_data/salort_one_torque.csv", "tilted": "tilted", "released": "released", "odd": "odd",
    "rates": "rates", "half-way": "half way",
}  # fmt: skip
COMMANDS = {
    "text": "analyze -v --no-report --format text", "check": "check", "csv": "analyze --format csv",
    "markdown": "analyze --format markdown", "latex": "analyze --format latex",
}  # fmt: skip
SECTION = re.compile(r"^(?=## |\\(?:sub)?section)", re.MULTILINE)


def printed(names: list[str]) -> Iterator[tuple[str, str]]:
    """Run the commands, and give what they print by log and format."""
    known = every_log()
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            path = Path(folder) / f"{name}.csv"
            path.write_bytes(known[SHOWN[name]][0])
            for form, command in COMMANDS.items():
                if form == "csv" and name != "sample":
                    continue
                done = CliRunner().invoke(app, [*command.split(), str(path)], prog_name="gyro")
                text = done.output.replace(f"{folder}/", "").replace(gyrodata.__version__, "VERSION")
                text = f"exit code {done.exit_code}\n{text}"
                if form in ("markdown", "latex") and name != "sample":
                    text = "".join(
                        f"{digest(part)} {part.partition(chr(10))[0][:40]}\n" for part in SECTION.split(text)
                    )
                yield f"{name}, {form}", text if text.endswith("\n") else f"{text}\n"


def digest(text: str) -> str:
    """Give eight letters that change with the text."""
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def gate_printed(accept: bool = False, part: bool = False) -> Found:
    """Compare text, CSV, Markdown, LaTeX and the words of ``gyro check`` for eight logs, or for two."""
    table: Table = dict(printed(list(SHOWN)[:2] if part else list(SHOWN)))
    lines = compare("printed.txt", table, accept, part)
    return Found(f"{len(table)} outputs of commands: {len(lines)} places differ", "none differs", not lines, lines)
