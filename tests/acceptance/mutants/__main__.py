"""The tests of the tests: ``python tests/acceptance/mutants`` changes one thing in the
package at a time, and sees who notices.

Each mutant is one changed node of a syntax tree: a comparison, a sum, a product, a
number, an ``and``, a ``not``, a condition. A comparison is negated and a number of at
least ten is doubled, because no test checks the last digit of a limit. First the tests
that reach the line of the mutant run, those of its room before the others, the quickest
first; then the gates run. A mutant that passes all of them has survived, and is printed
with its place. ``--count 300`` draws so many from all rooms together, in proportion to
their number; ``--room measurements`` draws from some rooms only, ``--seed`` draws
others. The exit code is 1 if the share that was killed is below ``--least``. Some
survivors do the same as the package: 100 % cannot be reached.

All tests run once at the beginning, which shows which lines each of them reaches. The
tests of a mutant run in a process forked from one in which all libraries are loaded."""

from __future__ import annotations

import argparse
import ast
import contextlib
import io
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parents[3]
ROOMS = {
    "measurements": ("measurements", "measurements judging readings trials"),
    "fitting": ("fitting", "fitting judging trials"),
    "readings": ("readings", "readings quantities judging cli"),
    "physics": ("physics", "physics judging trials fitting"),
    "grading": ("grading", "grading"),
}
"""The folder of each room in the package, and the folders of its tests."""

PAIRS = [
    (ast.Lt, ast.GtE),
    (ast.Gt, ast.LtE),
    (ast.Eq, ast.NotEq),
    (ast.In, ast.NotIn),
    (ast.Is, ast.IsNot),
    (ast.Add, ast.Sub),
    (ast.Mult, ast.Div),
    (ast.And, ast.Or),
]
SWAPS: dict[Any, Any] = {ast.Pow: ast.Mult, **dict(PAIRS), **{b: a for a, b in PAIRS}}
OPTIONS = [
    "-q",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:xdist",
    "-o",
    "addopts=--import-mode=importlib",
    "--capture=sys",
]
"""Of every run: in one process, without the options of the project."""
OUTSIDE = ("acceptance",)
"""What is not run on a mutant: it starts processes of its own, or comes later."""
MOST_FAILED = 5
"""If more tests than this fail without a mutant, nothing is tried."""
BUDGET = 30.0
"""Time for the tests on one mutant [s]."""
GATES = ("class", "json", "printed", "published", "what-if", "logs")
"""The gates that a mutant meets after the tests, the quickest first."""


class Mutant(NamedTuple):
    """One node of a module below the package, and what takes its place."""

    module: str
    at_import: bool
    """Whether the node is met when its module is loaded, and not in a function."""
    node: Any
    other: str


def changed(node: ast.AST) -> ast.expr | None:
    """Give a node made otherwise; None for one that says nothing of its own."""
    match node:
        case ast.Compare(left, [op, *ops], values) if type(op) in SWAPS:
            return ast.Compare(left, [SWAPS[type(op)](), *ops], values)
        case ast.BinOp(left, op, right) if type(op) in SWAPS:
            return ast.BinOp(left, SWAPS[type(op)](), right)
        case ast.BoolOp(op, values):
            return ast.BoolOp(SWAPS[type(op)](), values)
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            return operand
        case ast.Constant(bool(value)):
            return ast.Constant(not value)
        case ast.Constant(int(value)):
            return ast.Constant(value + 1 if value < 10 else 2 * value)
        case ast.Constant(float(value)):
            return ast.Constant(2 * value or 1.0)
        case ast.IfExp(test, body, orelse):
            return ast.IfExp(test, orelse, body)
    return None


def is_quiet(node: ast.AST) -> bool:
    """Whether a node and all in it change nothing: what is raised, formats of a text,
    lengths of what is zipped.
    """
    said = isinstance(node, ast.Raise | ast.JoinedStr | ast.FormattedValue | ast.Assert)
    return said or ast.unparse(node).startswith(("strict=", "if TYPE_CHECKING:"))


