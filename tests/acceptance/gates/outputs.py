"""Gates 2 and 3: what `gyro analyze` says of a log, as JSON to 8 digits and as it is
printed.

`numbers.txt` contains the numbers of 30 logs that matter: I_zz, M0, b, goodness, fits,
budget, effects, sensitivity, torques, power laws, codes and places of diagnostics,
advice; and a digest of each of the other parts. `printed.txt` contains what ``gyro
analyze -v`` prints for one log, and ``gyro check`` for eight. A short digest of each
section is stored for other texts, Markdown and LaTeX: their numbers are those of the
JSON, and their words those of the text; and for what other commands print, and for what
``gyro check --fix`` writes of one log in eight."""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from functools import reduce
from pathlib import Path
from typing import Any
from zlib import crc32

from typer.testing import CliRunner

import gyrodata
from gates.drawn_logs import Bench, typed
from gates.logs import Log, every_log
from gates.stored import Found, compare
from gyrodata.cli import app

KNOWN = (
    "sample_data/air_gyroscope.csv",
    "sample_data/heidelberg_ball.csv",
    "sample_data/salort_one_torque.csv",
    "class/adlernina_101_9001_lab.csv",
    "contradicting",
    "falling",
    "few",
    "followed",
    "forces",
    "odd",
    "rates",
    "released",
    "tilted",
    "unloaded",
    "half way",
    "published: stacked timings with merged cells",
    "published: one torque with an uncertainty in each row",
    "en: xlsx, one table a weight",
    "turns became dates, d-mmm",
    "corpus/three-weights-in-turn.csv",
    "corpus/released-half-a-turn-of-nutation.csv",
    "slip: time [s] x 0.0166667 as time [s]",
)
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
PARTS = {
    "inertia": "value u interval_95",
    "residual_torque": "value u",
    "timing_bias": "value u",
    "goodness": "chi2 dof p",
    "fits": "name inertia.value constant.value",
    "budget": "source share",
    "effects": "effect bias kept",
    "sensitivity": "name inertia.value inertia.u",
    "torques": "torque product.value product.u",
    "power_law": "torque exponent u",
    "model": "",
    "advice": "",
    "doubts": "kind",
}
"""What is kept of each part of the result."""
DIGESTED = (
    "if_balanced constants exponent constancy ball runs uncertainties fits "
    "budget torques power_law"
)
"""Parts of the result of which a digest of all fields is kept, with five digits."""


def kept(part: Any, fields: str, digits: int = 8, zero: float = 1e-13) -> Any:
    """Keep some fields of a record, or of each of a list, with eight digits; zero but
    for rounding is 0.
    """
    if isinstance(part, list):
        return [kept(one, fields, digits, zero) for one in part]
    if isinstance(part, float):
        return 0.0 if abs(part) < zero else float(f"{part:.{digits}g}")
    if isinstance(part, dict) and not fields:
        return {key: kept(one, "", digits, zero) for key, one in part.items()}
    if not fields or not isinstance(part, dict):
        return part
    return [
        kept(reduce(lambda one, key: one and one[key], field.split("."), part), "")
        for field in fields.split()
    ]


def numbers(log: Log) -> str:
    """Analyse a log, and keep what matters, a line for each part."""
    try:
        document = log.analyze().to_dict()
    except gyrodata.GyroError as error:
        return f"refused: {' '.join(found.code for found in error.diagnostics)}\n"
    lines = {
        name: kept(document["result"][name], fields) for name, fields in PARTS.items()
    }
    whole = (
        json.dumps(kept(document["result"][name], "", 5, 1e-9))
        for name in DIGESTED.split()
    )
    lines["digests"] = " ".join(
        hashlib.sha256(text.encode()).hexdigest()[:4] for text in whole
    )
    lines["diagnostics"] = [
        [one["code"], one["line"], one["column"]] for one in document["diagnostics"]
    ]
    return "".join(
        f"{name}: {json.dumps(value, separators=(',', ':'))}\n"
        for name, value in lines.items()
    )


def gate_json(accept: bool = False, part: bool = False) -> Found:
    """Compare the JSON of thirty logs, or of three."""
    known = every_log()
    logs = {
        **{name: known[name] for name in KNOWN},
        **{name: Log(typed(bench, 1)) for name, bench in DRAWN.items()},
    }
    if part:
        logs = dict([*logs.items()][::10])
    lines = compare(
        "numbers.txt", {name: numbers(log) for name, log in logs.items()}, accept, part
    )
    return Found(
        f"JSON of {len(logs)} logs: {len(lines)} lines differ",
        "none differs",
        not lines,
        lines,
    )


