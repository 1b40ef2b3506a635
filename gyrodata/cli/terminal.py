"""Standard output and error: what every command prints through."""

from __future__ import annotations

import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from gyrodata.diagnostics import FAULT_OF_GYRO, STREAM_CANNOT_BE_USED
from gyrodata.errors import Diagnostic, GyroError, InputError, printable

FAULT = 3
"""Exit code of a fault of gyro itself."""


class Door(TyperGroup):
    """The one handler: whatever gyro cannot go on from becomes a line and an exit code here."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the command line."""
        for stream in (sys.stdout, sys.stderr):
            _speak_utf8(stream)
        try:
            return super().main(*args, **extra)
        except GyroError as error:
            _end(error.diagnostics, error.exit_code)
        except OSError as error:
            # What a command opens itself it explains itself.
            message = f"gyro cannot go on: {error.strerror or type(error).__name__}"
            hint = "is the disk full, or a file or folder not yours?"
            _end([Diagnostic(STREAM_CANNOT_BE_USED, "error", message, hint)], InputError.exit_code)
        except Exception as error:
            _end([fault(error)], FAULT)


def _end(diagnostics: Sequence[Diagnostic], code: int) -> NoReturn:
    with suppress(OSError):
        complain(diagnostics)
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            _throw_away(stream)
    sys.exit(code)


def _speak_utf8(stream: Any) -> None:
    """Write UTF-8 to files and pipes on every system; what a terminal cannot show `readable` puts otherwise."""
    # A test's or a notebook's stand-in has no encoding to fail on, a closed stream is None.
    with suppress(AttributeError):
        # Half a surrogate, as of a file's name in another coding, is in no encoding.
        stream.reconfigure(encoding=stream.encoding if stream.isatty() else "utf-8", errors="replace")


_PLAIN = {
    "φ̇ψ̇": "phi_dot psi_dot", "φ̇": "phi_dot", "ψ̇": "psi_dot", "φ": "phi", "ψ": "psi", "θ": "theta", "ω": "omega",
    "±": "+/-", "·": "*", "×": "x", "−": "-", "–": "-", "→": "->", "≤": "<=", "≥": ">=", "√": "sqrt", "χ": "chi",
    "²": "^2", "³": "^3", "⁴": "^4", "⁻": "^-", "¹": "1", "°": " deg", "µ": "u", "μ": "u", "π": "pi", "…": "...",
    "½": "1/2", "⅓": "1/3", "⅔": "2/3", "’": "'", "“": '"', "”": '"', "∝": "~", "Δ": "Delta", "σ": "sigma",
}  # fmt: skip
"""What stands for a sign that a terminal cannot show; longer ones first."""

_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def readable(text: str, encoding: str) -> str:
    """Put signs that an encoding lacks otherwise, so that every number stays the same: 4.4 × 10⁻³ as 4.4e-3."""
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        text = re.sub(r" ?[×·] ?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda found: f"e{found[1].translate(_RAISED)}", text)
        for sign, plain in _PLAIN.items():
            try:
                sign.encode(encoding)
            except UnicodeEncodeError:
                text = text.replace(sign, plain)
    return text


def _throw_away(stream: Any) -> None:
    """Let what Python flushes once more at exit go nowhere."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def fault(error: Exception, name: str = "") -> Diagnostic:
    """Say that gyro itself broke on a log, and where; GYRO_DEBUG=1 shows the whole way there."""
    if os.environ.get("GYRO_DEBUG"):
        import traceback

        traceback.print_exception(error)
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
    r"|(?P<doubt>Do not rely on this answer:)"
)
_COLOURS = {"error": "1;31", "warning": "1;33", "note": "36"}


def coloured(text: str, stream: Any) -> str:
    """Set severities apart on a terminal, unless NO_COLOR is set; nowhere else."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or stream is None or not stream.isatty():
        return text

    def paint(found: re.Match[str]) -> str:
        colour = _COLOURS[found["severity"] or "error"]
        return f"{found['place'] or ''}\033[{colour}m{found['told'] or found['doubt']}\033[0m"

    return re.sub(_COLOURED, paint, text)


def write_out(text: str) -> None:
    """Write data to standard output; a reader that has gone away (``| head``) is no fault."""
    if sys.stdout is None:
        refuse(STREAM_CANNOT_BE_USED, "standard output is closed", "leave >&- out, or write to a file: > FILE")
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
            "make room on the disk, or write to another file",
        )


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error, those that stop the analysis last, where they are seen."""
    order = {"note": 0, "warning": 1, "error": 2}
    shown: Sequence[Diagnostic] = sorted(
        (d for d in diagnostics if not quiet or d.severity == "error"),
        key=lambda d: (order[d.severity], d.line or 0, d.column or 0),
    )
    for diagnostic in shown:
        told = readable(str(diagnostic), getattr(sys.stderr, "encoding", None) or "utf-8")
        typer.echo(coloured(told, sys.stderr), err=True, color=True)


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


def source_of(log: str, name: str = STDIN) -> dict[str, Any]:
    """Where a log is read from, and what it is called."""
    if log != "-":
        # A path with a newline in it is a path all the same.
        return {"source": Path(log), "name": name_of(log) if name == STDIN else name}
    if sys.stdin is None:
        refuse(STREAM_CANNOT_BE_USED, "standard input is closed", "give the log's name instead of -, or - < log.csv")
    if sys.stdin.isatty():
        end = "Ctrl-Z and Enter" if os.name == "nt" else "Ctrl-D"
        typer.echo(f"reading the log from the keyboard; end it with {end}", err=True)
    return {"source": sys.stdin.buffer, "name": name}


def short_paths(logs: Sequence[str]) -> list[Path]:
    """Paths of logs as they were given, absolute ones by as many of their last parts as tell them apart."""
    paths = [Path(log) for log in logs]
    longer = [i for i, path in enumerate(paths) if path.is_absolute()]
    for count in range(1, max((len(paths[i].parts) for i in longer), default=1)):
        ends = {i: Path(*Path(logs[i]).parts[1:][-count:]) for i in longer}
        often = Counter(ends.values())
        for i, end in ends.items():
            paths[i] = end
        longer = [i for i, end in ends.items() if often[end] > 1]
    return paths


def names_of(paths: Sequence[Path], stdin: str = STDIN) -> list[str]:
    """What logs are called."""
    return [stdin if path == Path("-") else printable(path.as_posix()) for path in paths]


def name_of(log: str) -> str:
    """What a single log is called, whether it can be read or not."""
    return names_of(short_paths([log]))[0]
