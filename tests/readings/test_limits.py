"""Files over a limit: `gyro analyze` and `gyro check` name the limit, with little time
and memory.
"""

from __future__ import annotations

import functools
import io
import os
import re
import resource
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from forked import run_gyro
from places import ROOT

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,406,13.06,1/3\n"
LOG = HEAD + ROW
SPACES = " ".join(
    f'xmlns:{name}="urn:oasis:names:tc:opendocument:xmlns:{name}:1.0"'
    for name in ("office", "table", "text")
)
pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="limits of a process are another thing there"
)


def packed(name: str, text: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, text)
    return stream.getvalue()


def xlsx(part: str, at: str, text: str) -> bytes:
    """Write a workbook with a text more in one of its parts, in front of `at`."""
    book = openpyxl.Workbook()
    for line in LOG.splitlines():
        book.active.append(line.split(","))
    book.save(saved := io.BytesIO())
    stream = io.BytesIO()
    with (
        zipfile.ZipFile(saved) as old,
        zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for name in old.namelist():
            content = old.read(name)
            new.writestr(
                name,
                content.replace(at.encode(), (text + at).encode())
                if name == part
                else content,
            )
    return stream.getvalue()


SHEET, END = "xl/worksheets/sheet1.xml", "</sheetData>"
WORKBOOKS: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "styles": (
        "a.xlsx",
        lambda: xlsx("xl/styles.xml", "</cellXfs>", "<xf/>" * 3_000_000),
        "xl/styles.xml unpacks to 15.0 MB",
    ),
    "a large sheet": (
        "a.xlsx",
        lambda: xlsx(SHEET, END, "<row/>" * 3_000_000),
        "sheet1.xml unpacks to 18.0 MB",
    ),
    "blank cells": (
        "a.xlsx",
        lambda: xlsx(SHEET, END, "<row>" + "<c/>" * 1_000_000 + "</row>"),
        "at most 200 000 cells",
    ),
    "merged cells": (
        "a.xlsx",
        lambda: xlsx(SHEET, "<pageMargins", '<mergeCell ref="A1"/>' * 400_000),
        "its sheets are too large",
    ),
    "a part of 120 MB": (
        "a.xlsx",
        lambda: packed("xl/workbook.xml", "0" * 120_000_000),
        "unpacks to more than 100 MB",
    ),
}


def shared_strings() -> bytes:
    """Write a workbook whose part of texts is large."""
    texts = (
        '<sst xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">'
        + "<si><t>a</t></si>" * 300_000
    )
    kind = (
        "application/vnd.openxmlformats-officedocument.spreadsheetml.sharedStrings+xml"
    )
    part = f'<Override PartName="/xl/texts.bin" ContentType="{kind}"/>'
    data = io.BytesIO(xlsx("[Content_Types].xml", "</Types>", part))
    with zipfile.ZipFile(data, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/texts.bin", texts + "</sst>")
    return data.getvalue()


WORKBOOKS["shared texts"] = (
    "a.xlsx",
    shared_strings,
    "xl/texts.bin unpacks to 5.1 MB; at most 1 MB",
)

TEXTS: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "a line of #": (
        "a.csv",
        lambda: ("#" * 3_000_000 + "\n" + LOG).encode(),
        "a line with # of more than 2000",
    ),
    "rows of LaTeX": (
        "a.csv",
        lambda: (HEAD + "a & b \\\\\n" * 50_000).encode(),
        "this is LaTeX source",
    ),
    "lines with a key": (
        "a.csv",
        lambda: ("# a: b\n" * 60_000 + LOG).encode(),
        "the notes and long cells contain 1800150 characters",
    ),
    "long notes": (
        "a.csv",
        lambda: (f"# {'a b ' * 480}\n" * 200 + LOG).encode(),
        "the notes and long cells contain",
    ),
    "long cells": (
        "a.csv",
        lambda: (
            HEAD.replace("\n", ",note\n") + ROW.replace("\n", f",{'a' * 9000}\n") * 99
        ).encode(),
        "the notes and long cells contain",
    ),
    "a quote that is open": (
        "a.csv",
        lambda: (('"' + "a" * 39_000 + "\n") * 30 + LOG).encode(),
        "error G225",
    ),
    "blanks in a program": (
        "a.py",
        lambda: ("x = [\n" + ("1" + " " * 90_000 + "z\n") * 20).encode(),
        "error G",
    ),
    "a web page with open tags": (
        "a.html",
        lambda: ("<html><td>" + "<td " * 600_000).encode(),
        "error G",
    ),
    "a web page with open heads": (
        "a.html",
        lambda: ("<html><td>" + "<head " * 600_000).encode(),
        "error G",
    ),
}
HOSTILE = WORKBOOKS | TEXTS


