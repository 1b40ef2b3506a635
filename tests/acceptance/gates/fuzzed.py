"""Gate 7: of 5,000 fuzzed and mutated logs none ends in a traceback, and none is wrong
by a factor of 3 in silence.

Four of five logs come from the grammar of `tests/acceptance/fuzz`, which knows the
truth: any design, unit, count and statement, often with a slip of a whole column or
with spoiled cells, lines and bytes. The others are ordinary logs of a known truth and
the logs of the repository, spoiled in the same way. An answer that is wrong by a factor
of 3 must come with a warning, a doubt or a run that is flagged. A slip of a whole
column without anything in the log to compare with cannot be seen; such logs must only
not break the tool. The number of faults may only fall. `fuzzed.csv` contains a digest
of the answers and codes of forty logs each, to show whether a change reaches logs that
nobody wrote by hand."""

from __future__ import annotations

import json
import math
import re
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import cache

import numpy as np
from fuzz import grammar

import gyrodata
from gates.drawn_logs import INERTIA, Bench, typed
from gates.stored import Found, at_best, compare, digest, read

COUNT = 5000
TOGETHER = 40
"""Logs of one digest."""
SIZES = (1, 2, 3, 4, 6, 9, 9, 12, 18)
"""Runs of most drawn logs; one of 100 has any number up to 300."""


@cache
def known() -> list[str]:
    """Logs of the repository that need no option."""
    return [
        text.replace("⇥", "\t")
        for name, text in read("logs.txt").items()
        if "--" not in name
    ]


def draw(seed: int) -> tuple[bytes, str, float | None]:
    """Draw a log, the model it is analysed with, and the true I_zz if anybody could
    know it.
    """
    random = np.random.default_rng(seed)
    if seed % 10 == 0:
        return grammar.spoiled(known()[seed // 10 % len(known())], random), "auto", None
    if seed % 10 == 5:
        return (
            grammar.spoiled(typed(Bench(repeats=1 + seed % 3), seed).decode(), random),
            "auto",
            INERTIA,
        )
    lab = grammar.draw_lab(
        random, None if seed % 100 == 1 else int(random.choice(SIZES))
    )
    if seed % 4:
        lab.columns.pop(
            "pitch", None
        )  # rods that are tilted take ten times as long: a quarter of them is enough
    slip = random.random() < 0.3
    text = grammar.write(grammar.slipped(lab, random) if slip else lab, random)
    model = str(
        random.choice(("auto", "auto", "auto", "horizontal", "steady", "released"))
    )
    data = grammar.spoiled(text, random) if random.random() < 0.6 else text.encode()
    # What such a log states makes its truth another one: g of the Moon, a rod let go.
    other = (
        "1.62 m/s" in text
        or "motion" in text
        or "transverse_inertia" in text
        or "pitch" in lab.columns
    )
    return data, model, None if slip or other else lab.inertia


def attempt(seed: int) -> tuple[str, str, str]:
    """Analyse one log: refused, answered, or what is wrong with the answer; codes, I_zz
    and u to three digits.
    """
    data, model, truth = draw(seed)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", gyrodata.GyroWarning)
            document = gyrodata.analyze(data, name=("log.csv"), model=model).to_dict()  # type: ignore[arg-type]
            json.dumps(document, allow_nan=False)
    except gyrodata.GyroError as error:
        bare = re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f]", str(error))
        said = any(
            found.severity == "error" and found.message for found in error.diagnostics
        )
        codes = " ".join(f"{found.code}:{found.line}" for found in error.diagnostics)
        wrong = (
            ""
            if said and not bare
            else "refused without words, or with control characters"
        )
        return "fault" if wrong else "refused", wrong, codes
    except Exception as error:
        return "fault", f"{type(error).__name__}: {str(error)[:120]}", ""
    result = document["result"]
    value, u = result["inertia"]["value"], result["inertia"]["u"] or 0.0
    if not (0 < value < math.inf and 0 <= u < math.inf):
        return "fault", f"I_zz = {value} ± {u}", ""
    codes = " ".join(
        f"{found['code']}:{found['line']}" for found in document["diagnostics"]
    )
    kept = f"{value:.3g} {u:.2g} {codes}"
    aloud = [
        found for found in document["diagnostics"] if found["severity"] != "note"
    ] or result["doubts"]
    if (
        truth
        and not (aloud or any(run["flagged"] for run in result["runs"]))
        and not 1 / 3 < value / truth < 3
    ):
        return "silent", f"I_zz = {value:.4g} ± {u:.2g}, true {truth:.4g}", kept
    return "answered", "", kept


def gate(accept: bool = False, part: bool = False, count: int = COUNT) -> Found:
    """Try the same logs in each run."""
    count = TOGETHER if part else count
    with ProcessPoolExecutor(2) as pool:
        ends = list(pool.map(attempt, range(count), chunksize=50))
    of = {
        word: sum(end == word for end, *_ in ends)
        for word in ("answered", "refused", "fault", "silent")
    }
    wrong = [
        f"seed {seed}: an answer or a refusal | {what}"
        for seed, (_, what, _) in enumerate(ends)
        if what
    ]
    new = {
        str(at): digest("\n".join(kept for *_, kept in ends[at : at + TOGETHER]))
        for at in range(0, count, TOGETHER)
    }
    lines = compare("fuzzed.csv", new, accept, count < COUNT, "first,digest")
    measured = (
        f"{count} logs: {of['answered']} answered, {of['refused']} refused, "
        f"{of['fault']} faults"
    )
    measured += f", {of['silent']} wrong in silence; {len(lines)} digests differ"
    found = at_best(
        "faults in fuzzed logs", -len(wrong), measured, accept, wrong + lines
    )
    return found._replace(
        ok=found.ok and not lines, required=f"{found.required}; no digest differs"
    )