def mutants(room: str) -> Iterator[Mutant]:
    """Every node of a room that can be made otherwise, with what it becomes."""

    def within(parent: ast.AST, module: str, outside: bool) -> Iterator[Mutant]:
        for name, value in ast.iter_fields(parent):
            at_import = outside and not (
                isinstance(parent, ast.FunctionDef | ast.Lambda) and name == "body"
            )
            for node in value if isinstance(value, list) else [value]:
                # Annotations, decorators and what a class is declared as
                # ("frozen=True") change nothing either.
                declares = name in ("annotation", "returns", "decorator_list")
                declares |= name == "keywords" and isinstance(parent, ast.ClassDef)
                if declares or not isinstance(node, ast.AST):
                    continue
                if not is_quiet(node):
                    if other := changed(node):
                        yield Mutant(
                            module,
                            at_import,
                            node,
                            ast.unparse(ast.fix_missing_locations(other)),
                        )
                    yield from within(node, module, at_import)

    base = ROOT / "gyrodata"
    for part in ROOMS[room][0].split():
        for path in (
            [base / part]
            if part.endswith(".py")
            else sorted((base / part).rglob("*.py"))
        ):
            yield from within(
                ast.parse(path.read_text(encoding="utf-8")),
                str(path.relative_to(base)),
                True,
            )


def written(path: Path, mutant: Mutant, at: int) -> None:
    """Write a module with one node in the place of another, and with a time of its own:
    its byte code is not kept.
    """
    whole, node = path.read_bytes(), mutant.node
    lines = whole.splitlines(keepends=True)
    start, end = (
        sum(map(len, lines[: line - 1])) for line in (node.lineno, node.end_lineno)
    )
    new = f"({mutant.other})".encode()
    path.write_bytes(
        whole[: start + node.col_offset] + new + whole[end + node.end_col_offset :]
    )
    os.utime(path, (at, at))


class Chosen(list[str]):
    """A plugin of pytest: the tests that are run, in their order."""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        known = {item.nodeid: item for item in items}
        items[:] = [known[name] for name in self]


class Traced:
    """A plugin of pytest: it notes the time of each test, and the lines of the package
    that it reaches.
    """

    def __init__(self) -> None:
        from coverage import Coverage

        self.seen = Coverage(data_file=None, source=["gyrodata"], config_file=False)
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.add(report.nodeid)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.seen.switch_context(item.nodeid)
        begin = time.process_time()
        try:
            return (yield)
        finally:
            self.seconds[item.nodeid] = time.process_time() - begin


def forked(work: Callable[[], bool], limit: float) -> bool:
    """What a process of its own finds out, for which the package and the tests are new;
    False if it does not end.
    """
    child = os.fork()
    if child == 0:
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        good = False
        with contextlib.suppress(BaseException):
            for name, module in list(sys.modules.items()):
                if str(getattr(module, "__file__", None) or "").startswith(
                    str(Path.cwd())
                ):
                    del sys.modules[name]
            good = work()
        os._exit(0 if good else 1)
    killer = threading.Timer(limit, os.killpg, (child, signal.SIGKILL))
    killer.start()
    status = os.waitpid(child, 0)[1]
    killer.cancel()
    return status == 0


def of_room(mutant: Mutant, test: str) -> bool:
    """Whether a test belongs to a room of which the mutant's module is a part."""
    file = test.partition("::")[0]
    rooms = (
        words.split()
        for part, words in ROOMS.values()
        if any(map(mutant.module.startswith, part.split()))
    )
    return any(file.startswith(f"tests/{word}/") for words in rooms for word in words)


def reached(
    drawn: Sequence[Mutant], tests: Sequence[str]
) -> list[list[tuple[float, str]]]:
    """Run all tests once: which of them reach each mutant, with their times."""

    def traced() -> bool:
        plugin = Traced()
        plugin.seen.start()
        code = pytest.main([*OPTIONS, *tests], plugins=[plugin])
        plugin.seen.stop()
        if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
            return False
        # A test that measures time may fail because of the tracing: it is left out.
        found, of = (
            [],
            {
                name: spent
                for name, spent in plugin.seconds.items()
                if name not in plugin.failed
            },
        )
        for one in drawn:
            known = plugin.seen.get_data().contexts_by_lineno(
                str(Path("gyrodata", one.module).absolute())
            )
            lines = (
                known
                if one.at_import
                else range(one.node.lineno, one.node.end_lineno + 1)
            )
            names = {name for line in lines for name in known.get(line, ())} & set(of)
            # Where no test meets a module after it is loaded, any test may notice.
            met = names or of if one.at_import else names
            found.append(
                [
                    (of[name], name)
                    for name in sorted(
                        met, key=lambda name: (not of_room(one, name), of[name])
                    )
                ]
            )
        Path("found.json").write_text(json.dumps([found, sorted(plugin.failed)]))
        return len(plugin.failed) <= MOST_FAILED

    done = forked(traced, 86400.0)
    if not Path("found.json").exists():
        sys.exit("the tests cannot be collected")
    found, failed = json.loads(Path("found.json").read_text())
    print(
        "".join(
            f"left out, because it fails without a mutant: {name}\n" for name in failed
        ),
        end="",
        flush=True,
    )
    if not done:
        sys.exit("too many tests fail without a mutant")
    return found  # type: ignore[no-any-return]


