"""The regular expressions of the package, and their time for long texts.

``python tests/support/hostile_patterns.py [PACKAGE]`` records what a package gives to `re` for some
logs and answers, adds the patterns that the source shows, and tries each of them, with
its method, on long hostile texts. It writes a line for each pattern whose time grows
faster than the text, and for each call of `re` whose pattern is unknown.
"""

from __future__ import annotations

import ast
import contextlib
import importlib
import io
import pkgutil
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, NamedTuple

COMPILE = re.compile
METHODS = (
    "match",
    "fullmatch",
    "search",
    "sub",
    "subn",
    "split",
    "findall",
    "finditer",
)
FLAGS_AT = {"sub": 3, "subn": 3, "split": 2}
"""How many positional arguments come between the pattern and the flags, if not one."""
SIZES = 200, 2_000, 10_000
"""Numbers of characters. The longest texts are only tried if the time of the others
grows faster than their length."""
SUSPECT, TOO_MUCH = 20, 11
"""Ratios of two times, for ten and then for five times as many characters; a square
takes 100 and 25 times as long."""
QUICK, NOTICED, ENDLESS = 0.0003, 0.008, 0.4
"""Times [s] of the processor: not worth a look at 2,000 characters, and at 10,000; and
given up."""
PIECES = (
    *" \n([{<1a_-.,:=/\\$*±'\"|",
    *("1 ", "a ", "a=", "= ", "1.", "1e", "- ", "()", "(a", "a, ", "x = 1 cm "),
)
SIMPLE, ENDS = " (1a", ("\0", "\n\0")
"""Behind each long text, so that a pattern that must reach the end fails; simple pieces
are tried with both ends."""


class Use(NamedTuple):
    """A regular expression, and the method by which a text meets it."""

    pattern: str | bytes
    flags: int
    method: str


class Site(NamedTuple):
    """A line of the package that calls `re`."""

    module: str
    line: int


USES: dict[Use, Site] = {}
"""Each use that is known, and its first place."""
COMPILED: dict[tuple[str | bytes, int], Site] = {}
"""The patterns that are compiled, and where."""
REACHED: set[Site] = set()
"""The calls of `re` that were made."""


class RecordedPattern:
    """A compiled pattern that records which of its methods are called."""

    def __init__(self, compiled: re.Pattern[Any]) -> None:
        self.compiled = compiled

    def __getattr__(self, name: str) -> Any:
        if name in METHODS:
            add_use(self.compiled, name, sys._getframe(1))
        return getattr(self.compiled, name)


def add_pattern(compiled: re.Pattern[Any], method: str, site: Site) -> None:
    if method == "compile":
        COMPILED.setdefault((compiled.pattern, compiled.flags), site)
    else:
        USES.setdefault(Use(compiled.pattern, compiled.flags, method), site)


def site_of(frame: FrameType) -> Site:
    return Site(frame.f_globals.get("__name__", ""), frame.f_lineno)


def add_use(compiled: re.Pattern[Any], method: str, frame: FrameType) -> None:
    REACHED.add(site_of(frame))
    # What a module does while it is loaded meets no text of a user.
    if frame.f_code.co_name != "<module>":
        add_pattern(compiled, method, site_of(frame))


def compiled_from(pattern: Any, flags: int = 0) -> re.Pattern[Any]:
    return (
        pattern.compiled
        if isinstance(pattern, RecordedPattern)
        else COMPILE(pattern, flags)
    )


def record(package: str) -> None:
    """Replace the functions of `re` by others that record the calls of a package."""

    def is_own(frame: FrameType) -> bool:
        return site_of(frame).module.split(".")[0] == package

    def recording(method: str) -> Callable[..., Any]:
        usual = getattr(re, method)

        def call(pattern: Any, *values: Any, **named: Any) -> Any:
            frame = sys._getframe(1)
            if is_own(frame):
                flags = named.get("flags") or [*values[FLAGS_AT.get(method, 1) :], 0][0]
                add_use(compiled_from(pattern, flags), method, frame)
            if isinstance(pattern, RecordedPattern):
                pattern = pattern.compiled
            return usual(pattern, *values, **named)

        return call

    def compile_recorded(pattern: Any, flags: int = 0) -> Any:
        frame = sys._getframe(1)
        compiled = compiled_from(pattern, flags)
        if not is_own(frame):
            return compiled
        REACHED.add(site_of(frame))
        add_pattern(compiled, "compile", site_of(frame))
        return RecordedPattern(compiled)

    for method in METHODS:
        setattr(re, method, recording(method))
    re.compile = compile_recorded


