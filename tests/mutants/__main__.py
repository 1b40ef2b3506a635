"""The tests of the tests: ``python tests/mutants`` changes one thing in the package at a time, and sees who notices.

Each mutant is one node of a syntax tree made otherwise: a comparison, a sum, a product, a number, an ``and``, a
``not``, a condition. It meets the tests of its room that reach its line, the quickest first; one that they all pass
has survived, and is printed with its place. ``--count 300`` draws so many from all rooms together, in proportion to
their number; ``--room measurements`` draws from some rooms only, ``--seed`` draws others. The exit code is 1 if the
share that was killed is below ``--least``. Some survivors do the same as the package: 100 % cannot be reached.

Which test reaches which line is measured first, and kept in ``.mutants.json``: only tests that have changed since are
run again. Every mutant is a process forked from one in which all tests are ready to run.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import functools
import gc
import hashlib
import itertools
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).parent.parent.parent
ROOMS = {
    "measurements": (["measurements"], [
        "test_measurements.py", "test_slips.py", "test_analysis.py", "test_model.py", "test_hints.py", "test_guard.py",
        "test_check.py", "test_simulate.py", "readings", "gates"]),
    "fitting": (["fitting"], [
        "test_fitting.py", "test_lines.py", "test_selfcheck.py", "test_model.py", "test_guard.py",
        "test_hints.py", "test_analysis.py", "stability", "gates"]),
    "readings": (["readings"], [
        "readings", "test_hints.py", "test_quantities.py", "test_check.py", "test_analysis.py", "test_units.py",
        "test_options_hints.py", "test_measurements.py", "test_misread_values.py", "test_wrong_cells.py", "gates"]),
    "physics": (["physics.py", "motion"], [
        "physics", "motion", "test_predict.py", "test_model.py", "test_comparisons.py", "test_simulate.py", "stability",
        "gates"]),
    "grading": (["grading"], ["grading", "test_grade_cli.py", "gates"]),
}  # fmt: skip
"""What of the package a room is, and its tests."""

PAIRS = [
    (ast.Lt, ast.LtE), (ast.Gt, ast.GtE), (ast.Eq, ast.NotEq), (ast.In, ast.NotIn), (ast.Is, ast.IsNot),
    (ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.And, ast.Or),
]  # fmt: skip
SWAPS: dict[Any, Any] = {ast.Pow: ast.Mult, **dict(PAIRS), **{b: a for a, b in PAIRS}}
OPTIONS = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=--import-mode=importlib", "--capture=sys"]
"""Of every run: in one process, without the options of the project."""

EVERY_LINE = -1


class Known(NamedTuple):
    """What is known of a test: its time without a mutant, and the lines that it reaches as bits of a number."""

    seconds: float
    reached: dict[str, int]


class Mutant(NamedTuple):
    """One node of a module below the package, the function or class around it, and what takes its place."""

    module: str
    where: str
    at_import: bool
    """Whether the node is met when its module is loaded, and not in a function."""
    node: Any
    other: ast.expr

    def __str__(self) -> str:
        other = ast.unparse(ast.fix_missing_locations(self.other))
        return f"{self.module}:{self.node.lineno}: {self.where}: {ast.unparse(self.node)} -> {other}"


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
            return ast.Constant(value + 1)
        case ast.Constant(float(value)):
            return ast.Constant(1.5 * value or 1.0)
        case ast.IfExp(test, body, orelse):
            return ast.IfExp(test, orelse, body)
    return None


def is_quiet(node: ast.AST) -> bool:
    """Whether a node and all in it change nothing: what is raised, formats of a text, lengths of what is zipped."""
    if isinstance(node, ast.If):
        return ast.unparse(node.test).endswith("TYPE_CHECKING")
    said = isinstance(node, ast.Raise | ast.JoinedStr | ast.FormattedValue | ast.Assert)
    return said or (isinstance(node, ast.keyword) and node.arg == "strict")


def mutants(room: str) -> Iterator[Mutant]:
    """Every node of a room that can be made otherwise, with what it becomes."""

    def within(parent: ast.AST, module: str, where: str, outside: bool) -> Iterator[Mutant]:
        for name, value in ast.iter_fields(parent):
            inside = isinstance(parent, ast.FunctionDef | ast.Lambda) and name == "body"
            for node in value if isinstance(value, list) else [value]:
                # Annotations and decorators change nothing either.
                aside = name in ("annotation", "returns", "decorator_list")
                if aside or not isinstance(node, ast.AST) or is_quiet(node):
                    continue
                if other := changed(node):
                    yield Mutant(module, where, outside and not inside, node, other)
                named = [where, node.name] if isinstance(node, ast.FunctionDef | ast.ClassDef) else [where]
                yield from within(node, module, ".".join(named).lstrip("."), outside and not inside)

    base = ROOT / "gyrodata"
    for part in ROOMS[room][0]:
        for path in sorted({*base.glob(part), *(base / part).rglob("*.py")}):
            if path.suffix == ".py":
                yield from within(ast.parse(path.read_text(encoding="utf-8")), str(path.relative_to(base)), "", True)


def written(whole: bytes, mutant: Mutant) -> str:
    """Text of a module with one node in the place of another, and every line below it where it was."""
    node, lines = mutant.node, whole.splitlines(keepends=True)
    start, end = (sum(map(len, lines[: at - 1])) for at in (node.lineno, node.end_lineno))
    new = f"({ast.unparse(ast.fix_missing_locations(mutant.other))}" + "\n" * (node.end_lineno - node.lineno) + ")"
    return (whole[: start + node.col_offset] + new.encode() + whole[end + node.end_col_offset :]).decode()


def parts(code: CodeType) -> Iterator[CodeType]:
    """A code object, and all that are in it."""
    yield code
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from parts(part)


def put_in_place(path: Path, before: str, after: str) -> None:
    """Give the functions of a module that is loaded the code of its mutant; what any has remembered is forgotten."""
    old, new = (list(parts(compile(text, path, "exec", dont_inherit=True))) for text in (before, after))
    for known in gc.get_objects():
        if isinstance(known, FunctionType) and known.__code__.co_filename == str(path):
            pairs = zip(old, new, strict=True)
            known.__code__ = next((to for code, to in pairs if code == known.__code__), known.__code__)
        elif isinstance(known, functools._lru_cache_wrapper):
            known.cache_clear()


class Bench:
    """A plugin of pytest: it runs the tests that were collected on mutants, each in a process of its own."""

    def __init__(self, work: Path, then: Callable[[Bench], None]) -> None:
        self.work, self.then = work, then

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.items = {item.nodeid: item for item in session.items}
        self.known = self.measured()
        self.then(self)
        return True

    def forked(self, work: Callable[[], bool], limit: float) -> bool:
        """What a process of its own finds out; False if it comes to no end."""
        child = os.fork()
        if child == 0:
            os.setsid()
            null = os.open(os.devnull, os.O_RDWR)
            for stream in (0, 1, 2):
                os.dup2(null, stream)
            good = False
            with contextlib.suppress(BaseException):
                good = work()
            os._exit(0 if good else 1)
        end = time.monotonic() + limit
        while time.monotonic() < end:
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                return status == 0
            time.sleep(0.01)
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return False

    def passed(self, names: Sequence[str], around: Callable[[str], contextlib.AbstractContextManager[None]]) -> bool:
        """Run tests in this process until one fails."""
        for name, after in zip(names, [*names[1:], None], strict=True):
            item = self.items[name]
            with around(name):
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=after and self.items[after])
            if item.session.testsfailed:
                return False
        return True

    def measured(self) -> dict[str, Known]:
        """Which test reaches which lines, and its time; from an earlier run if it has not changed."""
        kept = ROOT / ".mutants.json"
        before = json.loads(kept.read_text()) if kept.exists() else {"files": {}, "tests": {}}
        paths = [path for folder in ("gyrodata", "tests") for path in (ROOT / folder).rglob("*.py")]
        files = {str(path.relative_to(ROOT)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}
        same = {name for name, digest in files.items() if before["files"].get(name) == digest}
        known = {name: Known(*test) for name, test in before["tests"].items() if name.partition("::")[0] in same}
        for test in known.values():
            test.reached.update({name: EVERY_LINE for name in test.reached if f"gyrodata/{name}" not in same})
        missing = [name for name in self.items if name not in known]
        if missing:
            print(f"{len(missing)} tests run once, to see what they reach", flush=True)
            found = self.work / "found.json"
            if not self.forked(lambda: self.traced(missing, found), 86400.0):
                sys.exit("a test fails without any mutant")
            known |= {name: Known(*test) for name, test in json.loads(found.read_text()).items()}
            kept.write_text(json.dumps({"files": files, "tests": known}))
        return {name: test for name, test in known.items() if name in self.items}

    def traced(self, names: Sequence[str], found: Path) -> bool:
        """Run tests while their lines are noted."""
        from coverage import Coverage

        seen = Coverage(data_file=None, source=[str(self.work / "gyrodata")], config_file=False)
        known: dict[str, Known] = {}

        @contextlib.contextmanager
        def noted(name: str) -> Iterator[None]:
            seen.switch_context(name)
            begin = time.process_time()
            yield
            known[name] = Known(round(time.process_time() - begin, 4), {})

        seen.start()
        whole = self.passed(names, noted)
        seen.stop()
        data = seen.get_data()
        for path in data.measured_files():
            module = str(Path(path).relative_to(self.work / "gyrodata"))
            for line, contexts in data.contexts_by_lineno(path).items():
                for name in known.keys() & set(contexts):
                    known[name].reached[module] = known[name].reached.get(module, 0) | 1 << line
        found.write_text(json.dumps(known))
        return whole

    def chosen(self, mutant: Mutant, budget: float) -> tuple[bool, list[str]]:
        """Whether a mutant needs the package loaded anew, and the tests that it meets, in their order."""
        lines = sum(1 << line for line in range(mutant.node.lineno, mutant.node.end_lineno + 1))
        here = {name: test.reached[mutant.module] for name, test in self.known.items() if mutant.module in test.reached}
        names = [name for name, reached in here.items() if reached & lines]
        # Those in the room's own file, which is named first, notice sooner than the cheapest of all.
        files = {name: at for at, name in enumerate(dict.fromkeys(name.partition("::")[0] for name in self.items))}
        cost = {name: test.seconds for name, test in self.known.items()}
        names.sort(key=lambda name: (cost[name] > 1, files[name.partition("::")[0]], cost[name]))
        # What is done when a module is loaded is known from no test: any in the file of one that meets the module may
        # notice; any of all where it has no function to be met.
        anew = mutant.at_import or not names
        if anew:
            met = {name.partition("::")[0] for name in here}
            names = sorted((name for name in cost if name.partition("::")[0] in met or not met), key=cost.__getitem__)
        spent = itertools.accumulate(cost[name] + 0.005 for name in names)
        return anew, [name for name, sum_ in zip(names, spent, strict=True) if sum_ < budget]

    def survives(self, mutant: Mutant, budget: float) -> bool:
        """Try a mutant on the tests that reach it."""
        anew, names = self.chosen(mutant, budget)
        path = self.work / "gyrodata" / mutant.module
        before = path.read_bytes()
        after = written(before, mutant)

        def limit(seconds: float) -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + seconds), resource.RLIM_INFINITY))

        @contextlib.contextmanager
        def in_time(name: str) -> Iterator[None]:
            limit(6 + 10 * self.known[name].seconds)
            yield

        def tried() -> bool:
            if anew:
                for name, module in list(sys.modules.items()):
                    if str(getattr(module, "__file__", None) or "").startswith(str(self.work)):
                        del sys.modules[name]
                limit(60 + 10 * budget)
                return pytest.main([*OPTIONS, "-x", *names]) == 0
            put_in_place(path, before.decode(), after)
            next(iter(self.items.values())).config.pluginmanager.unregister(name="terminalreporter")
            return self.passed(names, in_time)

        path.write_text(after, encoding="utf-8")
        try:
            return self.forked(tried, 120 + 20 * budget) if names else True
        finally:
            shutil.copy2(ROOT / "gyrodata" / mutant.module, path)


def main() -> None:
    """Try mutants, and print which of them survive."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--room", action="append", choices=ROOMS, help="several times; all if none is given")
    parser.add_argument("--count", type=int, default=100, help="mutants of all these rooms together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least", type=float, default=0.0, help="share that must be killed, 0 to 1")
    parser.add_argument("--budget", type=float, default=20.0, help="time for the tests on one mutant [s]")
    options = parser.parse_args()
    rooms: list[str] = options.room or list(ROOMS)
    every = [(room, mutant) for room in rooms for mutant in mutants(room)]
    drawn = random.Random(options.seed).sample(every, min(options.count, len(every)))
    killed: list[str] = []

    def try_all(bench: Bench) -> None:
        for room, mutant in sorted(drawn, key=lambda pair: rooms.index(pair[0])):
            survived = bench.survives(mutant, options.budget)
            killed.extend([room] * (not survived))
            print(f"{'SURVIVED' if survived else 'killed':8} {mutant}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "work"
        shutil.copytree(ROOT, work, ignore=shutil.ignore_patterns(".git", ".venv", ".*_cache"))
        os.chdir(work)
        os.environ |= {"PYTHONPATH": str(work), "HYPOTHESIS_SEED": "0"}
        sys.path[:] = [str(work), *(path for path in sys.path if Path(path).resolve() not in (ROOT, ROOT / "tests"))]
        tests = dict.fromkeys(f"tests/{name}" for room in rooms for name in ROOMS[room][1])
        done = pytest.main([*OPTIONS, *(test for test in tests if Path(test).exists())], plugins=[Bench(work, try_all)])
        os.chdir(ROOT)
    of = {room: sum(one == room for one, _ in drawn) for room in rooms}
    told = ", ".join(f"{room} {killed.count(room)} of {count}" for room, count in of.items())
    share = f"{len(killed) / max(1, len(drawn)):.1%} of {len(drawn)} mutants killed"
    print(f"seed {options.seed}: {share}, of {len(every)} that there are: {told}")
    sys.exit(done or len(killed) < options.least * len(drawn))


if __name__ == "__main__":
    main()
