"""Imports only go down the shelves, and heavy libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "gyrodata"
ROOMS = """diagnostics docs; errors units; disk toml_table workers quantities physics; motion readings;
    measurements; fitting; tables simulation known_slips; patterns changes; effects wrong_cells; findings;
    results prediction; benchmark analysis coverage; plotting procedure; reporting; grading; schema; cli; __main__"""
SHELVES = {room: shelf for shelf, rooms in enumerate(ROOMS.split(";")) for room in rooms.split()}
"""A room imports only from shelves below its own."""
OWNERS = {"pint": "units", "matplotlib": "plotting", "typer": "cli", "rich": "docs",
          "jinja2": "grading", "yaml": "grading"}  # fmt: skip


def dotted(path: Path) -> str:
    """Give the name of a module; the front of a room has the room's."""
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


MODULES = {dotted(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def offered(front: str) -> set[str]:
    """Names in a front's ``__all__``: one may be that of a module, and means what is in it."""
    body = ast.parse(MODULES[front].read_text(encoding="utf-8")).body
    lists = [node.value for node in body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"]
    return {name for one in lists for name in ast.literal_eval(one)}


def imports(path: Path) -> set[str]:
    """Modules that a file imports, types apart."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    guarded = [n for n in ast.walk(tree) if isinstance(n, ast.If) and ast.unparse(n.test).endswith("TYPE_CHECKING")]
    types_only = {id(inner) for outer in guarded for inner in ast.walk(outer)}
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and id(node) not in types_only:
            meant = {alias.name for alias in node.names} - (offered(node.module) if node.module in MODULES else set())
            inside = {f"{node.module}.{name}" for name in meant} & set(MODULES)
            found |= inside | ({node.module} if len(inside) < len(node.names) else set())
    return found


def room(name: str) -> str:
    return [*name.split("."), ""][1]


IMPORTS = {name: imports(path) for name, path in MODULES.items()}
PAIRS = [(name, other) for name, others in IMPORTS.items() if name != "gyrodata" for other in others]


def test_imports_only_go_down_the_shelves() -> None:
    assert {room(name) for name in MODULES} == {"", *SHELVES}
    inner = [(a, b) for a, b in PAIRS if room(b) in SHELVES and b in MODULES and room(a) != room(b)]
    assert len(inner) > 100
    assert [(a, b) for a, b in inner if SHELVES[room(b)] >= SHELVES[room(a)]] == []
    # Raises with the cycle if there is one inside a room.
    list(graphlib.TopologicalSorter({name: others - {name} for name, others in IMPORTS.items()}).static_order())


def test_libraries_stay_with_their_owners() -> None:
    assert [(a, b) for a, b in PAIRS if room(a) != OWNERS.get(b.split(".")[0], room(a))] == []


def test_tests_import_through_a_room_s_front() -> None:
    """`deep_imports.txt` lists what they import from behind it: path: modules; reason. It only gets shorter."""
    listed = (TESTS / "deep_imports.txt").read_text(encoding="utf-8").splitlines()
    for path in sorted(TESTS.rglob("*.py")):
        deep = {name for name in imports(path) & set(MODULES) if name.count(".") > 1}
        deep = {name for name in deep if MODULES[name].stem != "__init__"}
        (line,) = [one for one in listed if one.startswith(f"{path.relative_to(TESTS).as_posix()}: ")] or [": ; -"]
        names, _, reason = line.partition(": ")[2].partition("; ")
        assert reason, line
        assert deep <= {f"gyrodata.{name}" for name in names.split()}, path


def test_the_map_for_newcomers_names_every_room() -> None:
    text = (PACKAGE.parent / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert [name for name in SHELVES if not name.startswith("__") and f"`{name}" not in text] == []
    assert text.count("\n") <= 150


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "sys.argv = ['gyro', '--help']\n"
        "from gyrodata.__main__ import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "heavy = {'numpy', 'pandas', 'scipy', 'pint', 'matplotlib', 'jinja2', 'uncertainties'} & set(sys.modules)\n"
        "print(sorted(heavy), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "analyze" in done.stdout
    assert done.stderr.strip() == "[]"