SHOWN = (
    "sample_data/air_gyroscope.csv",
    "sample_data/heidelberg_ball.csv",
    "sample_data/salort_one_torque.csv",
    "tilted",
    "released",
    "odd",
    "rates",
    "half way",
)
COMMANDS = {
    "text": "analyze -v --no-report --format text",
    "check": "check",
    "markdown": "analyze --format markdown",
    "latex": "analyze --format latex",
}


OTHERS = (
    "predict precession --log LOG",
    "predict precession --log LOG --pitch 30deg --spin 200rpm",
    "predict precession --log LOG --mass 400g --position 15cm --spin 60rpm --pitch 60deg",
    "predict earth --latitude 48deg --log LOG",
    "predict twist --wheel-spin 300rpm",
    "predict platform --platform-inertia 4kg*m^2 --from 0deg --to 90deg",
    "predict tip --log LOG --force 2N",
    "simulate --seed 1",
    "simulate --seed 2 --turns 1/3,1 --weights 20g,40g",
    "simulate --seed 3 --spin-decay 600s --pitch 20deg",
    "simulate --seed 4 --spin-decay 100s --turns 1/3",
    "simulate --seed 5 --imbalance 0.3mN*m --position 15cm,-10cm --noise none",
    "simulate --seed 6 --spin-decay 600s",
    "analyze LOG --model horizontal",
    "analyze LOG --keep-flagged --format csv",
)
"""Commands of which a digest is stored for each paragraph; LOG is the sample."""


def digests(text: str, parts: str) -> str:
    """Write a line with the digest of each part of a text, and how it begins.

    Numbers with many digits are rounded first, because another processor gives other
    last digits."""
    text = re.sub(
        r"\d+\.\d{9,}(?:e[-+]?\d+)?", lambda number: f"{float(number[0]):.6g}", text
    )
    pieces = [one for one in re.split(parts, text, flags=re.MULTILINE) if one.strip()]
    return "".join(
        f"{hashlib.sha256(one.encode()).hexdigest()[:8]} {one.strip().splitlines()[0][:30]}\n"
        for one in pieces
    )


def mended(path: Path, log: Log) -> str:
    """Give four letters of a digest of what ``gyro check --fix`` writes of a log;
    "none" if it writes nothing.
    """
    path.write_bytes(log.data)
    new = path.with_name("log-fixed.csv")
    new.unlink(missing_ok=True)
    CliRunner().invoke(app, ["check", "--fix", str(path)], prog_name="gyro")
    return hashlib.sha256(new.read_bytes()).hexdigest()[:4] if new.exists() else "none"


def gate_printed(accept: bool = False, part: bool = False) -> Found:
    """Compare text, Markdown, LaTeX and the words of ``gyro check`` for eight logs, or
    for one; and other commands.

    Of other texts than the first, of Markdown, LaTeX and other commands a digest of
    each section is stored."""
    known, table = every_log(), {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"

        def shown(command: str) -> str:
            done = CliRunner().invoke(app, command.split(), prog_name="gyro")
            text = done.output.replace(f"{folder}/", "").replace(
                gyrodata.__version__, "VERSION"
            )
            return f"exit code {done.exit_code}\n{text.strip()}\n"

        for name in SHOWN[: 1 if part else None]:
            path.write_bytes(known[name].data)
            # LaTeX of the first four logs.
            for form, command in list(COMMANDS.items())[
                : -1 if name in SHOWN[4:] else None
            ]:
                text = shown(f"{command} {path}")
                if form in ("markdown", "latex"):
                    text = digests(text, r"^(?=## |\\(?:sub)?section)")
                elif form == "text" and name != SHOWN[0]:
                    text = digests(text, r"\n\n")
                table[f"{name}, {form}"] = text
        path.write_bytes(known[SHOWN[0]].data)
        for command in OTHERS[: 2 if part else None]:
            table[command] = digests(shown(command.replace("LOG", str(path))), r"\n\n")
        if not part:
            # Chosen by name, so that another log changes no other line.
            chosen = (
                log for name, log in known.items() if crc32(name.encode()) % 8 == 0
            )
            fixed = [mended(path, log) for log in chosen]
            table["check --fix"] = "".join(
                " ".join(fixed[at : at + 16]) + "\n" for at in range(0, len(fixed), 16)
            )
    lines = compare("printed.txt", table, accept, part)
    return Found(
        f"{len(table)} outputs of commands: {len(lines)} places differ",
        "none differs",
        not lines,
        lines,
    )
