"""Every other door at which something comes in: what is given to the command, and what
must be true of what it writes.

A door is a function of a seed. It gives what became of the input, "taken" or "refused";
it raises if something is wrong, and lets any other fault of the tool through."""

from __future__ import annotations

import csv
import gzip
import io
import os
import random
import re
import shlex
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

from fuzz.grammar import JUNK, KEYS, draw_input
from gyrodata.base.errors import GyroError
from gyrodata.cli import app
from gyrodata.readings import read_log, write_log

HOSTILE = (
    "\x1b[2J\x1b]0;x\x07",
    "\u202eDNA\u202c",
    "=1+1",
    "@SUM(A1)",
    "<script>alert(1)</script>",
    "</title>",
    '"><img src=x onerror=1>',
    "\\input{/etc/passwd}",
    "$\\end{document}",
    "%",
    "#_^~&",
    "| a | b",
    "a\nb",
    "[x](javascript:1)",
    "\x85\x9b31m",
    "\u2028",
    "Ёлка 山",
    "a" * 300,
    "",
    '"',
    "{{ 7*7 }}",
    "\u200b",
    "\x00",
)
BARE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What a terminal obeys, or what turns a line around."""
FOREIGN = re.compile(
    r"<(?:script|img|iframe|object|svg)\b[^>]*(?:src|onerror|onload|href)\s*=",
    re.IGNORECASE,
)
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
LOG = (
    "# I_zz: 4.4e-3 ± 0.1e-3 kg m^2\n"
    + HEAD
    + "20,15.0,406,40.2,1\n40,15.0,406,20.1,1\n60,15.0,611,20.2,1\n"
)


def assert_shown(text: str) -> None:
    """See that a terminal can show a text."""
    found = BARE.search(text)
    assert found is None, (
        f"{found[0]!r} in {text[max(0, found.start() - 40) : found.end() + 20]!r}"
    )


def mutated(rng: random.Random, text: str, delimiters: str = ",;\t") -> bytes:
    """Do to a text what editors and tired hands do, and what nobody would."""
    for _ in range(rng.choice((0, 0, 1, 1, 2, 4))):
        lines = text.split("\n")
        at = rng.randrange(len(lines))
        line, junk = lines[at], rng.choice((*JUNK, *HOSTILE))
        cut, cells = rng.randrange(len(line) + 1), re.split(f"([{delimiters}])", line)
        cells[rng.randrange(0, len(cells), 2)] = junk
        ways = (
            "".join(cells),
            f"{junk}\n{line}",
            "",
            line[:cut] + junk + line[cut + 1 :],
            line[:cut],
            f'"{line}',
        )
        lines[at] = rng.choice((*ways, rng.choice(lines)))
        text = "\n".join(lines) or " "
    encoding = rng.choice(
        ("utf-8",) * 6 + ("utf-8-sig", "utf-16", "utf-16-le", "cp1251", "latin-1")
    )
    data = text.replace("\n", rng.choice(("\n", "\n", "\r\n", "\r"))).encode(
        encoding, "replace"
    )
    return damaged(rng, data) if rng.random() < 0.1 else data


def damaged(rng: random.Random, data: bytes) -> bytes:
    """Change, drop or add a few bytes."""
    spoiled = bytearray(data)
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(spoiled) + 1)
        spoiled[at : at + rng.choice((0, 1, 4, 100))] = rng.randbytes(
            rng.choice((0, 1, 4))
        )
    return bytes(spoiled)


@contextmanager
def folder() -> Iterator[None]:
    """Work in a folder with a log, a class of two, a rubric and a gradebook."""
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        try:
            Path("class").mkdir()
            for path in ("log.csv", "class/ann.csv", "class/ben.csv"):
                Path(path).write_text(LOG, encoding="utf-8")
            Path("rubric.toml").write_text(rubric_text("simple"), encoding="utf-8")
            Path("book.csv").write_text(
                "Student,ID,Lab (5)\n    Points Possible,,20\nAnn,ann,\n",
                encoding="utf-8",
            )
            yield
        finally:
            os.chdir(home)


def gyro(*words: str) -> int:
    """Give words to the command: an exit code that is promised, no traceback, nothing
    that a terminal obeys.
    """
    line = [one.encode("utf-8", "replace").decode() for one in words]
    done = CliRunner().invoke(app, line, input=LOG)
    said = shlex.join(line)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise AssertionError(f"gyro {said}: {done.exception!r}") from done.exception
    assert done.exit_code in (0, 1, 2), (
        f"gyro {said}: exit code {done.exit_code}: {done.output[-300:]}"
    )
    assert "Traceback" not in done.output, said
    assert_shown(done.output)
    return done.exit_code


def graded(*words: str) -> str:
    """Grade the class, and look at all that is written: no formula in a cell, nothing
    from elsewhere in a page.
    """
    code = gyro("grade", *words, "--workers", "0", "--out", "out")
    for path in Path("out").rglob("*.*") if Path("out").exists() else ():
        if path.suffix in (".csv", ".html", ".md", ".json"):
            written = path.read_text(encoding="utf-8", errors="replace")
            if path.suffix != ".json" and not path.name.startswith(
                ("canvas", "moodle", "desk")
            ):
                assert_shown(written)
            assert path.suffix != ".html" or not FOREIGN.search(written)
            if path.name in ("grades.csv", "flags.csv"):
                rows = list(csv.reader(io.StringIO(written)))
                assert not any(
                    cell[:1] in tuple("=+@\t\r") for row in rows for cell in row
                )
    return "refused" if code == 2 else "taken"


@cache
def rubric_text(kind: str) -> str:
    """Give a rubric without its remarks."""
    whole = (
        CliRunner().invoke(app, ["grade", "--print-rubric", kind]).stdout.splitlines()
    )
    return "\n".join(line for line in whole if line and not line.startswith("#"))


# --- the doors ---


def reader(seed: int) -> str:
    """A log, as text or packed: read twice it is the same, and what is written of it is
    read without an error.
    """
    rng = random.Random(seed)
    data = draw_input(seed)[0]
    if rng.random() < 0.1:
        data = (
            damaged(rng, gzip.compress(data))
            if rng.random() < 0.7
            else gzip.compress(data)
        )
    return try_reader(data)


def try_reader(data: bytes) -> str:
    """Read a log twice, write it, and read that."""
    try:
        readings, again = read_log(data), read_log(data)
    except GyroError as error:
        assert_shown(str(error))
        return (
            "refused"
            if any(found.severity == "error" for found in error.diagnostics)
            else "no reason"
        )
    assert_shown("".join(map(str, readings.diagnostics)))
    assert list(map(str, readings.diagnostics)) == list(map(str, again.diagnostics))
    if not readings.ok:
        return "refused"
    written = write_log(readings)
    assert written == write_log(again)
    told = [
        str(one)
        for one in read_log(written.encode()).diagnostics
        if one.severity == "error"
    ]
    assert not told, told
    return "taken"


def rubric(seed: int) -> str:
    """A rubric with something wrong in it."""
    rng = random.Random(seed)
    with folder():
        Path("rubric.toml").write_bytes(
            mutated(
                rng, rubric_text(rng.choice(("simple", "full", "manual"))), "=,[]{}"
            )
        )
        return graded("class", "--rubric", "rubric.toml")


PATHS = (
    "doejane_{n}_5432_lab.csv",
    "Jane Doe_{n}_assignsubmission_file/lab.csv",
    "submission_{n}/lab.csv",
    "s{n}.csv",
    "s{n}/report.md",
    "submission_metadata.yml",
    "../up{n}.csv",
    "/abs{n}.csv",
    "a\\..\\b{n}.csv",
    "s{n}/{h}",
    "s{n}.zip",
    "s{n}/lab.csv.gz",
    "s{n}/lab.xlsx",
    "x" * 250 + "{n}.csv",
    "s{n}/",
    "con{n}.csv",
)


def zips(seed: int) -> str:
    """The zip of a class: names that climb out or are none, links, bytes that are
    damaged.
    """
    rng = random.Random(seed)
    out = io.BytesIO()
    with (
        warnings.catch_warnings(),
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        warnings.simplefilter("ignore")
        for number in range(rng.randrange(1, 6)):
            shape = rng.choice(PATHS[:6] if rng.random() < 0.6 else PATHS)
            entry = zipfile.ZipInfo(
                shape.format(
                    n=100 + number, h=rng.choice(HOSTILE).replace("\x00", "") or "x"
                )
            )
            entry.external_attr = (
                rng.choice((*[0] * 30, 0o120777, 0o060644, 0o040755)) << 16
            )
            archive.writestr(
                entry,
                draw_input(rng.randrange(2**31))[0] if rng.random() < 0.3 else LOG,
            )
    with folder():
        Path("class.zip").write_bytes(
            damaged(rng, out.getvalue()) if rng.random() < 0.35 else out.getvalue()
        )
        end = graded("class.zip")
        assert len({one.name for one in Path.cwd().iterdir()} - {"out"}) == 5, (
            "nothing is unpacked beside the grades"
        )
        return end


NEVER = {"--watch", "--workers", "--install-completion", "--show-completion", "--help"}
"""Options that wait for ever, or start processes."""


@cache
def known_options() -> list[tuple[tuple[str, ...], list[Any]]]:
    """List the parameters of each command and of the commands below it."""
    found = []

    def look(names: tuple[str, ...], command: Any) -> None:
        below = getattr(command, "commands", {})
        if not below:
            found.append(
                (
                    names,
                    [one for one in command.params if not NEVER.intersection(one.opts)],
                )
            )
        for name in below.keys() - {"selfcheck", "benchmark", "serve"}:
            look((*names, name), below[name])

    look((), typer.main.get_command(app))
    return sorted(found)


def value_of(rng: random.Random, parameter: Any) -> str:
    """Draw a value: one that is asked for, one of another option, or junk."""
    if rng.random() < 0.3 and (choices := parameter.type_descriptor.choices):
        return str(rng.choice(list(choices)))
    key = rng.choice(sorted(KEYS))
    usual = (
        "log.csv",
        "class",
        "rubric.toml",
        "book.csv",
        "out",
        "-",
        "7",
        "0.5",
        "15cm",
        "20g,40g",
        "200,400rpm",
        "1/3",
        "4.44e-3 kg m^2",
        "42.5 deg",
        "3 s",
        f"{key}={rng.choice(KEYS[key])}",
        rng.choice(KEYS[key]),
        key,
        "mass=m",
        "all",
        "json",
        "steady",
        "0",
        "100000000000",
        "1:3",
        "2,,3",
        "1e-3..2e-3 kg m^2",
    )
    return rng.choice(usual if rng.random() < 0.6 else (*JUNK, *HOSTILE)).replace(
        "\x00", ""
    )


def options(seed: int) -> str:
    """A line of the shell: an answer or words."""
    rng = random.Random(seed)
    names, parameters = rng.choice(known_options())
    line = list(names)
    for parameter in rng.sample(
        parameters, min(len(parameters), rng.choice((0, 1, 1, 2, 3, 5)))
    ):
        if parameter.param_type_name == "argument":
            line.append(value_of(rng, parameter))
            continue
        line.append(rng.choice([*parameter.opts, *parameter.secondary_opts]))
        if not getattr(parameter, "is_flag", False):
            line.append(value_of(rng, parameter))
    line += {"analyze": ["--no-report"], "grade": ["--workers", "0"]}.get(names[0], [])
    with folder():
        return (
            "taken"
            if gyro(*line, *rng.choice(([], ["log.csv"], ["class"]))) < 2
            else "refused"
        )


DOORS: dict[str, Callable[[int], str]] = {
    door.__name__: door for door in (reader, rubric, zips, options)
}
"""All of them but the analysis, by name."""
