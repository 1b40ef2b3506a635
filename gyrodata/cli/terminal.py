"""Standard output and standard error: every command prints through this module."""

from __future__ import annotations

import errno
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOBase, TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer
from typer.core import TyperGroup

from gyrodata.base.errors import PICTURES, Diagnostic, GyroError, InputError, printable

if TYPE_CHECKING:
    from gyrodata.reporting.text import Columns

FAULT = 3
"""Exit code of a fault of gyro itself."""


class Door(TyperGroup):
    """The only error handler of the command line.

    Each error that ends a command becomes a message and an exit code here.
    """

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run the command line, and exit."""
        standalone = extra.get("standalone_mode", True)
        extra["standalone_mode"] = False
        _open_streams()
        try:
            code = super().main(*args, **extra)
        except SystemExit:
            # Help goes to a reader that has stopped, such as "| head".
            code = 0
        except GyroError as error:
            code = _report(error.diagnostics, error.exit_code)
        except OSError as error:
            # Commands explain errors of the files that they open.
            diagnostic = Diagnostic.named(
                "cannot_continue", why=error.strerror or type(error).__name__
            )
            code = _report([diagnostic], InputError.exit_code)
        except Exception as error:
            # Errors of the command line itself have this method; typer does not export
            # their class.
            if hasattr(error, "format_message"):
                code = _report([_usage_error(error)], InputError.exit_code)
            else:
                code = _report([fault(error)], FAULT)
        if standalone:
            sys.exit(code)
        return code

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Print the help if there are no arguments."""
        return super().parse_args(ctx, args or ["--help"])


def _usage_error(error: Any) -> Diagnostic:
    """Write an error of the command line in the form of all others."""
    words = " ".join(error.format_message().split())
    message, *names = re.split(r"\.? (?:Did you mean |\(Possible options: )", words)
    message = re.sub("(?i)value error, ", "", message)
    message = (message[:1].lower() + message[1:]).rstrip(".")
    hint = _hint_for_file() or _nearest_choice(message)
    if names:
        hint = f"did you mean {names[0].rstrip('?)').replace(', ', ' or ')}?"
    if error.ctx is not None:
        wrong = getattr(error, "option_name", "").lstrip("-")
        hint = _hint_from_options(error.ctx, message, wrong) or hint
        hint = hint or _example_or_help(error.ctx, message)
    hint = hint or "see: gyro --help"
    return Diagnostic.named("command_line_wrong", message=message, hint=hint)


def _hint_for_file() -> str:
    """Say how to name a file whose name looks like an option; "" if there is none."""
    for word in sys.argv[1:]:
        if word.startswith("-") and Path(word).is_file():
            return f"for a file whose name begins with -: ./{word}"
    return ""


def _nearest_choice(message: str) -> str:
    """Name the nearest of the values that an option can have; "" if none is near."""
    from difflib import get_close_matches

    choice = re.search(r"'([^']*)' is not one of (.*)", message)
    if choice is None:
        return ""
    values = re.findall(r"'([^']*)'", choice[2])
    near = get_close_matches(choice[1].lower(), values, n=1)
    return f"did you mean {near[0]}?" if near else ""


def _hint_from_options(context: Any, message: str, wrong: str) -> str:
    """Name the option for a value without one; "" if no option has such a value."""
    for option in context.command.params:
        if wrong in (option.type_descriptor.choices or ()):
            return f"did you mean {option.opts[0]} {wrong}?"
        is_extra = message.startswith("got unexpected extra argument")
        if is_extra and "--out" in option.opts:
            name = message.rpartition("(")[2].rstrip(")")
            return f"to write a file: {context.command_path} --out {name}"
    return ""


def _example_or_help(context: Any, message: str) -> str:
    """Show the example of a command if its argument is missing; else name its help."""
    epilog = context.command.epilog or ""
    if message.startswith("missing argument") and epilog:
        first = epilog.partition("Example:")[2].split("\n          gyro ")[0]
        words = first.replace("\\", "").split()
        return f"for example: {' '.join(words)}"
    return f"see: {context.command_path} --help"


def _report(diagnostics: Sequence[Diagnostic], code: int) -> int:
    complain(diagnostics)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            _throw_away(stream)
    return code


class _Closed(TextIOBase):
    """Replacement for a closed stream, for which Python has None.

    Writing to it is an error, like writing to a full disk.
    """

    encoding = "utf-8"

    def write(self, _: str) -> NoReturn:
        raise OSError(errno.EBADF, "it is closed; remove >&- from the command")


