"""Standard output and standard error: every command prints through this module."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, get_args

import typer
from typer.core import TyperCommand, TyperGroup

from gyrodata.base.errors import PICTURES, Diagnostic, GyroError, InputError, printable

if TYPE_CHECKING:
    from gyrodata.reporting.text import Columns

FAULT = 3
"""Exit code of a fault of gyro itself."""


_DASHES = ("–", "—")
"""What a word processor writes for two minus signs."""


class _WithoutPydantic:
    """Takes texts as they are typed: to import pydantic takes 10 % of a run."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the arguments and options, each with the short way for its value."""
        params: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for param in params:
            param.process_value = partial(_value_of, param)
        return params


def _value_of(param: Any, ctx: Any, typed: Any) -> Any:
    """Return the value of an argument or option.

    No value, a path, texts and a text of a choice need no conversion; typer converts
    all others by pydantic, such as "3" for a whole number.
    """
    described = getattr(param, "type_descriptor", None)
    kind = getattr(described, "annotation", None)
    if kind is Path and typed:
        return Path(typed)
    is_choice = typed in get_args(kind)
    is_absent = typed is None and not param.required
    if is_choice or is_absent or (typed and kind == list[str]):
        return typed
    return type(param).process_value(param, ctx, typed)


class Command(_WithoutPydantic, TyperCommand):
    """A command."""


class Door(_WithoutPydantic, TyperGroup):
    """The only error handler of the command line.

    Each error that ends a command becomes a message and an exit code here.
    """

    def main(self, args: Any = None, *more: Any, **extra: Any) -> Any:
        """Run the command line, and exit."""
        typed = sys.argv[1:] if args is None else args
        standalone = extra.get("standalone_mode", True)
        extra["standalone_mode"] = False
        _open_streams()
        try:
            code = super().main(args, *more, **extra)
        except SystemExit:
            # Help goes to a reader that has stopped, such as "| head".
            code = 0
        except Exception as error:
            if hasattr(error, "format_message"):
                # Typer does not export the class of an error of the command line.
                error = _usage_error(error, typed)
            diagnostics, code = explained(error)
            complain(diagnostics)
        if standalone:
            sys.exit(code)
        return code

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Print the help without arguments; refuse an empty one.

        Word processors replace the two minus signs of an option by a dash.
        """
        if "" in args:
            refuse("empty_word")
        args = [f"--{word[1:]}" if word[:1] in _DASHES else word for word in args]
        return super().parse_args(ctx, args or ["--help"])


def explained(error: Exception, log: str = "") -> tuple[Sequence[Diagnostic], int]:
    """Return what an error means, and its exit code; `log` is the name of a log."""
    if isinstance(error, GyroError):
        return error.diagnostics, error.exit_code
    if isinstance(error, OSError) and not log:
        # Commands explain errors of the files that they open.
        why = error.strerror or type(error).__name__
        return [Diagnostic.named("cannot_continue", why=why)], InputError.exit_code
    return [_fault(error, log)], FAULT


def _usage_error(error: Any, typed: Sequence[str]) -> InputError:
    """Write an error of the command line in the form of all others."""
    message = " ".join(error.format_message().split())
    message, _, _ = message.partition(" (Possible options: ")
    message = message.replace("Value error, ", "")
    message = (message[:1].lower() + message[1:]).rstrip(".")
    files = [word for word in typed if word.startswith("-") and Path(word).is_file()]
    if files:
        hint = f"for a file whose name begins with -: ./{files[0]}"
    elif error.ctx is None:
        hint = f"see: {' '.join(['gyro', *typed[:1]])} --help"
    else:
        words = " ".join(typed).replace("=", " ").split()
        wrong = [word for word in words if word[0] == "-" or f"'{word}'" in message]
        hint = _nearest(wrong, error.ctx.command) or _example(error.ctx)
    return InputError.named("command_line_wrong", message=message, hint=hint)


def _nearest(wrong: Sequence[str], command: Any) -> str:
    """Propose the option, value or command that is nearest to a wrong word."""
    from difflib import get_close_matches

    known = _known_words(command)
    for word in wrong:
        for near in get_close_matches(word.lower().lstrip("-"), known, n=1):
            if known[near] != word:
                return f"did you mean {known[near]}?"
    return ""


def _known_words(command: Any) -> dict[str, str]:
    """Return what a user can mean by a word, and how to type it."""
    known = {name: name for name in getattr(command, "commands", ())}
    options = [param for param in command.params if param.opts[0].startswith("-")]
    for option in options:
        for value in option.type_descriptor.choices or ():
            known.setdefault(value, f"{option.opts[0]} {value}")
        known |= {name.lstrip("-"): name for name in option.opts}
    return known


def _example(context: Any) -> str:
    """Show the first example of a command, and name its help."""
    help_of = f"{context.command_path} --help"
    _, *examples = (context.command.epilog or "").replace("\\", "").split("gyro ")
    if not examples:
        return f"see: {help_of}"
    return f"for example: gyro {' '.join(examples[0].split())}; all options: {help_of}"


def _open_streams() -> None:
    """Write UTF-8 to files and pipes on every system.

    A sign that a terminal does not have is written with its name.
    """
    for name in ("stdin", "stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            # A closed stream is empty, and writing to it is an error.
            setattr(sys, name, Path(os.devnull).open())  # noqa: SIM115
        # The streams of tests and notebooks accept every character.
        elif isinstance(stream, TextIOWrapper) and stream.writable():
            encoding = stream.encoding if stream.isatty() else "utf-8"
            stream.reconfigure(encoding=encoding, errors="namereplace")


def _fault(error: Exception, log: str) -> Diagnostic:
    """Describe a fault of gyro itself; GYRO_DEBUG=1 prints the traceback."""
    import traceback

    if os.environ.get("GYRO_DEBUG"):
        tell("".join(traceback.format_exception(error)))
    frame = traceback.extract_tb(error.__traceback__)[-1]
    place = f" in {Path(frame.filename).stem}.{frame.name}, line {frame.lineno}"
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

    Pages have their width and their colours already. NO_COLOR and TERM are respected.
    """
    if not stream.isatty() or "\033" in text:
        return text
    text = "\n".join(map(_wrapped, text.split("\n")))
    if os.environ.get("NO_COLOR"):
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


