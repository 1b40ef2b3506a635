"""Standard output and error: what every command prints through."""

from __future__ import annotations

import codecs
import errno
import os
import re
import shutil
import sys
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from io import TextIOBase, TextIOWrapper
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from gyrodata.diagnostics import FAULT_OF_GYRO, STREAM_CANNOT_BE_USED
from gyrodata.errors import PICTURES, Diagnostic, GyroError, InputError, printable

FAULT = 3
"""Exit code of a fault of gyro itself."""


class Door(TyperGroup):
    """The one handler: whatever gyro cannot go on from becomes a line and an exit code here."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the command line."""
        _open_streams()
        try:
            return super().main(*args, **extra)
        except SystemExit as ended:
            # A reader of the help that has stopped is not an error either.
            if isinstance(ended.__context__, BrokenPipeError):
                sys.exit(0)
            raise
        except GyroError as error:
            _end(error.diagnostics, error.exit_code)
        except OSError as error:
            # A command explains errors of the files that it opens itself.
            message = f"gyro cannot go on: {error.strerror or type(error).__name__}"
            hint = "is the disk full, or a file or folder not yours?"
            _end([Diagnostic(STREAM_CANNOT_BE_USED, "error", message, hint)], InputError.exit_code)
        except Exception as error:
            _end([fault(error)], FAULT)


def _end(diagnostics: Sequence[Diagnostic], code: int) -> NoReturn:
    complain(diagnostics)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            _throw_away(stream)
    sys.exit(code)


class _Closed(TextIOBase):
    """Stands where a stream is closed, which Python has None for: to write to it is an error like a full disk."""

    encoding = "utf-8"

    def write(self, _: str) -> NoReturn:
        raise OSError(errno.EBADF, "it is closed; leave >&- out")


def _open_streams() -> None:
    """Write UTF-8 to files and pipes on every system, and what a terminal cannot show in plain letters."""
    closed: Any = _Closed()
    sys.stdout, sys.stderr = sys.stdout or closed, sys.stderr or closed
    for stream in (sys.stdout, sys.stderr):
        # A test's or a notebook's stand-in has no encoding to fail on.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(encoding=stream.encoding if stream.isatty() else "utf-8", errors="gyrodata.plain")


_PLAIN = {
    "±": "+/-", "·": "*", "×": "x", "−": "-", "–": "-", "→": "->", "≤": "<=", "≥": ">=", "√": "sqrt", "°": " deg",
    "’": "'", "“": '"', "”": '"', "∝": "~", "∞": "infinity", "⁄": "/",
    "─": "-", "━": "-", "│": "|", "▌": "|", "•": "*", "\u0307": "_dot",
}  # fmt: skip
"""What stands for a sign that an encoding lacks, where `unicodedata` does not know it."""

_DOTTED = {"φ̇ψ̇": "phi_dot psi_dot", "φ̇": "phi_dot", "ψ̇": "psi_dot"}
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_TOGETHER = re.compile(f" ?[×·] ?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|{'|'.join(_DOTTED)}")
"""What is put otherwise as a whole, or not at all."""


def readable(text: str, encoding: str) -> str:
    """Put signs that an encoding lacks otherwise, so that every number stays the same: 4.4 × 10⁻³ as 4.4e-3."""

    def put(found: re.Match[str]) -> str:
        try:
            found[0].encode(encoding)
        except UnicodeEncodeError:
            return f"e{found[1].translate(_RAISED)}" if found[1] else _raised(found)
        return found[0]

    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        text = _TOGETHER.sub(put, text).encode(encoding, "gyrodata.plain").decode(encoding)
    return text


def _raised(found: re.Match[str]) -> str:
    return _DOTTED.get(found[0]) or f"^{found[0].translate(_RAISED)}"