def _open_streams() -> None:
    """Write UTF-8 to files and pipes on every system."""
    closed: Any = _Closed()
    sys.stdout = sys.stdout or closed
    sys.stderr = sys.stderr or closed
    for stream in (sys.stdout, sys.stderr):
        # The streams of tests and notebooks accept every character.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(
                encoding=stream.encoding if stream.isatty() else "utf-8",
                errors="replace",
            )


_PLAIN = {
    "±": "+/-",
    "·": "*",
    "×": "x",
    "−": "-",
    "–": "-",
    "→": "->",
    "≤": "<=",
    "≥": ">=",
    "√": "sqrt",
    "°": " deg",
    "’": "'",
    "“": '"',
    "”": '"',
    "∝": "~",
    "∞": "infinity",
    "⁄": "/",
    "─": "-",
    "━": "-",
    "│": "|",
    "▌": "|",
    "•": "*",
    "\u0307": "_dot",
}
"""ASCII text for characters that `unicodedata` does not describe."""

_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def readable(text: str, encoding: str) -> str:
    """Write a text in ASCII if the encoding lacks a character.

    Every number stays the same: 4.4 × 10⁻³ as 4.4e-3.
    """
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        text = re.sub(
            " ?[×·] ?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)",
            lambda match: "e" + match[1].translate(_RAISED),
            text,
        )
        text = re.sub(
            "[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda match: "^" + match[0].translate(_RAISED), text
        )
        text = "".join(map(_plain, text))
    return text


def _plain(sign: str) -> str:
    """Write a character in ASCII: π as pi, é as e.

    A question mark for a character without such a name.
    """
    from unicodedata import combining, decimal, name, normalize

    if sign.isascii() or sign in _PLAIN:
        return _PLAIN.get(sign, sign)
    if (digit := decimal(sign, None)) is not None:
        return str(digit)
    if (parts := normalize("NFKD", sign)) != sign:
        # Separated by a blank: 2½ is not 21/2.
        return " " * ("⁄" in parts) + "".join(map(_plain, parts))
    if "\N{SYMBOL FOR NULL}" <= sign <= "\N{SYMBOL FOR UNIT SEPARATOR}":
        return f"^{chr(ord(sign) - 0x2400 + 64)}"  # NUL as ^@
    called = name(sign, "")
    if called.startswith("GREEK "):
        letter = called.split()[-1]
        return letter.capitalize() if "CAPITAL" in called else letter.lower()
    return "" if combining(sign) else "?"


def _throw_away(stream: Any) -> None:
    """Discard the output that Python flushes at exit."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def fault(error: Exception, name: str = "") -> Diagnostic:
    """Describe a fault of gyro itself; GYRO_DEBUG=1 prints the traceback."""
    import traceback

    if os.environ.get("GYRO_DEBUG"):
        tell("".join(traceback.format_exception(error)))
    frames = traceback.walk_tb(error.__traceback__)
    places = [(frame.f_globals.get("__name__", ""), line) for frame, line in frames]
    place = [
        f" in {module}, line {line}"
        for module, line in places
        if module.startswith("gyrodata")
    ][-1:]
    return Diagnostic.named(
        "fault_of_gyro", name, error=type(error).__name__, place="".join(place)
    )


_COLOURED = (
    r"(?m)^(?P<place>(?:\S.*?: )?)(?P<told>(?P<severity>error|warning|note) G\d{3}:)"
    r"|(?P<doubt>Do not rely on this answer:)|(?P<answer>^  I_zz = .*)"
)
_COLOURS = {"error": "1;31", "warning": "1;33", "note": "36"}


def coloured(text: str, stream: Any) -> str:
    """Colour severities and print the answer in bold on a terminal.

    FORCE_COLOR and NO_COLOR are respected.
    """
    plain = os.environ.get("TERM") == "dumb" or not stream.isatty()
    if os.environ.get("NO_COLOR") or (plain and not os.environ.get("FORCE_COLOR")):
        return text

    def paint(match: re.Match[str]) -> str:
        colour = "1" if match["answer"] else _COLOURS[match["severity"] or "error"]
        words = match["told"] or match["doubt"] or match["answer"]
        return f"{match['place'] or ''}\033[{colour}m{words}\033[0m"

    return re.sub(_COLOURED, paint, text)


def wrapped(text: str, stream: Any) -> str:
    """Wrap long lines between words at the width of a terminal.

    Texts for other streams stay the same.
    """
    if not stream.isatty():
        return text
    width = shutil.get_terminal_size().columns
    return "\n".join([_wrap_line(line, width) for line in text.split("\n")])


def _wrap_line(line: str, width: int) -> str:
    """Wrap a line; the last column of a table goes on below its first word."""
    from gyrodata.reporting.values import display_width

    if display_width(line) <= width:
        return line
    indent = len(line) - len(line.lstrip()) + 2
    starts = [gap.end() for gap in re.finditer(r"(?<=\S) {2,}", line[: width // 2])]
    return textwrap.fill(
        line,
        width,
        subsequent_indent=" " * max([indent, *starts]),
        break_long_words=False,
        break_on_hyphens=False,
    )


def write_out(text: str) -> None:
    """Write data to standard output; ``| head`` can close it."""
    try:
        sys.stdout.write(readable(text, sys.stdout.encoding or "utf-8"))
        sys.stdout.flush()
    except BrokenPipeError:
        _throw_away(sys.stdout)
        raise typer.Exit(0) from None
    except OSError as error:
        _throw_away(sys.stdout)
        refuse("output_not_written", why=error.strerror)


def write_text(text: str) -> None:
    """Write text to standard output, wrapped and coloured if it is a terminal."""
    write_out(coloured(wrapped(text, sys.stdout), sys.stdout))


def tell(*lines: str) -> None:
    """Write lines to standard error; if it is closed, the answer is still printed."""
    for line in (line.translate(PICTURES) for line in lines):
        try:
            line = wrapped(readable(line, sys.stderr.encoding or "utf-8"), sys.stderr)
            typer.echo(coloured(line, sys.stderr), err=True, color=True)
        except OSError:
            _throw_away(sys.stderr)


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error; errors come last, where users see them."""
    order = {"note": 0, "warning": 1, "error": 2}
    shown = [
        diagnostic
        for diagnostic in diagnostics
        if not quiet or diagnostic.severity == "error"
    ]
    tell(
        *map(
            str,
            sorted(
                shown,
                key=lambda diagnostic: (
                    order[diagnostic.severity],
                    diagnostic.line or 0,
                    diagnostic.column or 0,
                ),
            ),
        )
    )


