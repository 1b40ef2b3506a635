"""No number is damaged on its way out: every format in every locale, into a file, a
pipe and onto a terminal.
"""

from __future__ import annotations

import os
import re
import sys
import unicodedata
from contextlib import ExitStack
from pathlib import Path

import pytest
from places import ROOT, TESTS
from processes import started
from streams import LINES

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals")

PLAIN = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
LOCALES = (
    ({"PYTHONIOENCODING": "utf-8"}, ["utf-8"]),
    ({"LC_ALL": "C", **PLAIN}, ["ascii", "cp437"]),
)
"""The environment of a process, and the encodings of its streams."""
ENCODINGS = [encoding for _, encodings in LOCALES for encoding in encodings]

# A header in Greek and Russian, a name, and a number that is none: all is told, and
# quoted.
BAD = (
    "# оператор: Ünal\nmass [g], position [cm], spin [rpm], T₁ [ms²], turns\n20, 15, "
    "400, 1３.0, ½\n"
)


def written(folder: Path) -> dict[str, list[tuple[str, str]]]:
    """Give what every command wrote into a file and onto a terminal, by encoding."""
    work = folder / "work"
    work.mkdir()
    (work / "log.csv").write_bytes(
        (ROOT / "sample_data" / "air_gyroscope.csv").read_bytes()
    )
    (work / "bad.csv").write_text(BAD, encoding="utf-8")
    (work / "class").mkdir()
    for path in sorted((ROOT / "sample_data" / "class").iterdir())[::7]:
        (work / "class" / path.name).symlink_to(path)
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("LC_", "LANG", "PYTHON"))
    }
    kept |= {
        "PYTHONPATH": str(ROOT),
        "NO_COLOR": "1",
        "COLUMNS": "1000",
        "OPENBLAS_NUM_THREADS": "1",
    }
    with ExitStack() as stack:
        running = []
        for locale, encodings in LOCALES:
            script = TESTS / "support" / "streams.py"
            line = [sys.executable, script, folder, *encodings]
            running.append(
                stack.enter_context(started(line, cwd=work, env=kept | locale))
            )
        assert [process.wait(600) for process in running] == [0] * len(running)

    def both(name: str, i: int) -> tuple[str, str]:
        parts = (folder / name / f"{i}.{where}" for where in ("file", "terminal"))
        kept, shown = (part.read_bytes() for part in parts)
        return kept.decode("utf-8"), with_signs(shown.decode(name))

    return {name: [both(name, i) for i in range(len(LINES))] for name in ENCODINGS}


def with_signs(shown: str) -> str:
    """Read signs that a terminal lacks: each is written with its name or its number."""
    named = re.sub(r"\\N\{([^}]+)\}", lambda m: unicodedata.lookup(m[1]), shown)
    return re.sub(r"\\x([0-9a-f]{2})", lambda m: chr(int(m[1], 16)), named)


RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹"


def numbers(text: str) -> list[str]:
    """List the numbers of a text, however their powers of ten and their squares are
    written.
    """
    text = re.sub(
        r"[×x·*] ?10([\^⁻⁰¹²³⁴⁵⁶⁷⁸⁹][-⁻⁰¹²³⁴⁵⁶⁷⁸⁹\d]*)",
        lambda m: f" <{unicodedata.normalize('NFKC', m[1].replace('^', ''))}> ",
        text,
    )
    text = re.sub(r"(?<=[\d)])e([-+]?\d+)", lambda m: f" <{int(m[1])}> ", text)
    text = re.sub(
        f"[⁻{RAISED}]+", lambda m: f" {unicodedata.normalize('NFKC', m[0])} ", text
    ).replace("^", " ")
    text = re.sub(r"[½⅓⅔]", lambda m: f" {unicodedata.normalize('NFKC', m[0])}", text)
    text = unicodedata.normalize("NFKC", text).replace("⁄", "/").replace("−", "-")
    return re.findall(r"<-?\d+>|\d+(?:\.\d+)?", text)


def test_every_number_is_the_same_in_every_locale_in_a_file_and_on_a_terminal(
    tmp_path: Path,
) -> None:
    told = written(tmp_path)
    for line, *found in zip(LINES, *told.values(), strict=True):
        kept, shown = found[0]
        assert kept.count("\n") > 0, line
        # A terminal has pages and tables laid out, and shows how far a long
        # computation is.
        if line.startswith("plan ") or line.endswith(" -v"):
            assert sorted(numbers(kept)) == sorted(numbers(shown)), line
        elif not line.startswith(("explain ", "grade ", "selfcheck ")):
            assert kept == shown, line
        for name, (kept_there, shown_there) in zip(ENCODINGS, found, strict=True):
            assert kept_there == kept, (name, line)
            assert numbers(shown_there) == numbers(shown), (name, line)
            # No sign is lost.
            assert shown_there.count("?") == shown.count("?"), (name, line)