def pass_gates() -> bool:
    """Run the gates of the working directory, until one differs, each in a new process.

    A fork has loaded what the tests load, and the gates compare every letter.
    """
    command = [sys.executable, "tests/acceptance/gates", "--only"]
    return all(
        subprocess.run([*command, name], capture_output=True, check=False).returncode
        == 0
        for name in GATES
    )


def survives(mutant: Mutant, at: int, tests: Sequence[tuple[float, str]]) -> bool:
    """Try a mutant on the tests that reach it, in the working directory."""
    spent = itertools.accumulate(seconds + 0.005 for seconds, _ in tests)
    chosen = [
        test for test, so_far in zip(tests, spent, strict=True) if so_far < BUDGET
    ]
    path, names = Path("gyrodata", mutant.module), Chosen(name for _, name in chosen)
    written(path, mutant, at)
    line = [*OPTIONS, "-x", *dict.fromkeys(name.partition("::")[0] for name in names)]
    try:
        passed = not names or forked(
            lambda: pytest.main(line, plugins=[names]) == 0, 60 + 5 * BUDGET
        )
        has_gates = Path("tests", "acceptance", "gates").exists()
        return passed and (not has_gates or pass_gates())
    finally:
        shutil.copy2(ROOT / path, path)


def main() -> None:
    """Try mutants, and print which of them survive."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--room",
        action="append",
        choices=ROOMS,
        help="several times; all if none is given",
    )
    parser.add_argument(
        "--count", type=int, default=100, help="mutants of all these rooms together"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--least", type=float, default=0.0, help="share that must be killed, 0 to 1"
    )
    options = parser.parse_args()
    rooms: list[str] = options.room or list(ROOMS)
    every = [mutant for room in rooms for mutant in mutants(room)]
    drawn = random.Random(options.seed).sample(every, min(options.count, len(every)))
    killed = 0
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder).resolve() / "work"
        shutil.copytree(
            ROOT, work, ignore=shutil.ignore_patterns(".git", ".venv", ".*_cache")
        )
        os.chdir(work)
        os.environ |= {"PYTHONPATH": str(work), "HYPOTHESIS_SEED": "0"}
        sys.path[:] = [
            str(work),
            *(
                path
                for path in sys.path
                if not Path(path).resolve().is_relative_to(ROOT / "tests")
                and Path(path).resolve() != ROOT
            ),
        ]
        tests = ["tests", *(f"--ignore=tests/{name}" for name in OUTSIDE)]
        # Loads all libraries. pytest keeps the classes of warnings that its filters
        # name; those of this package are loaded anew for each mutant.
        with contextlib.redirect_stdout(io.StringIO()):
            pytest.main([*OPTIONS, "-o", "filterwarnings=", "--collect-only", *tests])
        reaching = reached(drawn, tests)
        for at, (mutant, known) in enumerate(zip(drawn, reaching, strict=True), 1):
            survived = survives(mutant, at, known)
            killed += not survived
            change = (
                f"{mutant.module}:{mutant.node.lineno}: {ast.unparse(mutant.node)} -> "
                f"{mutant.other}"
            )
            print(f"{'SURVIVED' if survived else 'killed':8} {change}", flush=True)
        os.chdir(ROOT)
    share = f"{killed / max(1, len(drawn)):.1%} of {len(drawn)} mutants killed"
    print(f"seed {options.seed}: {share}, of {len(every)} that there are")
    sys.exit(killed < options.least * len(drawn))


if __name__ == "__main__":
    main()
