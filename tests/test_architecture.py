"""Imports only go down the shelves, and heavy libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "gyrodata"
SHELVES = {
    "errors": 0,
    "unit_grammar": -1,
    "units": 0,
    "quantities": 1,
    "physics": 1,
    "motion": 2,
    "readings": 2,
    "measurements": 3,
    "fitting": 4,
    "forecast": 5,
    "effects": 5,
    "model": 6,
    "comparisons": 5,
    "simulation": 5,
    "findings": 6,
    "results": 7,
    "benchmark": 8,
    "analysis": 8,
    "prediction": 7,
    "reporting": 9,
    "selfcheck": 8,
    "plotting": 9,
    "procedure": 9,
    "schema": 9,
    "grading": 10,
    "cli": 11,
    "__main__": 12,
}
OWNERS = {
    "pint": {"units"},
    "matplotlib": {"plotting"},
    "typer": {"cli"},
    "jinja2": {"reporting", "grading"},
    "yaml": {"grading"},
}


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


def test_libraries_stay_with_their_owners() -> None:
    wrong = [
        f"{path.name} imports {name}"
        for room, path in rooms()
        for name in imports(path)
        if name.split(".")[0] in OWNERS and room not in OWNERS[name.split(".")[0]]
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
