"""What a reader of the package must take in: sizes and decisions of its syntax trees.

The size of code is the number of nodes of its syntax tree, without imports, annotations
and docstrings; a string counts its words. So line breaks and short names change
nothing, and code in a string is not free. A decision is an `if`, `for`, `while`,
`except` or `case`, a conditional expression, each further part of an `and` or `or`,
each `for` and `if` of a comprehension, and `map` and `filter`. The decisions of lambdas
and inner functions count for the outermost function, and the code outside functions
counts as one function, so that decisions cannot hide in a table of lambdas."""

from __future__ import annotations

import ast
import json
import re
import statistics
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import complexipy

RULES = {"C901": 10, "PLR0911": 6, "PLR0912": 12, "PLR0915": 50, "PLR0917": 5}
"""Rules of ruff, each with the largest number that it allows. PLR0917 counts the
parameters that can be given by position: an option that is named is no burden."""

COGNITIVE = 15
"""The largest cognitive complexity that complexipy allows for a function."""

DECISIONS = 10
"""The largest number of decisions of a function."""

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_BRANCHES = (
    ast.If,
    ast.IfExp,
    ast.For,
    ast.AsyncFor,
    ast.While,
    ast.ExceptHandler,
    ast.match_case,
)
_STATEMENTS = (
    ast.Assign,
    ast.AnnAssign,
    ast.AugAssign,
    ast.Return,
    ast.Expr,
    ast.Raise,
    ast.Assert,
)
_UNCOUNTED = {"annotation", "returns", "ctx", "type_comment", "type_params"}


class Function(NamedTuple):
    """One outermost function of a module, or the code outside its functions."""

    name: str
    decisions: int
    size: int


class Module(NamedTuple):
    """The measures of one file."""

    room: str
    size: int
    functions: list[Function]
    statements: list[int]
    """The size of each simple statement, condition and iterated value."""


def measure_module(path: Path, package: Path) -> Module:
    """Measure one file of a package."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    name = path.relative_to(package).as_posix()
    functions = [
        Function(f"{name}:{function}", decisions_below(node), size(node))
        for function, node in outermost_functions(tree)
    ]
    size_of_rest = size(tree) - sum(function.size for function in functions)
    decisions_of_rest = decisions_below(tree) - sum(
        function.decisions for function in functions
    )
    functions.append(Function(f"{name}:(module)", decisions_of_rest, size_of_rest))
    room = name.split("/")[0] if "/" in name else "(top)"
    return Module(room, size(tree), functions, list(statement_sizes(tree)))


def size(node: ast.AST) -> int:
    """Return the number of counted nodes of a tree; a string counts its words."""
    own = 1
    if isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes)):
        text = node.value
        words = text if isinstance(text, str) else text.decode("latin-1")
        own = max(1, len(re.findall(r"\w+", words)))
    return own + sum(size(child) for child in counted_children(node))


def counted_children(node: ast.AST) -> Iterator[ast.AST]:
    for field, value in ast.iter_fields(node):
        if field in _UNCOUNTED:
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not is_uncounted(child):
                yield child


def is_uncounted(node: ast.AST) -> bool:
    return isinstance(node, (ast.Import, ast.ImportFrom)) or is_docstring(node)


def is_docstring(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def decisions_below(node: ast.AST) -> int:
    """Return the number of decisions of a tree."""
    return sum(decisions_at(inner) for inner in ast.walk(node))


def decisions_at(node: ast.AST) -> int:
    if isinstance(node, _BRANCHES):
        return 1
    if isinstance(node, ast.BoolOp):
        return len(node.values) - 1
    if isinstance(node, ast.comprehension):
        return 1 + len(node.ifs)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return int(node.func.id in ("map", "filter"))
    return 0


def outermost_functions(node: ast.AST, name: str = "") -> Iterator[tuple[str, ast.AST]]:
    """Yield the functions that are not inside of another one, with the class's name."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, _FUNCTIONS):
            yield name + child.name, child
        elif isinstance(child, ast.ClassDef):
            yield from outermost_functions(child, f"{name}{child.name}.")
        else:
            yield from outermost_functions(child, name)


def statement_sizes(tree: ast.AST) -> Iterator[int]:
    for node in ast.walk(tree):
        if isinstance(node, _STATEMENTS) and not is_docstring(node):
            yield size(node)
        elif isinstance(node, (ast.If, ast.While)):
            yield size(node.test)
        elif isinstance(node, (ast.For, ast.AsyncFor)):
            yield size(node.iter)


class Measures(NamedTuple):
    """What the limits are compared with."""

    functions: dict[str, dict[str, int]]
    """By measure and function, each number that is over the limit of the measure."""
    rooms: dict[str, int]
    """The size of each room."""
    package: dict[str, float]
    """Numbers of the whole package."""


def measure(package: Path) -> Measures:
    """Measure a package."""
    paths = sorted(package.rglob("*.py"))
    modules = [measure_module(path, package) for path in paths]
    functions = [function for module in modules for function in module.functions]
    long_functions = [one for one in functions if one.decisions > DECISIONS]
    statements = [size for module in modules for size in module.statements]
    rooms: Counter[str] = Counter()
    for module in modules:
        rooms[module.room] += module.size
    over = {
        "decisions": {one.name: one.decisions for one in long_functions},
        "cognitive": cognitive_complexity(paths, package),
        **numbers_of_ruff(package),
    }
    share = sum(one.size for one in long_functions) / max(1, sum(rooms.values()))
    whole = {
        "median nodes of a statement": statistics.median(statements),
        "nodes of a statement, 90 %": statistics.quantiles(statements, n=10)[-1],
        "percent in functions with many decisions": round(100 * share, 1),
    }
    return Measures(over, dict(rooms), whole)


def cognitive_complexity(paths: list[Path], package: Path) -> dict[str, int]:
    """Return the functions that complexipy finds too complex, whatever comments say."""
    numbers: dict[str, int] = {}
    for path in paths:
        name = path.relative_to(package).as_posix()
        measured = complexipy.file_complexity(str(path), no_ignore=True)
        for function in measured.functions:
            if function.complexity > COGNITIVE:
                key = f"{name}:{function.name.replace('::', '.')}"
                numbers[key] = max(function.complexity, numbers.get(key, 0))
    return numbers


def numbers_of_ruff(package: Path) -> dict[str, dict[str, int]]:
    """Return, by rule of ruff, the functions over its limit, whatever comments say."""
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--ignore-noqa"]
    command += ["--select", ",".join(RULES), "--output-format", "json", "--exit-zero"]
    # PLR0917 is a rule of the preview.
    command += ["--preview", "--config", f"lint.mccabe.max-complexity={RULES['C901']}"]
    done = subprocess.run(
        [*command, str(package)], capture_output=True, text=True, check=True
    )
    numbers: dict[str, dict[str, int]] = {rule: {} for rule in RULES}
    for fault in json.loads(done.stdout):
        path = Path(fault["filename"])
        name = path.relative_to(package.resolve()).as_posix()
        key = f"{name}:{function_at(path, fault['location']['row'])}"
        number = int(re.findall(r"\((\d+) > \d+\)", fault["message"])[-1])
        of_rule = numbers[fault["code"]]
        of_rule[key] = max(number, of_rule.get(key, 0))
    return numbers


def function_at(path: Path, row: int) -> str:
    """Return the name of the outermost function with a row of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for name, node in outermost_functions(tree):
        if node.lineno <= row <= node.end_lineno:  # type: ignore[attr-defined]
            return name
    return "(module)"