def refuse(name: str, /, **values: object) -> NoReturn:
    """Stop with one error, a message of a file `messages.toml`."""
    raise InputError.named(name, **values)


@contextmanager
def progress_bar(
    whole: int, what: str, quiet: bool = False
) -> Iterator[Callable[[int], None] | None]:
    """Show the progress of a long computation on a terminal, and the time left.

    The context is a function that takes what is done; None without a terminal.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # A thread that draws the bar could stop the processes that are forked.
    with Progress(console=console, transient=True, auto_refresh=False) as bar:
        task = bar.add_task(what, total=whole)
        yield lambda done: bar.update(task, completed=done, refresh=True)


def columns() -> Columns:
    """Return what sets the cells of tables under each other on standard output."""
    from gyrodata.reporting.values import in_columns

    return _in_table if sys.stdout.isatty() else in_columns


def _in_table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Set cells under each other; long ones are wrapped at the width of the terminal."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(
        box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True
    )
    for head, *cells in zip(*rows, strict=True):
        words = " ".join([head, *cells]).split()
        # A unit is below its quantity: columns of numbers stay narrow.
        head = head.replace(" [", "\n[")
        table.add_column(head, min_width=max(map(len, words)))
    for row in rows[1:]:
        table.add_row(*row)
    # Tables are indented by two blanks.
    width = shutil.get_terminal_size().columns - 2
    console = Console(width=width, color_system=None, markup=False, highlight=False)
    with console.capture() as captured:
        console.print(table, crop=False)
    return [line.rstrip() for line in captured.get().splitlines()]


STDIN = "<stdin>"
"""Name of a log from standard input."""


def source_of(log: str, name: str) -> dict[str, Any]:
    """Return the source of a log and its name, as `read_log` needs them."""
    if log != "-":
        # A path that contains a line break is still a path.
        return {"source": Path(log), "name": name}
    if sys.stdin is None:
        refuse("input_closed")
    if sys.stdin.isatty():
        end = "Ctrl-Z and Enter" if os.name == "nt" else "Ctrl-D"
        tell(f"gyro reads the log from the keyboard; end it with {end}")
    return {"source": sys.stdin.buffer, "name": name}


def short_paths(logs: Sequence[str]) -> list[Path]:
    """Return the paths of logs as they were given.

    Absolute paths become relative to the folder that they share.
    """
    paths = [Path(log) for log in logs]
    folders = [path.parent for path in paths if path.is_absolute()]
    try:
        shared = os.path.commonpath(folders) if folders else ""
    except ValueError:
        # Two drives of Windows share no folder.
        return [Path(path.name) if path.is_absolute() else path for path in paths]
    return [path.relative_to(shared) if path.is_absolute() else path for path in paths]


def names_of(logs: Sequence[str]) -> list[str]:
    """Return the names of logs for messages and results."""
    return [
        printable(STDIN if path == Path("-") else path.as_posix())
        for path in short_paths(logs)
    ]