def _in_plain_letters(error: UnicodeError) -> tuple[str, int]:
    """Say what to write for signs that an encoding lacks."""
    assert isinstance(error, UnicodeEncodeError)
    signs = _TOGETHER.sub(lambda found: found[0] if found[1] else _raised(found), error.object[error.start : error.end])
    plain = "".join(_plain(sign) for sign in signs)
    # 2½ is not 21/2.
    apart = " " if "/" in plain[1:3] and error.object[error.start - 1 : error.start].isdigit() else ""
    return apart + plain, error.end


codecs.register_error("gyrodata.plain", _in_plain_letters)


def _plain(sign: str) -> str:
    """Put a sign in ASCII: π as pi, é as e; a question mark for what has no such name."""
    from unicodedata import combining, decimal, name, normalize

    if sign.isascii() or sign in _PLAIN:
        return _PLAIN.get(sign, sign)
    if (digit := decimal(sign, None)) is not None:
        return str(digit)
    if (parts := normalize("NFKD", sign)) != sign:
        return "".join(map(_plain, parts))
    if combining(sign):
        return ""
    if "\N{SYMBOL FOR NULL}" <= sign <= "\N{SYMBOL FOR UNIT SEPARATOR}":
        return f"^{chr(ord(sign) - 0x2400 + 64)}"  # NUL as ^@
    called = name(sign, "")
    if called.startswith("GREEK "):
        letter = called.split()[-1]
        return letter.capitalize() if "CAPITAL" in called else letter.lower()
    return "?"


def _throw_away(stream: Any) -> None:
    """Discard the output that Python flushes at exit."""
    with suppress(OSError, ValueError, AttributeError):
        number = stream.fileno()
        os.dup2(os.open(os.devnull, os.O_WRONLY), number)


def fault(error: Exception, name: str = "") -> Diagnostic:
    """Say that gyro itself broke on a log, and where; GYRO_DEBUG=1 shows the whole way there."""
    if os.environ.get("GYRO_DEBUG"):
        import traceback

        tell("".join(traceback.format_exception(error)))
    place, trace = "", error.__traceback__
    while trace is not None:
        module = trace.tb_frame.f_globals.get("__name__", "")
        if module.startswith("gyrodata"):
            place = f" in {module}, line {trace.tb_lineno}"
        trace = trace.tb_next
    return Diagnostic(
        FAULT_OF_GYRO,
        "error",
        f"this is a fault of gyro, not of your log: {type(error).__name__}{place}",
        "please report it with the log and this line; GYRO_DEBUG=1 in front of the command shows more",
        name,
    )


_COLOURED = (
    r"(?m)^(?P<place>(?:\S.*?: )?)(?P<told>(?P<severity>error|warning|note) G\d{3}:)"
    r"|(?P<doubt>Do not rely on this answer:)|(?P<answer>^  I_zz = .*)"
)
_COLOURS = {"error": "1;31", "warning": "1;33", "note": "36"}


def coloured(text: str, stream: Any) -> str:
    """Colour severities and print the answer in bold on a terminal; FORCE_COLOR and NO_COLOR are respected."""
    plain = os.environ.get("TERM") == "dumb" or not stream.isatty()
    if os.environ.get("NO_COLOR") or (plain and not os.environ.get("FORCE_COLOR")):
        return text

    def paint(found: re.Match[str]) -> str:
        colour = "1" if found["answer"] else _COLOURS[found["severity"] or "error"]
        words = found["told"] or found["doubt"] or found["answer"]
        return f"{found['place'] or ''}\033[{colour}m{words}\033[0m"

    return re.sub(_COLOURED, paint, text)


def wrapped(text: str, stream: Any) -> str:
    """Wrap long lines at the width of a terminal; tables and texts for other streams stay as they are."""
    if not stream.isatty():
        return text
    width = shutil.get_terminal_size().columns

    def wrap(line: str) -> str:
        indent = line[: len(line) - len(line.lstrip())]
        if len(line) <= width or "  " in line.strip():
            return line
        return textwrap.fill(line, width, subsequent_indent=indent + "  ", break_long_words=False)

    return "\n".join(map(wrap, text.split("\n")))


