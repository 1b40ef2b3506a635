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
from pathlib import Path

import pytest
from places import PACKAGE, TESTS

from gyrodata.base import diagnostics
from gyrodata.grading.submissions.names import PLATFORMS

FLOORS = (
    ("base",),
    ("quantities",),
    ("readings", "physics"),
    ("measurements",),
    ("fitting",),
    ("judging",),
    ("results",),
    ("analysis", "reporting"),
    ("trials", "grading"),
    ("api", "cli"),
    ("__main__",),
    ("",),
)
"""The rooms, from the ground up: a room imports only from floors below its own. The
name "" is the front of the package, which hands on what users call."""
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
OWNERS = {
    "pint": "quantities",
    "matplotlib": "reporting trials",
    "typer": "cli",
    "rich": "cli reporting",
    "jinja2": "reporting grading",
    "yaml": "grading",
    "pypdf": "grading",
}
"""The rooms that may import a library; only types are free (`imports`)."""


def dotted(path: Path) -> str:
    """Give the name of a module; the front of a room has the room's."""
    return ".".join(
        path.relative_to(PACKAGE.parent).with_suffix("").parts
    ).removesuffix(".__init__")


MODULES = {dotted(path): path for path in sorted(PACKAGE.rglob("*.py"))}


IMPORTING = ast.Import | ast.ImportFrom | ast.Call


@functools.cache
def nodes_of(path: Path) -> list[tuple[ast.AST, bool]]:
    """List what may import in a file, and whether it is only done for types."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = [*ast.walk(tree)]
    guarded = [
        node
        for node in nodes
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
    ]
    types_only = {id(inner) for outer in guarded for inner in ast.walk(outer)}
    return [
        (node, id(node) in types_only) for node in nodes if isinstance(node, IMPORTING)
    ]


def imports(path: Path, types: bool = True) -> set[str]:
    """Modules that a file imports, also by `import_module`, and for types if wanted."""
    modules: set[str] = set()
    for node, is_for_types in nodes_of(path):
        if is_for_types and not types:
            continue
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = {f"{node.module}.{alias.name}" for alias in node.names} & set(
                MODULES
            )
            modules |= inside
            if len(inside) < len(node.names):
                modules.add(node.module)
        elif isinstance(node, ast.Call):
            modules |= hidden_imports(node)
    return modules


def hidden_imports(call: ast.Call) -> set[str]:
    """Modules that a call of `import_module` or `__import__` may load.

    A name with a part in braces stands for every module that the pattern fits.
    """
    name = ast.unparse(call.func).rpartition(".")[2]
    if name not in ("import_module", "__import__"):
        return set()
    text = call.args[0]
    if isinstance(text, ast.Constant):
        return {str(text.value)}
    assert isinstance(text, ast.JoinedStr), "a hidden import must name its room"
    pattern = "".join(
        re.escape(str(part.value)) if isinstance(part, ast.Constant) else r"[\w.]+"
        for part in text.values
    )
    return {module for module in MODULES if re.fullmatch(pattern, module)}


def room(name: str) -> str:
    return [*name.split("."), ""][1]


@functools.cache
def imported() -> dict[str, set[str]]:
    return {name: imports(path) for name, path in MODULES.items()}


def upward(found: dict[str, set[str]]) -> list[tuple[str, str]]:
    """Imports from one room to another that is not on a lower floor."""
    return [
        (name, other)
        for name, others in found.items()
        for other in others
        if other in MODULES and room(name) != room(other)
        if FLOOR[room(other)] >= FLOOR[room(name)]
    ]


def test_imports_only_go_down_the_floors() -> None:
    assert {room(name) for name in MODULES} == set(FLOOR)
    assert sum(map(len, imported().values())) > 500
    assert upward(imported()) == []


def test_top_level_has_few_modules() -> None:
    assert len(list(PACKAGE.glob("*.py"))) <= 6


def test_no_module_imports_itself_through_others() -> None:
    # Raises with the cycle. Inside of a room, types may name each other.
    cycle_free = {
        name: imports(path, types=False) - {name} for name, path in MODULES.items()
    }
    list(graphlib.TopologicalSorter(cycle_free).static_order())


@pytest.mark.parametrize(
    "line",
    [
        "from gyrodata.reporting import text",
        "from gyrodata import api",
        "import gyrodata.cli.schema",
        "importlib.import_module('gyrodata.reporting.text')",
        "import_module(f'gyrodata.{room}')",
        "if TYPE_CHECKING:\n    from gyrodata.api import Analysis",
    ],
)
def test_upward_import_of_each_kind_is_seen(line: str, tmp_path: Path) -> None:
    (tmp_path / "new.py").write_text(line + "\n", encoding="utf-8")
    assert upward({"gyrodata.results": imports(tmp_path / "new.py")}) != []


def test_libraries_stay_with_their_owners() -> None:
    libraries = [
        (room(name), other.split(".")[0])
        for name, path in MODULES.items()
        for other in imports(path, types=False)
    ]
    owned = [(user, library) for user, library in libraries if library in OWNERS]
    assert len(owned) > 10
    assert [pair for pair in owned if pair[0] not in OWNERS[pair[1]].split()] == []


def test_each_message_is_used_and_each_used_message_exists() -> None:
    source = "".join(path.read_text("utf-8") for path in PACKAGE.rglob("*.py"))
    messages = diagnostics.messages()
    alone = {name: diagnostics.message(name) for name in messages}
    assert messages == alone, "each message is read alone"
    said = set(
        re.findall(r'(?:\.say|faults\.add|refuse|\.named|unfit)\(\s*"(\w+)"', source)
    )
    assert said <= set(messages)
    of_platforms = {f"no_book_of_{one}" for one in PLATFORMS}
    with_text = {name for name, record in messages.items() if record.text}
    unused = {name for name in with_text - of_platforms if f'"{name}"' not in source}
    assert unused == set()


HEAVY = "numpy pandas scipy pint matplotlib jinja2 uncertainties pydantic"


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        ("--help", HEAVY),
        (
            "analyze ../sample_data/air_gyroscope.csv --no-report",
            "pandas matplotlib jinja2 pydantic",
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
