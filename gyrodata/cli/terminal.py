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
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

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
        except Exception as error:
            diagnostics, code = explained(error)
            complain(diagnostics)
            _flush()
        if standalone:
            sys.exit(code)
        return code

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Print the help without arguments; refuse an empty one."""
        if "" in args:
            refuse("empty_word")
        return super().parse_args(ctx, args or ["--help"])


def explained(error: Exception, log: str = "") -> tuple[Sequence[Diagnostic], int]:
    """Return what an error means, and its exit code; `log` is the name of a log."""
    if isinstance(error, GyroError):
        return error.diagnostics, error.exit_code
    if isinstance(error, OSError) and not log:
        # Commands explain errors of the files that they open.
        why = error.strerror or type(error).__name__
        return [Diagnostic.named("cannot_continue", why=why)], InputError.exit_code
    if hasattr(error, "format_message"):
        # An error of the command line itself: typer does not export its class.
        return [_usage_error(error)], InputError.exit_code
    return [_fault(error, log)], FAULT


def _usage_error(error: Any) -> Diagnostic:
    """Write an error of the command line in the form of all others."""
    words = " ".join(error.format_message().split())
    message, *names = re.split(r"\.? (?:Did you mean |\(Possible options: )", words)
    message = re.sub("(?i)value error, ", "", message)
    message = (message[:1].lower() + message[1:]).rstrip(".")
    hint = ""
    if error.ctx is not None:
        wrong = getattr(error, "option_name", "").lstrip("-")
        hint = _hint_from_options(error.ctx, message, wrong)
    if not hint and names:
        hint = f"did you mean {names[0].rstrip('?)').replace(', ', ' or ')}?"
    hint = hint or _hint_for_file() or _nearest_choice(message)
    if not hint and error.ctx is not None:
        hint = _example_or_help(error.ctx, message)
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
        name = message.rpartition("(")[2].rstrip(")")
        is_extra = message.startswith("got unexpected extra argument")
        # A file that exists is another log, not the name for the output.
        if is_extra and "--out" in option.opts and not Path(name).exists():
            return f"to write a file: {context.command_path} --out {name}"
    if wrong in ("out", "o"):
        return "to write a file, add this at the end: > FILE"
    return ""


def _example_or_help(context: Any, message: str) -> str:
    """Show the example of a command if its argument is missing; else name its help."""
    epilog = context.command.epilog or ""
    if message.startswith("missing argument") and epilog:
        first = epilog.partition("Example:")[2].split("\n          gyro ")[0]
        words = first.replace("\\", "").split()
        return f"for example: {' '.join(words)}"
    return f"see: {context.command_path} --help"


def _flush() -> None:
    """Write what Python still keeps; a stream that is closed is left alone."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            _throw_away(stream)


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


def _fault(error: Exception, log: str) -> Diagnostic:
    """Describe a fault of gyro itself; GYRO_DEBUG=1 prints the traceback."""
    import traceback

    if os.environ.get("GYRO_DEBUG"):
        tell("".join(traceback.format_exception(error)))
    place = ""
    for frame, line in traceback.walk_tb(error.__traceback__):
        module = frame.f_globals.get("__name__", "")
        if module.startswith("gyrodata"):
            place = f" in {module}, line {line}"
    name = type(error).__name__
    return Diagnostic.named("fault_of_gyro", log, error=name, place=place)


STYLES = {
    r"\berror G\d{3}:": "bold red",
    r"\bwarning G\d{3}:": "bold yellow",
    r"\bnote G\d{3}:": "cyan",
    "Do not rely on this answer:": "bold red",
    "(?m)^  I_zz = .*": "bold",
}
"""Styles of words on a terminal."""


def for_stream(text: str, stream: Any) -> str:
    """Wrap a text, colour severities and make the answer bold, on a terminal.

    FORCE_COLOR, NO_COLOR and TERM are respected.
    """
    text = _wrapped(text, stream)
    wanted = stream.isatty() or os.environ.get("FORCE_COLOR")
    if not wanted or os.environ.get("NO_COLOR"):
        return text
    from rich.console import Console
    from rich.text import Text

    console = Console(file=stream, legacy_windows=False)
    styled = Text(text)
    for words, style in STYLES.items():
        styled.highlight_regex(words, style)
    with console.capture() as captured:
        console.print(styled, soft_wrap=True, end="")
    return captured.get()


def _wrapped(text: str, stream: Any) -> str:
    """Wrap long lines between words at the width of a terminal.

    Texts for other streams stay the same, and pages, which have their width and their
    colours already.
    """
    if not stream.isatty() or "\033" in text:
        return text
    width = shutil.get_terminal_size().columns
    return "\n".join([_wrap_line(line, width) for line in text.split("\n")])


def _wrap_line(line: str, width: int) -> str:
    """Wrap a line; the last column of a table goes on below its first word."""
    from rich.cells import cell_len

    if cell_len(line) <= width:
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


def write_answer(form: str, document: dict[str, Any], text: object) -> None:
    """Print a result: its document as JSON, or what `str` makes of `text`."""
    from gyrodata.reporting.data import json_text

    if form == "text":
        write_text(str(text))
    else:
        write_out(json_text(document, indent=None if form == "ndjson" else 2))


def write_text(text: str) -> None:
    """Write text to standard output, wrapped and coloured if it is a terminal."""
    write_out(for_stream(text, sys.stdout))


def tell(*lines: str) -> None:
    """Write lines to standard error; if it is closed, the answer is still printed."""
    for line in (line.translate(PICTURES) for line in lines):
        try:
            line = readable(line, sys.stderr.encoding or "utf-8")
            typer.echo(for_stream(line, sys.stderr), err=True, color=True)
        except OSError:
            _throw_away(sys.stderr)


SEVERITIES = ("note", "warning", "error")


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error; errors come last, where users see them."""

    def order(finding: Diagnostic) -> tuple[int, int, int]:
        place = finding.line or 0, finding.column or 0
        return SEVERITIES.index(finding.severity), *place

    for finding in sorted(diagnostics, key=order):
        if not quiet or finding.severity == "error":
            tell(str(finding))


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


FOR_SEVERAL = {"json": "ndjson", "latex": "markdown"}
"""What to use for several answers in the place of a format for one."""


class Log(NamedTuple):
    """A log that a command is given."""

    path: str
    """As it was typed; "-" is standard input."""
    name: str
    """For messages and results."""


def named_logs(paths: Sequence[str]) -> list[Log]:
    """Return the logs of a command with their names."""
    logs = []
    for path, short in zip(paths, short_paths(paths), strict=True):
        name = "<stdin>" if path == "-" else printable(short.as_posix())
        logs.append(Log(path, name))
    return logs


def in_parts(paths: Sequence[str], together: bool, form: str) -> list[list[Log]]:
    """Return the logs of a command in parts; each part has one answer."""
    logs = named_logs(paths)
    parts = [logs] if together else [[log] for log in logs]
    if len(parts) > 1 and form in FOR_SEVERAL:
        refuse("format_for_one_log", form=form, other=FOR_SEVERAL[form])
    return parts


def source_of(log: Log) -> Any:
    """Return the file of a log, or the bytes of standard input."""
    if log.path != "-":
        # A path that contains a line break is still a path.
        return Path(log.path)
    if sys.stdin is None:
        refuse("input_closed")
    if sys.stdin.isatty():
        end = "Ctrl-Z and Enter" if os.name == "nt" else "Ctrl-D"
        tell(f"gyro reads the log from the keyboard; end it with {end}")
    return sys.stdin.buffer


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