def limited(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the command with at most 10 s of the processor and 1.2 GB more memory than
    the tests and the loaded code have.
    """
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    memory = pages * resource.getpagesize() + 1_200_000_000

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (10, 10))
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))

    return run_gyro(list(words), folder, begin=limit)


COMMANDS = [("analyze", name) for name in HOSTILE] + [
    ("check", "styles"),
    ("check", "a line of #"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("command", "name"), COMMANDS)
def test_file_over_a_limit_is_refused_in_words(
    command: str, name: str, tmp_path: Path
) -> None:
    file, make, words = HOSTILE[name]
    (tmp_path / file).write_bytes(make())
    done = limited(
        tmp_path, command, file, *(["--no-report"] if command == "analyze" else [])
    )
    said = done.stdout + done.stderr
    assert done.returncode in (1, 2), said[-300:]
    assert re.search(rf"{re.escape(file)}.*error G", said)
    assert words in said
    assert not re.search("Traceback|G901", said)


PIECES = [
    "(",
    "]",
    "9",
    "a",
    "'",
    ";",
    "+-",
    " ",
    "= ",
    "%",
    "<p",
    "1.",
    "20 g ",
    "x = 1 cm ",
]
ENTRIES: dict[str, Callable[[str], str]] = {
    "header": lambda text: HEAD.replace("\n", f',"{text}"\n') + ROW,
    "unit": lambda text: HEAD.replace("[g]", f"[{text}]") + ROW,
    "cell": lambda text: HEAD + ROW.replace("406", f'"406{text}"'),
    "note in a cell": lambda text: (
        HEAD.replace("\n", ",note\n") + ROW.replace("\n", f',"{text}"\n')
    ),
    "caption": lambda text: f'"{text}"\n{LOG}',
    "key": lambda text: f"# g{text[:1900]}: 9.81 m/s^2\n{LOG}",
    "value": lambda text: f"# u_time: 0.1{text[:1900]}\n{LOG}",
    "note": lambda text: f"# {text[:1900]}\n{LOG}",
    "program": lambda text: f"x = [1, 2, 3]{text}\ny = [1, 2, 3]\n",
    "web page": lambda text: f"<html><table><tr><td>{text}</td></tr></table>",
}


@functools.cache
def all_entries() -> bytes:
    """Write a program that reads each entry with 9,000 characters of each piece."""
    logs = [
        make(piece * (9000 // len(piece)))
        for make in ENTRIES.values()
        for piece in PIECES
    ]
    return repr(logs).encode()


@pytest.mark.slow
def test_long_texts_of_every_entry_take_little_time(tmp_path: Path) -> None:
    """A pattern that takes time with the square of the length needs minutes for these
    logs.
    """
    (tmp_path / "logs.txt").write_bytes(all_entries())
    code = (
        "import ast, pathlib\nfrom gyrodata.base.errors import GyroError\nfrom "
        "gyrodata.readings import read_log\n"
        "for log in ast.literal_eval(pathlib.Path('logs.txt').read_text()):\n"
        "    try:\n        read_log(log.encode())\n    except GyroError:\n        "
        "pass\nprint('all read')\n"
    )
    ours = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (120, 120))

    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=ours,
        preexec_fn=limit,
        capture_output=True,
        text=True,
    )
    assert done.stdout == "all read\n", done.stderr[-500:]
