"""Imports only go down the shelves, and heavy libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "gyrodata"
ROOMS = """diagnostics docs; errors stacks units; disk toml_table workers quantities physics; motion readings;
    measurements; fitting; forecast effects comparisons simulation known_slips; findings wrong_cells;
    results prediction; benchmark analysis coverage; plotting procedure; reporting; grading; schema; cli; __main__"""
SHELVES = {room: shelf for shelf, rooms in enumerate(ROOMS.split(";")) for room in rooms.split()}
"""A room imports only from shelves below its own."""
OWNERS = {"greenlet": "stacks", "pint": "units", "matplotlib": "plotting", "typer": "cli", "rich": "docs",
          "jinja2": "grading", "yaml": "grading"}  # fmt: skip


def imports(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names] if node.module == "gyrodata" else []
            found += names or [node.module]
        elif isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
    return found


def rooms() -> list[tuple[str, Path]]:
    paths = [path for path in sorted(PACKAGE.rglob("*.py")) if path != PACKAGE / "__init__.py"]
    return [(path.relative_to(PACKAGE).parts[0].removesuffix(".py"), path) for path in paths]


def test_every_module_has_a_shelf() -> None:
    assert {room for room, _ in rooms()} <= set(SHELVES)


def test_imports_only_go_down() -> None:
    wrong = [
        f"{path.name} imports {name}"
        for room, path in rooms()
        for name in imports(path)
        if name.startswith("gyrodata.")
        and (other := name.split(".")[1]) in SHELVES
        and other != room
        and SHELVES[other] >= SHELVES[room]
    ]
    assert wrong == []


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name; a room's front has the room's."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


TESTS = Path(__file__).parent
DEEP = TESTS / "deep_imports.txt"
"""Tests that import modules behind a room's front: path: modules; reason. The list only gets shorter."""


def offers(front: Path) -> set[str]:
    """Names in a front's ``__all__``."""
    body = ast.parse(front.read_text(encoding="utf-8")).body
    lists = [node.value for node in body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"]
    return {name for one in lists for name in ast.literal_eval(one)}


def deep_imports(path: Path) -> set[str]:
    """Modules that a test imports from behind a room's front, which is the room itself or a module of its own."""
    known, found = modules(), set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module in known:
            # A front may offer a function under the name of its module.
            offered = offers(known[node.module])
            inside = [f"{node.module}.{alias.name}" for alias in node.names if alias.name not in offered]
            names = [node.module, *(name for name in inside if name in known)]
        found |= {name for name in names if name in known and name.count(".") > 1 and known[name].stem != "__init__"}
    return found


def test_tests_import_through_a_room_s_front() -> None:
    allowed = {}
    for line in DEEP.read_text(encoding="utf-8").splitlines():
        path, _, rest = line.partition(": ")
        names, _, reason = rest.partition("; ")
        assert reason, f"{path} has no reason"
        allowed[path] = {f"gyrodata.{name}" for name in names.split()}
    deep = {path.relative_to(TESTS).as_posix(): deep_imports(path) for path in sorted(TESTS.rglob("*.py"))}
    # What is here and not in the list is new; what is in the list and not here is no longer needed: take it out.
    assert {path: names for path, names in deep.items() if names} == allowed
    assert list(allowed) == sorted(allowed)


def loaded(path: Path, known: set[str]) -> set[str]:
    """Modules of the package that one imports, when it is loaded or later, types apart."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    guarded = [n for n in ast.walk(tree) if isinstance(n, ast.If) and ast.unparse(n.test).endswith("TYPE_CHECKING")]
    types_only = {id(inner) for outer in guarded for inner in ast.walk(outer)}
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and id(node) not in types_only:
            found |= {
                f"{node.module}.{a.name}" if f"{node.module}.{a.name}" in known else node.module for a in node.names
            }
    return found & known


def test_no_cycle_inside_a_room_either() -> None:
    paths = modules()
    # Raises with the cycle, if there is one.
    order = graphlib.TopologicalSorter({name: loaded(path, set(paths)) - {name} for name, path in paths.items()})
    assert len(list(order.static_order())) == len(paths)


def test_the_map_for_newcomers_names_every_room() -> None:
    told = (PACKAGE.parent / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rooms_of = {path.relative_to(PACKAGE).parts[0].removesuffix(".py") for path in modules().values()}
    assert [room for room in sorted(rooms_of) if not room.startswith("__") and f"`{room}" not in told] == []
    assert told.count("\n") <= 150


def test_libraries_stay_with_their_owners() -> None:
    wrong = [
        f"{path.name} imports {name}"
        for room, path in rooms()
        for name in imports(path)
        if name.split(".")[0] in OWNERS and room != OWNERS[name.split(".")[0]]
    ]
    assert wrong == []


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
