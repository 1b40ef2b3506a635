"""What the command printed last time, kept in text files beside this one, and how it differs from today's.

A stored file is a table from a key to a text. Two texts agree if their words are the same and their numbers agree to
seven digits: another processor may round the eighth digit in another way.
"""

from __future__ import annotations

import csv
import difflib
import io
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

Table = dict[str, str]


class Found(NamedTuple):
    """What one gate found."""

    measured: str
    required: str
    ok: bool
    differences: list[str] = []
    """Lines to show if the gate differs: what was stored | what is found now."""


def read(name: str) -> Table:
    """Read a stored file: ``.csv`` with the key in the first column, or blocks below ``== key``."""
    path = HERE / name
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if path.suffix == ".csv":
        rows = list(csv.reader(io.StringIO(text)))[1:]
        return {row[0]: line_of(row[1:]) for row in rows}
    blocks = re.split(r"^== (.*)\n", text, flags=re.MULTILINE)[1:]
    return dict(zip(blocks[::2], blocks[1::2], strict=True))


def write(name: str, table: Table, head: str = "") -> None:
    """Write a stored file."""
    if name.endswith(".csv"):
        text = f"{head}\n" + "".join(f"{line_of([key])},{row}\n" for key, row in table.items())
    else:
        text = "".join(f"== {key}\n{block}" for key, block in table.items())
    (HERE / name).write_text(text, encoding="utf-8")


def line_of(cells: list[str]) -> str:
    """Write cells as one line of CSV."""
    out = io.StringIO()
    csv.writer(out, lineterminator="").writerow(cells)
    return out.getvalue()


def agree(old: str, new: str) -> bool:
    """Whether two texts have the same words, and the same numbers to seven digits."""
    if old == new:
        return True
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new), strict=True)
    return all(math.isclose(*(float(n.replace("−", "-")) for n in pair), rel_tol=2e-7) for pair in pairs)


def compare(name: str, new: Table, accept: bool, part: bool = False, head: str = "") -> list[str]:
    """List the differences from a stored file, or store the new table; `part`: the table is a part of the whole."""
    if accept:
        write(name, new, head)
        return []
    old = read(name)
    keys = new if part else {**old, **new}
    return [line for key in keys for line in _differences(key, old.get(key, ""), new.get(key, ""))]


def _differences(key: str, old: str, new: str) -> Iterator[str]:
    if not old or not new:
        yield f"{key}: {_short(old) or '(not stored)'} | {_short(new) or '(gone)'}"
    elif "\n" not in old:
        if not agree(old, new):
            yield f"{key}: {old} | {new}"
    elif not agree(old, new):
        lines, now = old.splitlines(), new.splitlines()
        for tag, a, b, c, d in difflib.SequenceMatcher(None, lines, now, autojunk=False).get_opcodes():
            if tag != "equal":
                yield f"{key}, line {a + 1}: {' / '.join(lines[a:b])} | {' / '.join(now[c:d])}"


def _short(text: str) -> str:
    return text.strip().partition("\n")[0]


def at_best(name: str, number: int, measured: str, accept: bool, lines: list[str]) -> Found:
    """Compare a number that is not yet as it should be with the best one so far, in `best.csv`: it may only rise.

    A number of faults is given with a minus sign.
    """
    best = read("best.csv")
    if accept and (name not in best or number > int(best[name])):
        write("best.csv", {**best, name: str(number)}, "what,best so far")
    least = int(read("best.csv").get(name, number))
    required = f"at least {least}" if least > 0 else f"at most {-least}"
    return Found(measured, f"{required} (may only improve)", number >= least, lines)
