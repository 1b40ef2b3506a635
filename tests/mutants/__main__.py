"""The tests of the tests: ``python tests/mutants`` changes one thing in the package at a time, and sees who notices.

Each mutant is one node of a syntax tree made otherwise: a comparison, a sum, a product, a number, an ``and``, a
``not``, a condition. It meets the tests of its room that reach its line, the quickest first; one that they all pass
has survived, and is told with its place. ``--room measurements`` takes some rooms, ``--count 40`` so many mutants of
each, ``--seed`` others. 1 if the share that was killed is below ``--least`` in any room. Some survivors do the same as
the package, so that 100 % cannot be reached.

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

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


OPTIONS = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=--import-mode=importlib", "--capture=sys"]
"""Of every run: in one process, without the options of the project."""

EVERY_LINE = -1


class Known(NamedTuple):
    """What is known of a test from a run without a mutant."""

    seconds: float
    reached: dict[str, int]
    """Lines of each module, as the bits of a number."""


class Mutant(NamedTuple):
    """One node, and what stands there instead."""

    module: str
    """Below the package: "measurements/sources.py"."""
    where: str
    """Function or class that it stands in, "" outside of all."""
    at_import: bool
    """Whether the node is met when its module is loaded, and not in a function."""
    node: ast.AST
    other: ast.AST

    @property
    def change(self) -> str:
        return f"{ast.unparse(self.node)} -> {ast.unparse(ast.fix_missing_locations(self.other))}"


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
    """Nodes that change nothing: annotations, what is raised, formats of a text, lengths of what is zipped."""
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
        if isinstance(node, ast.keyword) and node.arg == "strict":
            quiet.append(node)
    return {id(inner) for outer in quiet for inner in ast.walk(outer)}


def mutants(room: str) -> Iterator[Mutant]:
    """Every node of a room that can be made otherwise, with what it becomes."""
    base = ROOT / "gyrodata"
    for path in (path for part in ROOMS[room][0] for path in sorted({base / part, *(base / part).rglob("*.py")})):
        if path.suffix != ".py":
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        quiet = spoken(tree)

        def within(parent: ast.AST, where: str, outside: bool, module: str, quiet: set[int]) -> Iterator[Mutant]:
            for name, value in ast.iter_fields(parent):
                inside = isinstance(parent, ast.FunctionDef | ast.Lambda) and name == "body"
                for node in value if isinstance(value, list) else [value]:
                    if not isinstance(node, ast.AST):
                        continue
                    other = None if id(node) in quiet else changed(node)
                    if other is not None:
                        yield Mutant(module, where, outside and not inside, node, other)
                    named = isinstance(node, ast.FunctionDef | ast.ClassDef)
                    deeper = f"{where}.{node.name}".lstrip(".") if named else where  # type: ignore[attr-defined]
                    yield from within(node, deeper, outside and not inside, module, quiet)

        yield from within(tree, "", True, str(path.relative_to(base)), quiet)


def written(whole: bytes, mutant: Mutant) -> str:
    """Text of a module with one node in the place of another, and every line below it where it was."""
    node: Any = mutant.node
    lines = whole.splitlines(keepends=True)
    starts = [sum(map(len, lines[: at - 1])) for at in (node.lineno, node.end_lineno)]
    new = ast.unparse(ast.fix_missing_locations(mutant.other)) + "\n" * (node.end_lineno - node.lineno)
    return (
        whole[: starts[0] + node.col_offset] + f"({new})".encode() + whole[starts[1] + node.end_col_offset :]
    ).decode()


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
            known.__code__ = next(
                (to for code, to in zip(old, new, strict=True) if code == known.__code__), known.__code__
            )
        elif isinstance(known, functools._lru_cache_wrapper):
            known.cache_clear()


class Bench:
    """A plugin of pytest: it runs the tests that were collected on mutants, each in a process of its own."""

    def __init__(self, work: Path, told: Callable[[Bench], None]) -> None:
        self.work, self.told = work, told

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.items = {item.nodeid: item for item in session.items}
        self.known = self.measured()
        self.told(self)
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
        files = {
            str(path.relative_to(ROOT)): hashlib.sha256(path.read_bytes()).hexdigest()
            for folder in ("gyrodata", "tests")
            for path in (ROOT / folder).rglob("*.py")
        }
        same = {name for name, digest in files.items() if before["files"].get(name) == digest}
        known = {name: Known(*test) for name, test in before["tests"].items() if name.partition("::")[0] in same}
        for test in known.values():
            for module in test.reached:
                if f"gyrodata/{module}" not in same:
                    test.reached[module] = EVERY_LINE
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

        seen, seconds = Coverage(data_file=None, source=[str(self.work / "gyrodata")], config_file=False), {}

        @contextlib.contextmanager
        def noted(name: str) -> Iterator[None]:
            seen.switch_context(name)
            begin = time.process_time()
            yield
            seconds[name] = round(time.process_time() - begin, 4)

        seen.start()
        whole = self.passed(names, noted)
        seen.stop()
        reached: dict[str, dict[str, int]] = {name: {} for name in seconds}
        data = seen.get_data()
        for path in data.measured_files():
            module = str(Path(path).relative_to(self.work / "gyrodata"))
            for line, contexts in data.contexts_by_lineno(path).items():
                for name in reached.keys() & set(contexts):
                    reached[name][module] = reached[name].get(module, 0) | 1 << line
        found.write_text(json.dumps({name: (seconds[name], reached[name]) for name in seconds}))
        return whole

    def survives(self, mutant: Mutant, budget: float) -> bool:
        """Try a mutant on the tests that reach it."""
        node: Any = mutant.node
        lines = sum(1 << line for line in range(node.lineno, node.end_lineno + 1))
        here = {name: test.reached[mutant.module] for name, test in self.known.items() if mutant.module in test.reached}
        names = [name for name, reached in here.items() if reached & lines]
        # Those that stand in the room's own file, which is named first, notice sooner than the cheapest of all.
        files = {name: at for at, name in enumerate(dict.fromkeys(name.partition("::")[0] for name in self.items))}
        names.sort(
            key=lambda name: (self.known[name].seconds > 1, files[name.partition("::")[0]], self.known[name].seconds)
        )
        # What is done when a module is loaded is known from no test: any that stands beside one that meets the module
        # may notice; any of all where it has no function to be met.
        anew = mutant.at_import or not names
        if anew:
            met = {name.partition("::")[0] for name in here}
            names = [name for name in self.items if name.partition("::")[0] in met or not met]
            names.sort(key=lambda name: self.known[name].seconds)
        spent = itertools.accumulate(self.known[name].seconds + 0.005 for name in names)
        names = [name for name, sum_ in zip(names, spent, strict=True) if sum_ < budget]

        @contextlib.contextmanager
        def in_time(name: str) -> Iterator[None]:
            used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
            most = int(used + 5 + 10 * self.known[name].seconds)
            resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
            yield

        def tried() -> bool:
            if anew:
                for name in [name for name, one in sys.modules.items() if self.own(one)]:
                    del sys.modules[name]
                resource.setrlimit(resource.RLIMIT_CPU, (int(60 + 10 * budget), resource.RLIM_INFINITY))
                return pytest.main([*OPTIONS, "-x", *names]) == 0
            put_in_place(path, before.decode(), after)
            next(iter(self.items.values())).config.pluginmanager.unregister(name="terminalreporter")
            return self.passed(names, in_time)

        path = self.work / "gyrodata" / mutant.module
        before = path.read_bytes()
        after = written(before, mutant)
        path.write_text(after, encoding="utf-8")
        try:
            return self.forked(tried, 120 + 20 * budget) if names else True
        finally:
            shutil.copy2(ROOT / "gyrodata" / mutant.module, path)

    def own(self, module: object) -> bool:
        """Whether a module is one of the package or of its tests."""
        return str(getattr(module, "__file__", None) or "").startswith(str(self.work))


def main() -> None:
    """Try mutants, and tell the survivors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--room", action="append", choices=ROOMS, help="several times; all if none is given")
    parser.add_argument("--count", type=int, default=20, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least", type=float, default=0.0, help="share of each room that must be killed, 0 to 1")
    parser.add_argument("--budget", type=float, default=20.0, help="time for the tests on one mutant [s]")
    options = parser.parse_args()
    rooms: list[str] = options.room or list(ROOMS)
    good = []

    def try_all(bench: Bench) -> None:
        for room in rooms:
            every = list(mutants(room))
            chosen = random.Random(options.seed).sample(every, min(options.count, len(every)))
            counts = dict.fromkeys(("killed", "SURVIVED"), 0)
            for mutant in chosen:
                verdict = "SURVIVED" if bench.survives(mutant, options.budget) else "killed"
                counts[verdict] += 1
                place = f"{mutant.module}:{mutant.node.lineno}: {mutant.where}"  # type: ignore[attr-defined]
                print(f"{verdict:8} {place}: {mutant.change}", flush=True)
            share = counts["killed"] / max(1, len(chosen))
            good.append(share >= options.least)
            told = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
            print(
                f"{room}, seed {options.seed}: {share:.1%} killed ({told}; of {len(every)} that there are)", flush=True
            )

    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "work"
        shutil.copytree(ROOT, work, ignore=shutil.ignore_patterns(".git", ".venv", ".*_cache"))
        os.chdir(work)
        os.environ |= {"PYTHONPATH": str(work), "HYPOTHESIS_SEED": "0"}
        sys.path[:] = [str(work), *(path for path in sys.path if Path(path).resolve() not in (ROOT, ROOT / "tests"))]
        tests = dict.fromkeys(
            f"tests/{name}" for room in rooms for name in ROOMS[room][1] if Path("tests", name).exists()
        )
        done = pytest.main([*OPTIONS, *tests], plugins=[Bench(work, try_all)])
        os.chdir(ROOT)
    sys.exit(done or not all(good))


if __name__ == "__main__":
    main()
