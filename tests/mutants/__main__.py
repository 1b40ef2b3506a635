"""The tests of the tests: ``python tests/mutants`` changes one thing in the package at a time, and sees who notices.

Each mutant is one node of a syntax tree made otherwise: a comparison, a sum, a product, a number, an ``and``, a
``not``, a condition. The tests of its room run on it, first those that are quick; a mutant that they all pass has
survived, and is told with its place. ``--room measurements`` takes some rooms, ``--count 40`` so many
mutants, ``--seed`` others. 1 if the share that was killed is below ``--least``.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
ROOMS = {
    "physics": ["physics", "test_predict.py", "stability"],
    "measurements": ["test_measurements.py", "test_slips.py", "test_analysis.py", "test_model.py", "test_hints.py",
                     "test_guard.py", "test_simulate.py", "readings/test_published_logs.py"],
    "fitting": ["test_fitting.py", "test_lines.py", "test_balance.py", "test_fit_many.py", "test_model.py",
                "test_guard.py", "test_analysis.py", "stability"],
    "readings": ["readings", "test_hints.py", "test_quantities.py", "test_check.py", "test_analysis.py"],
    "grading": ["grading", "test_grade_cli.py"],
}  # fmt: skip
"""Tests of each room, below ``tests/``."""

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


def changed(node: ast.AST) -> ast.AST | None:
    """Give a node made otherwise; None for one that says nothing of its own."""
    if isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
        return ast.Compare(node.left, [SWAPS[type(node.ops[0])](), *node.ops[1:]], node.comparators)  # type: ignore[list-item]
    if isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
        return ast.BinOp(node.left, SWAPS[type(node.op)](), node.right)  # type: ignore[arg-type]
    if isinstance(node, ast.BoolOp):
        return ast.BoolOp(SWAPS[type(node.op)](), node.values)  # type: ignore[arg-type]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        return node.operand
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return ast.Constant(not node.value)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return ast.Constant(node.value + 1 if isinstance(node.value, int) else 1.5 * node.value or 1.0)
    if isinstance(node, ast.IfExp):
        return ast.IfExp(node.test, node.orelse, node.body)
    return None


def spoken(tree: ast.AST) -> set[int]:
    """Nodes that are only read by people: annotations, what is raised, formats of a text."""
    quiet: list[ast.AST] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign) and node.annotation is not None:
            quiet.append(node.annotation)
        if isinstance(node, ast.FunctionDef):
            quiet += [one for one in (node.returns, *node.decorator_list) if one is not None]
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.FormattedValue | ast.Assert):
            quiet.append(node)
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            quiet.append(node)
    return {id(inner) for outer in quiet for inner in ast.walk(outer)}


def places(room: str) -> Iterator[tuple[Path, ast.AST, ast.AST]]:
    """Every node of a room that can be made otherwise, with what it becomes."""
    base = ROOT / "gyrodata" / room
    for path in sorted(base.rglob("*.py")) if base.is_dir() else [base.with_suffix(".py")]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        quiet = spoken(tree)
        for node in ast.walk(tree):
            other = None if id(node) in quiet else changed(node)
            if other is not None:
                yield path, node, other


def written(path: Path, node: ast.AST, other: ast.AST) -> tuple[str, str]:
    """Text of a module with one node in the place of another, and what it says there now."""
    lines = path.read_bytes().splitlines(keepends=True)
    starts = [sum(map(len, lines[:at])) for at in (node.lineno - 1, node.end_lineno - 1)]  # type: ignore[attr-defined]
    start, end = starts[0] + node.col_offset, starts[1] + node.end_col_offset  # type: ignore[attr-defined]
    whole, new = b"".join(lines), f"({ast.unparse(ast.fix_missing_locations(other))})"
    return (whole[:start] + new.encode() + whole[end:]).decode(), new


def survives(work: Path, room: str, limit: float) -> bool:
    """Run the tests of a room on a copy of everything; False as soon as one notices."""
    for tests in ROOMS[room]:
        line = [sys.executable, "-m", "pytest", "-x", "-q", "-n0", "-p", "no:cacheprovider", f"tests/{tests}"]
        environment = {**os.environ, "PYTHONPATH": str(work), "PYTHONDONTWRITEBYTECODE": "1", "HYPOTHESIS_SEED": "0"}
        try:
            done = subprocess.run(line, cwd=work, env=environment, capture_output=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return False
        if done.returncode:
            return False
    return True


def main() -> None:
    """Try mutants, and tell the survivors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--room", action="append", choices=ROOMS, help="several times; all if none is given")
    parser.add_argument("--count", type=int, default=20, help="mutants in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least", type=float, default=0.0, help="share that must be killed, 0 to 1")
    parser.add_argument("--limit", type=float, default=600.0, help="time for the tests in one file or folder [s]")
    options = parser.parse_args()
    choice = random.Random(options.seed)
    every = [(room, *place) for room in options.room or ROOMS for place in places(room)]
    chosen = choice.sample(every, min(options.count, len(every)))
    killed = 0
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "work"
        shutil.copytree(ROOT, work, ignore=shutil.ignore_patterns(".git", "__pycache__", ".*_cache"))
        for room, path, node, other in chosen:
            text, new = written(path, node, other)
            copy = work / path.relative_to(ROOT)
            copy.write_text(text, encoding="utf-8")
            lives = survives(work, room, options.limit)
            shutil.copyfile(path, copy)
            killed += not lives
            what = f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)[:60]} -> {new[:60]}"  # type: ignore[attr-defined]
            print(f"{'SURVIVED' if lives else 'killed  '} {what}", flush=True)
    print(f"{killed} of {len(chosen)} killed, of {len(every)} that there are")
    sys.exit(1 if killed < options.least * len(chosen) else 0)


if __name__ == "__main__":
    main()
