"""Imports only go down the shelves, and heavy libraries stay in the rooms that own
them.
"""

from __future__ import annotations

import ast
import functools
import graphlib
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from msgspec import convert

from gyrodata import diagnostics
from gyrodata.grading.submissions.names import PLATFORMS

TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "gyrodata"
ROOMS = """diagnostics docs vocabulary; errors units;
    disk toml_table workers quantities physics
    error_sources; motion readings; measurements; fitting; tables simulation mistakes; changes; wrong_cells;
    findings refusals; results; benchmark analysis coverage prediction;
    plotting procedure python_api; reporting;
    grading; schema; cli; __main__"""
SHELVES = {
    room: shelf
    for shelf, rooms in enumerate(ROOMS.split(";"))
    for room in rooms.split()
}
"""A room imports only from shelves below its own."""
OWNERS = {
    "pint": "units",
    "matplotlib": "plotting",
    "typer": "cli",
    "rich": "docs",
    "jinja2": "reporting grading",
    "yaml": "grading",
}


def dotted(path: Path) -> str:
    """Give the name of a module; the front of a room has the room's."""
    return ".".join(
        path.relative_to(PACKAGE.parent).with_suffix("").parts
    ).removesuffix(".__init__")


MODULES = {dotted(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imports(path: Path) -> set[str]:
    """Modules that a file imports, types apart."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    guarded = [
        n
        for n in ast.walk(tree)
        if isinstance(n, ast.If) and ast.unparse(n.test).endswith("TYPE_CHECKING")
    ]
    types_only = {id(inner) for outer in guarded for inner in ast.walk(outer)}
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif (
            isinstance(node, ast.ImportFrom)
            and node.module
            and id(node) not in types_only
        ):
            inside = {f"{node.module}.{alias.name}" for alias in node.names} & set(
                MODULES
            )
            found |= inside | (
                {node.module} if len(inside) < len(node.names) else set()
            )
    return found


def room(name: str) -> str:
    return [*name.split("."), ""][1]


@functools.cache
def imported() -> dict[str, set[str]]:
    return {name: imports(path) for name, path in MODULES.items()}


def pairs() -> list[tuple[str, str]]:
    return [
        (name, other)
        for name, others in imported().items()
        if name != "gyrodata"
        for other in others
    ]


def test_imports_only_go_down_the_shelves() -> None:
    assert {room(name) for name in MODULES} == {"", *SHELVES}
    inner = [
        (a, b)
        for a, b in pairs()
        if room(b) in SHELVES and b in MODULES and room(a) != room(b)
    ]
    assert len(inner) > 100
    assert [(a, b) for a, b in inner if SHELVES[room(b)] >= SHELVES[room(a)]] == []
    # Raises with the cycle if there is one inside a room.
    list(
        graphlib.TopologicalSorter(
            {name: others - {name} for name, others in imported().items()}
        ).static_order()
    )


def test_libraries_stay_with_their_owners() -> None:
    assert [
        (a, b)
        for a, b in pairs()
        if room(a) not in OWNERS.get(b.split(".")[0], room(a)).split()
    ] == []


def test_each_message_is_used_and_each_used_message_exists() -> None:
    source = "".join(path.read_text("utf-8") for path in PACKAGE.rglob("*.py"))
    whole = tomllib.loads((PACKAGE / "messages.toml").read_text("utf-8"))
    messages = {name: diagnostics.message(name) for name in whole}
    assert messages == convert(whole, dict[str, diagnostics.Message]), (
        "each message is read alone"
    )
    names = set(messages)
    said = set(
        re.findall(r'(?:\.say|faults\.add|refuse|\.named|unfit)\(\s*"(\w+)"', source)
    )
    assert said <= names
    of_platforms = {f"no_book_of_{one}" for one in PLATFORMS}
    assert {name for name in names - of_platforms if f'"{name}"' not in source} == set()
    codes = {one.code.split()[1]: one.code for one in messages.values()}
    assert {one.code for one in messages.values()} == set(codes.values())


HEAVY = "numpy pandas scipy pint matplotlib jinja2 uncertainties"


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        ("--help", HEAVY),
        (
            "analyze ../sample_data/air_gyroscope.csv --no-report",
            "pandas pint matplotlib jinja2",
        ),
    ],
)
def test_a_start_loads_nothing_heavy(words: str, heavy: str) -> None:
    code = (
        f"import sys\nsys.argv = ['gyro', *{words.split()}]\nfrom gyrodata.__main__ import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        f"print(sorted(set({heavy.split()}) & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=TESTS,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout
    assert done.stderr.splitlines()[-1] == "[]"