def modules_of(package: str) -> Iterator[ModuleType]:
    whole = importlib.import_module(package)
    yield whole
    for module in pkgutil.walk_packages(whole.__path__, f"{package}."):
        if not module.name.endswith("__main__"):
            yield importlib.import_module(module.name)


def calls_in(module: ModuleType) -> Iterator[tuple[ast.expr, ast.Call]]:
    """Give the calls in functions of a module that may be of `re`, with the owner."""
    tree = ast.parse(Path(module.__file__ or "").read_text("utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    calls = {
        node: None
        for function in functions
        for node in ast.walk(function)
        if isinstance(node, ast.Call)
    }
    for call in calls:
        if method_of(call) in (*METHODS, "compile"):
            assert isinstance(call.func, ast.Attribute)
            yield call.func.value, call


def method_of(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else ""


def value_of(node: ast.expr, names: dict[str, Any]) -> Any:
    """Work out an expression from the names of a module; None if it contains others."""
    try:
        return eval(compile(ast.Expression(node), "", "eval"), dict(names))
    except (AttributeError, NameError, SyntaxError):
        return None


def written_pattern(
    owner: Any, call: ast.Call, names: dict[str, Any]
) -> re.Pattern[Any] | None:
    """Return the pattern of a call of `re`, or of a compiled pattern, if known."""
    if isinstance(owner, RecordedPattern):
        return owner.compiled
    pattern = value_of(call.args[0], names)
    flags = [word.value for word in call.keywords if word.arg == "flags"]
    if pattern is None:
        return None
    return compiled_from(pattern, *(value_of(node, names) for node in flags))


def was_reached(module: str, call: ast.Call) -> bool:
    lines = range(call.lineno, (call.end_lineno or 0) + 1)
    return any(Site(module, line) in REACHED for line in lines)


def add_written(package: str) -> Iterator[Site]:
    """Record the patterns that the source shows; give the calls of unknown patterns."""
    for module in modules_of(package):
        names = vars(module)
        for owner, call in calls_in(module):
            is_name = isinstance(owner, ast.Name | ast.Attribute)
            value = value_of(owner, names) if is_name else None
            if value is not re and not isinstance(value, RecordedPattern):
                continue
            site = Site(module.__name__, call.lineno)
            if pattern := written_pattern(value, call, names):
                add_pattern(pattern, method_of(call), site)
            elif not was_reached(module.__name__, call):
                yield site


class EndlessError(Exception):
    """A pattern takes too long."""


def run(use: Use, compiled: re.Pattern[Any], text: str) -> None:
    given: Any = text.encode() if isinstance(use.pattern, bytes) else text
    if use.method in ("sub", "subn"):
        getattr(compiled, use.method)(lambda match: match[0], given)
    elif use.method == "finditer":
        for _ in compiled.finditer(given):
            pass
    else:
        getattr(compiled, use.method)(given)


def time_of(use: Use, text: str) -> float:
    """Return the time [s] of the processor for one text, at most about `ENDLESS`."""
    # To compile a pattern can take longer than to try it on a short text.
    compiled = COMPILE(use.pattern, use.flags)
    signal.setitimer(signal.ITIMER_VIRTUAL, ENDLESS)
    start = time.thread_time()
    with contextlib.suppress(EndlessError):
        run(use, compiled, text)
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return time.thread_time() - start


def shortest_time(use: Use, text: str) -> float:
    """Return the shortest of three times [s]: the one without other programs' work."""
    return min(time_of(use, text) for _ in range(3))


def give_up(*_: object) -> None:
    raise EndlessError


def text_of(piece: str, size: int, end: str) -> str:
    return (piece * size)[:size] + end


def is_slow(use: Use, texts: Sequence[str]) -> bool:
    """Return whether the time of three texts grows faster than their length."""
    short, usual, longest = texts
    time_usual = time_of(use, usual)
    if time_usual > ENDLESS / 2:
        return True
    if time_usual < max(QUICK, SUSPECT * shortest_time(use, short)):
        return False
    time_usual, time_longest = (shortest_time(use, text) for text in (usual, longest))
    return time_longest > max(NOTICED, min(TOO_MUCH * time_usual, ENDLESS / 2))


def slow_piece(use: Use) -> str:
    """Return the piece whose repetition takes too much time; "" if there is none."""
    signal.signal(signal.SIGVTALRM, give_up)
    for piece in PIECES:
        for end in ENDS if piece in SIMPLE else ENDS[:1]:
            if is_slow(use, [text_of(piece, size, end) for size in SIZES]):
                return piece
    return ""


HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
LOG = HEAD + "20,15.0,406,13.06,1/3\n40,15.0,406,6.6,1/3\n"
LOGS = (
    LOG,
    LOG.replace("20,15.0", '"20 + 30 g","15,5 (about)"'),
    LOG.replace("406", "3.Feb").replace("13.06", "0:13.06"),
    LOG.replace("turns", "turns (no. of full)").replace("1/3", "one third"),
    LOG.replace("20,", "20 ± 1 kg u,"),
    LOG.replace(",", "   "),
    LOG.replace(",", " & ").replace("\n", " \\\\\n"),
    "Ball diameter: 10.16 cm, from the surface, r = x + 5.08 cm\n" + LOG,
    "# falling_mass: 20 g fell 30 cm in 5 s\n# spin_down: 400 rpm to 380 rpm in 60 s\n"
    + LOG,
    "Weight 1: 20.1 g at 14.8 cm, 406 rpm, 13.06 s for 1/3 turn\n" * 3,
    "# " + LOG,
    (2 * HEAD[:-1]).replace("turns", "turns,")
    + "\n"
    + 3 * "20,15,406,13,1,20,15,500,16,1\n",
    f"Day 1:,,,,,Day 2:,,,,\n{HEAD[:-1]},{HEAD}"
    + 3 * "20,15,406,13,1,20,15,500,16,1\n",
    "1: 20 g, 2: 40 g\n" + LOG.replace("mass [g]", "weight").replace("\n20", "\n1"),
    "A = 20.1 g\n" + LOG.replace("\n20", "\nA"),
    "length is from the centre\n" + LOG.replace("position", "length"),
    "# position is really the diameter of the circle\n" + LOG,
    "length is from the centre\n"
    + LOG.replace("position", "length").replace("turns", "x [cm]"),
    "mass (g),rpm 1,time 1 (s),rpm 2,time 2 (s)\n" + 2 * "20,406,13.1,500,16.0\n",
)


ANSWER = (
    "Our result: I_zz = 4.40e-3 kg m^2, with an uncertainty of 0.05e-3 kg m^2 (2 %)\n"
    "<p>I_zz = (4.4 ± 0.1) 10<sup>-3</sup> kg m^2</p>\n"
    "between 4.3e-3 kg m^2 and 4.5e-3 kg m^2\n"
    "unit = kg m^2\n"
)
REPORTS = tuple(
    f"answer.{kind}" for kind in ("md", "tex", "html", "csv", "txt", "json", "toml")
)
RUBRICS = (b'points = "x"\n', b"[[criteria]]\nname = 1\n")


def exercise() -> None:
    """Read texts that reach the patterns that are made at run time."""
    from gyrodata.base.errors import GyroError
    from gyrodata.grading.exports import gradebooks
    from gyrodata.grading.rubric import read_rubric
    from gyrodata.grading.submissions import names
    from gyrodata.grading.submissions.answers import read_answers
    from gyrodata.readings import read_log
    from gyrodata.reporting import latex, page

    for log in LOGS:
        with contextlib.suppress(GyroError):
            read_log(log.encode())
    read_answers(None, [(report, ANSWER.encode()) for report in REPORTS])
    for platform in names.PLATFORMS.values():
        platform.match("lab.csv")
    page._typeset("20 g")
    latex.escape("M")
    latex.as_typed("M0")
    for data in (b"Student,ID,Lab\nAnn,1,\n", b'"Participant","Grade"\n"1",""\n'):
        with contextlib.suppress(GyroError):
            gradebooks.fill_book(data, "book.csv", [])
    for rubric in RUBRICS:
        with contextlib.suppress(GyroError):
            read_rubric(rubric)


def main(package: str) -> None:
    record(package)
    if package == "gyrodata":
        with contextlib.redirect_stdout(io.StringIO()):
            exercise()
    for site in add_written(package):
        print(f"{site.module}:{site.line}: the pattern is not reached")
    used = {(use.pattern, use.flags) for use in USES}
    for key, site in COMPILED.items():
        if key not in used:
            USES[Use(*key, "search")] = site
    for use, site in sorted(USES.items(), key=lambda item: item[1]):
        if piece := slow_piece(use):
            print(
                f"{site.module}:{site.line}: {use.method} {use.pattern!r} "
                f"is slow for {piece!r}"
            )


if __name__ == "__main__":
    main(*sys.argv[1:] or ["gyrodata"])