def _wrapped(line: str) -> str:
    """Wrap a long line between words at the width of the terminal."""
    indent = len(line) - len(line.lstrip()) + 2
    return textwrap.fill(
        line,
        shutil.get_terminal_size().columns,
        subsequent_indent=" " * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def write_out(text: str) -> None:
    """Write data to standard output; ``| head`` can close it."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        raise typer.Exit(0) from None
    except OSError as error:
        refuse("output_not_written", why=error.strerror or error)


def answer_text(form: str, document: dict[str, Any]) -> str:
    """Write the document of a result as JSON, on one line for ndjson."""
    from gyrodata.reporting.data import json_text

    return json_text(document, indent=None if form == "ndjson" else 2)


def write_answer(form: str, document: dict[str, Any], text: object) -> None:
    """Print a result: its document as JSON, or what `str` makes of `text`."""
    if form == "text":
        write_text(str(text))
    else:
        write_out(answer_text(form, document))


def write_text(text: str) -> None:
    """Write text to standard output, wrapped and coloured if it is a terminal."""
    write_out(for_stream(text, sys.stdout))


def tell(*lines: str) -> None:
    """Write lines to standard error; if it is closed, the answer is still printed."""
    for line in lines:
        with suppress(OSError):
            text = for_stream(line.translate(PICTURES), sys.stderr)
            print(text, file=sys.stderr, flush=True)


SEVERITIES = ("note", "warning", "error")


def place(finding: Diagnostic) -> tuple[int, int]:
    """Return the place of a diagnostic in its file, to sort by."""
    return finding.line or 0, finding.column or 0


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error; errors come last, where users see them."""
    for finding in sorted(diagnostics, key=_severity_and_place):
        if finding.severity == "error" or not quiet:
            tell(str(finding))


def _severity_and_place(finding: Diagnostic) -> tuple[int, tuple[int, int]]:
    return SEVERITIES.index(finding.severity), place(finding)


def refuse(name: str, /, **values: object) -> NoReturn:
    """Stop with one error, a message of a file `messages.toml`."""
    raise InputError.named(name, **values)


def finish(code: int, exit_zero: bool) -> NoReturn:
    """End a command; with --exit-zero, findings are no failure."""
    raise typer.Exit(0 if exit_zero and code == 1 else code)


@contextmanager
def progress_bar(
    whole: int, what: str, quiet: bool = False
) -> Iterator[Callable[[int], None]]:
    """Show the progress of a long computation on a terminal, and the time left.

    The context is a function that takes what is done.
    """
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    is_hidden = quiet or not sys.stderr.isatty()
    # A thread that draws the bar could stop the processes that are forked.
    with Progress(
        console=console, transient=True, auto_refresh=False, disable=is_hidden
    ) as bar:
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
    for column in zip(*rows, strict=True):
        longest = max(" ".join(column).split(), key=len)
        # A unit is below its quantity: columns of numbers stay narrow.
        table.add_column(column[0].replace(" [", "\n["), min_width=len(longest))
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
    short: Path
    """The same; absolute paths are relative to the folder that they share."""

    @property
    def name(self) -> str:
        """The name in messages and results."""
        return "<stdin>" if self.path == "-" else printable(self.short.as_posix())


def named_logs(typed: Sequence[str]) -> list[Log]:
    """Return the logs of a command with their names."""
    paths = list(map(Path, typed))
    folders = [path.parent for path in paths if path.is_absolute()]
    shared = ""
    # Two drives of Windows share no folder.
    with suppress(ValueError):
        shared = os.path.commonpath(folders)
    logs = []
    for word, path in zip(typed, paths, strict=True):
        short = path
        if path.is_absolute():
            short = path.relative_to(shared or path.parent)
        logs.append(Log(word, short))
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
    # A path that contains a line break is still a path.
    return sys.stdin.buffer if log.path == "-" else Path(log.path)
