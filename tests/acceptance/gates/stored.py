"""What the command gave last time, kept in text files beside this one, and how it
differs from today's.

A stored file is a table from a key to a text. Two texts agree if their words are the
same and their numbers agree to seven digits, or to 1e-14, because an effect that should
be zero is 1e-12: another processor rounds in another way."""

from __future__ import annotations

import csv
import difflib
import hashlib
import io
import math
import re
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


class Found(NamedTuple):
    """What one gate found; each difference is a line: what was stored | what is found
    now.
    """

    measured: str
    required: str
    ok: bool
    differences: list[str]


def line_of(*cells: str) -> str:
    """Write cells as one line of CSV."""
    out = io.StringIO()
    csv.writer(out, lineterminator="").writerow(cells)
    return out.getvalue()


def read(name: str) -> dict[str, str]:
    """Read a stored file: CSV with the key in its first column, or blocks below ``==
    key``.
    """
    text = (HERE / name).read_text(encoding="utf-8") if (HERE / name).is_file() else ""
    if name.endswith(".csv"):
        return {
            key: line_of(*cells)
            for key, *cells in list(csv.reader(io.StringIO(text)))[1:]
        }
    blocks = re.split(r"^== (.*)\n", text, flags=re.MULTILINE)[1:]
    return dict(zip(blocks[::2], blocks[1::2], strict=True))


def write(name: str, table: dict[str, str], head: str = "") -> None:
    """Write a stored file."""
    if name.endswith(".csv"):
        text = f"{head}\n" + "".join(
            f"{line_of(key)},{row}\n" for key, row in table.items()
        )
    else:
        text = "".join(f"== {key}\n{block}" for key, block in table.items())
    (HERE / name).write_text(text, encoding="utf-8")


def agree(old: str, new: str) -> bool:
    """Whether two texts have the same words, and the same numbers to seven digits or to
    1e-14.
    """
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    pairs = zip(
        *(
            [float(n.replace("−", "-")) for n in NUMBER.findall(text)]
            for text in (old, new)
        ),
        strict=True,
    )
    return all(math.isclose(*pair, rel_tol=2e-7, abs_tol=1e-14) for pair in pairs)


LETTERS = str.maketrans("0123456789", "ghijklmnop")
"""Numbers are compared to seven digits, letters as they are."""


def digest(text: str) -> str:
    """Give four letters that differ for nearly every other text."""
    return hashlib.sha256(text.encode()).hexdigest().translate(LETTERS)[:4]


def compare(
    name: str, new: dict[str, str], accept: bool, part: bool = False, head: str = ""
) -> list[str]:
    """List the differences from a stored file, or store the new table; `part`: the
    table is a part of the whole.
    """
    if accept:
        write(name, new, head)
    old, found = read(name), []
    for key in new if part else {**old, **new}:
        if not agree(*(texts := (old.get(key, ""), new.get(key, "")))):
            before, now = (text.splitlines() for text in texts)
            for tag, a, b, c, d in difflib.SequenceMatcher(
                None, before, now, autojunk=False
            ).get_opcodes():
                if tag != "equal":
                    old_lines, new_lines = " / ".join(before[a:b]), " / ".join(now[c:d])
                    found.append(
                        f"{key}: {old_lines[:300] or '(nothing)'} | "
                        f"{new_lines[:300] or '(nothing)'}"
                    )
    return found


def at_best(
    name: str, number: int, measured: str, accept: bool, differences: list[str]
) -> Found:
    """Compare a number that is not yet as it should be with the best one so far, in
    `best.csv`: it may only rise.

    A number of faults is given with a minus sign.
    """
    best = {key: int(row) for key, row in read("best.csv").items()}
    if accept and number > best.get(name, -math.inf):
        best[name] = number
        write(
            "best.csv",
            {key: str(value) for key, value in best.items()},
            "what,best so far",
        )
    least = best.get(name, number)
    required = f"at least {least}" if least > 0 else f"at most {-least}"
    return Found(
        measured, f"{required}, and it may only improve", number >= least, differences
    )