def write_out(text: str) -> None:
    """Write data to standard output; a reader that has stopped (``| head``) is not an error."""
    try:
        sys.stdout.write(readable(text, sys.stdout.encoding or "utf-8"))
        sys.stdout.flush()
    except BrokenPipeError:
        _throw_away(sys.stdout)
        raise typer.Exit(0) from None
    except OSError as error:
        _throw_away(sys.stdout)
        refuse(
            STREAM_CANNOT_BE_USED,
            f"standard output cannot be written: {error.strerror}",
            "make room on the disk, or write to another file: > FILE",
        )


def tell(*lines: str) -> None:
    """Write lines to standard error; if that cannot be written, it costs no answer."""
    for line in (line.translate(PICTURES) for line in lines):
        try:
            line = wrapped(readable(line, sys.stderr.encoding or "utf-8"), sys.stderr)
            typer.echo(coloured(line, sys.stderr), err=True, color=True)
        except OSError:
            _throw_away(sys.stderr)


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error, those that stop the analysis last, where they are seen."""
    order = {"note": 0, "warning": 1, "error": 2}
    shown: Sequence[Diagnostic] = sorted(
        (d for d in diagnostics if not quiet or d.severity == "error"),
        key=lambda d: (order[d.severity], d.line or 0, d.column or 0),
    )
    tell(*map(str, shown))


def refuse(code: str, message: str, hint: str) -> NoReturn:
    """Stop with one error: what is wrong, and what to type."""
    raise InputError.of(code, message, hint)


def progress_bar(whole: int, clock: Callable[[], float] | None = None, what: str = "") -> Callable[[int], None] | None:
    """Show how far a long computation is, and by a clock [s] how long it still takes, on a terminal only."""
    if not sys.stderr.isatty():
        return None
    first: tuple[int, float] | None = None

    def show(done: int) -> None:
        nonlocal first
        left = ""
        if clock is not None:
            now = clock()
            # Before the first call an earlier run may have done much, and starting took its time.
            first = first or (done, now)
            if done > first[0]:
                left = f", {time_text((now - first[1]) * (whole - done) / (done - first[0]))} left"
        typer.echo(f"\r{what}{done} of {whole}{left}\033[K" if done < whole else "\r\033[K", err=True, nl=False)

    return show


def time_text(seconds: float) -> str:
    """Write a time to wait: "5 s", "3 min", "1 h 20 min"."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"


STDIN = "<stdin>"
"""What a log from standard input is called."""


def source_of(log: str, name: str) -> dict[str, Any]:
    """Return the source of a log, and its name."""
    if log != "-":
        # A path with a newline in it is a path all the same.
        return {"source": Path(log), "name": name}
    if sys.stdin is None:
        refuse(STREAM_CANNOT_BE_USED, "standard input is closed", "give the log's name instead of -, or - < log.csv")
    if sys.stdin.isatty():
        end = "Ctrl-Z and Enter" if os.name == "nt" else "Ctrl-D"
        tell(f"reading the log from the keyboard; end it with {end}")
    return {"source": sys.stdin.buffer, "name": name}


def short_paths(logs: Sequence[str]) -> list[Path]:
    """Return the paths of logs as they were given; absolute ones with as many last parts as make them different."""
    paths = [Path(log) for log in logs]
    given = [path for path in paths if not path.is_absolute()]
    longer = [i for i, path in enumerate(paths) if path.is_absolute()]
    for count in range(1, max((len(paths[i].parts) for i in longer), default=1)):
        ends = {i: Path(*Path(logs[i]).parts[1:][-count:]) for i in longer}
        often = Counter([*ends.values(), *given])
        for i, end in ends.items():
            paths[i] = end
        longer = [i for i, end in ends.items() if often[end] > 1]
    return paths


def names_of(paths: Sequence[Path], stdin: str = STDIN) -> list[str]:
    """Return the names of logs."""
    return [printable(stdin) if path == Path("-") else printable(path.as_posix()) for path in paths]


def name_of(log: str, stdin: str = STDIN) -> str:
    """Return the name of a single log, readable or not."""
    return names_of(short_paths([log]), stdin)[0]
