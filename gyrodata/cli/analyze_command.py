"""``gyro analyze``: from logs to answers, figures and reports."""

from __future__ import annotations

import os
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.disk import telling, write_folder, write_whole
from gyrodata.base.errors import Diagnostic, GyroError, count_text
from gyrodata.cli import terminal
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    SettingsOption,
    constants_of,
    pairs,
)
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, Options

DATA = {"json": (".json",), "ndjson": (".ndjson", ".jsonl", ".json"), "csv": (".csv",)}
"""Endings of a file with data, by their format."""

FILE_TYPES = (
    ".pdf",
    ".html",
    ".txt",
    ".md",
    ".tex",
    ".doc",
    ".docx",
    ".xlsx",
    ".png",
    ".svg",
    ".json",
    ".ndjson",
    ".jsonl",
    ".csv",
)
"""Endings of a name that users mean as a file, not as the folder of a report."""

ENDINGS = re.compile(r"(?i)(?<=.)(\.xlsx)?(\.tsv)?(\.txt)?(\.csv)?(\.gz)?$")
"""Endings of a log that the name of its report omits."""

DOCUMENTS = {"markdown": "report.md", "latex": "report.tex"}
"""Name of the document next to its figures, by its format."""

PAUSE = 0.5
"""Time between two looks at a watched file [s]."""

Format = Literal["text", "json", "ndjson", "csv", "markdown", "latex"]
Model = Literal["auto", "horizontal", "steady", "released"]
Figures = Literal["png", "svg", "pdf"]
Style = Literal["screen", "print"]
Table = Literal["runs", "logs"]
OpenOption = Annotated[
    bool, typer.Option("--open", help="Open the report in the browser.")
]


def analyze(
    logs: Annotated[list[str], typer.Argument(metavar="LOG")],
    form: Annotated[Format, typer.Option("--format", "-f")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    out: Annotated[Path | None, typer.Option("--out", "-o")] = None,
    table: Annotated[Table, typer.Option("--table")] = "runs",
    no_report: Annotated[bool, typer.Option("--no-report")] = False,
    figures: Annotated[Figures, typer.Option("--figures")] = "svg",
    style: Annotated[Style, typer.Option("--style")] = "screen",
    model: Annotated[Model, typer.Option("--model")] = "auto",
    keep_flagged: Annotated[bool, typer.Option("--keep-flagged")] = False,
    worksheet: Annotated[bool, typer.Option("--worksheet")] = False,
    together: Annotated[bool, typer.Option("--together")] = False,
    watched: Annotated[bool, typer.Option("--watch")] = False,
    opened: OpenOption = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero")] = False,
) -> None:
    """Fit the moment of inertia I_zz to a log, and write figures and a report.

    Exit codes: 0 done; 1 done, but a log has errors; 2 wrong use, or a log that cannot
    be read; 3 a fault of gyro, which affects that log only.
    """
    out = _place_of(out, form)
    parts = _parts(logs, together)
    several = len(parts) > 1
    _refuse_contradictions(several, form, table, out)
    from gyrodata.results import Options

    options = Options(
        set=dict(sorted(pairs(settings, "--set").items())),
        map=dict(sorted(pairs(mapping, "--map").items())),
        model=model,
        keep_flagged=keep_flagged,
        worksheet=worksheet,
    )
    request = _Request(options, config, form, table, figures, style, verbose, several)
    if watched:
        _refuse_watching(logs, form, out)
        _watch(Path(logs[0]), replace(request, config=constants_of(logs[0], config)))
        return
    file = _data_file(out, form)
    reported = not no_report and file is None and (out is not None or form == "text")
    if opened and not reported:
        terminal.refuse("open_without_report")
    output = _Output(form, _table_header(form, table), file, opened, quiet)
    worst = 0
    for part, below in parts:
        log = part[0][0]
        folder = _report_folder(log, out, below, several) if reported else None
        requests = request.of_logs(part, config, quiet)
        of_log = requests[0]
        outcome = _answer(part, requests, below, folder is not None)
        output.show_answer(outcome.text, folder is not None)
        # The answer is on the screen while the figures are drawn.
        outcome = _with_report(outcome, of_log, folder)
        output.show_findings(outcome)
        worst = max(worst, outcome.code)
    output.finish()
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _parts(
    logs: Sequence[str], together: bool
) -> list[tuple[list[tuple[str, str]], Path]]:
    """List what gets one answer: logs with their names, and the folder of the report."""
    folders = _folders(terminal.short_paths(logs))
    named = list(zip(logs, terminal.names_of(logs), strict=True))
    if together and len(logs) > 1:
        name = f"{Path(named[0][1]).stem}-together-report"
        return [(named, folders[0].with_name(name))]
    return [([each], folder) for each, folder in zip(named, folders, strict=True)]


def _place_of(out: Path | None, form: Format) -> Path | None:
    """Return the place of ``--out``; None for "-", to which data go without it too."""
    return None if out == Path("-") and form != "text" else out


def _data_file(out: Path | None, form: Format) -> Path | None:
    """Return the file for the data; None if ``--out`` is a folder, or is not given."""
    if out is not None and out.suffix.lower() in DATA.get(form, ()):
        return out
    return None


def _table_header(form: Format, table: Table) -> str:
    if form != "csv":
        return ""
    from gyrodata.reporting.data import table_header

    return table_header(table)


def _report_folder(
    log: str, out: Path | None, below: Path, several: bool
) -> Path | None:
    """Return the folder of a report; None for standard input without ``--out``."""
    if out is not None:
        return out / below if several else out
    return None if log == "-" else below


class _Output(Struct):
    """Where the answers go, and the messages about them."""

    form: Format
    header: str
    """Line before the first answer."""
    file: Path | None
    """Data go into a file completely, or not at all."""
    opened: bool
    quiet: bool
    parts: list[str] = []

    def show_answer(self, text: str, in_folder: bool) -> None:
        """Print the answer for one log, or keep it for the file.

        `in_folder` says whether the log gets a report.
        """
        if self.file is not None:
            self.parts.append(text)
        elif self.form == "text":
            terminal.write_text(text)
        elif text and not self._is_in_file(in_folder):
            terminal.write_out(self.header + text)
            self.header = ""

    def _is_in_file(self, in_folder: bool) -> bool:
        """Return whether the text is a document that a terminal need not show."""
        return in_folder and self.form in DOCUMENTS and sys.stdout.isatty()

    def show_findings(self, outcome: _Outcome) -> None:
        """Print the messages about one log, and where its report is."""
        terminal.complain(outcome.diagnostics, self.quiet)
        if outcome.report is not None and not self.quiet:
            terminal.tell(f"report: {outcome.report}")
        if outcome.report is not None and self.opened:
            import webbrowser

            page = outcome.report.with_name("report.html")
            webbrowser.open(page.resolve().as_uri())
        if self.form == "text" and sys.stdout.isatty() and not self.quiet:
            self._repeat_answer(outcome)

    def _repeat_answer(self, outcome: _Outcome) -> None:
        """Print a last line with the answer, which messages have moved off the screen."""
        counts = Counter(finding.severity for finding in outcome.diagnostics)
        if outcome.analysis is None or not counts["warning"] + counts["error"]:
            return
        from gyrodata.reporting.text import answer_line

        words = [
            count_text(counts[severity], severity)
            for severity in ("error", "warning")
            if counts[severity]
        ]
        terminal.tell(f"{' and '.join(words)} above; {answer_line(outcome.analysis)}")

    def finish(self) -> None:
        """Write the file, if the data go into one."""
        if self.file is not None:
            with telling(self.file.parent):
                write_whole(self.file, ["".join([self.header, *self.parts]).encode()])


def demo(opened: OpenOption = False) -> None:
    """Write a sample log, demo.csv, into this folder, and analyze it.

    The log contains ten runs with an air gyroscope.
    """
    from gyrodata.cli import documentation

    log = Path("demo.csv")
    data = (documentation.FOLDER / "demo.csv").read_bytes()
    if log.exists() and log.read_bytes() != data:
        terminal.refuse("demo_exists")
    with telling(log):
        write_whole(log, [data])
    terminal.tell(
        "demo.csv is a sample log: change a number in it, then type: gyro check demo.csv"
    )
    terminal.tell(
        "for your own log: gyro template --out log.xlsx",
        "for a guide from Excel to the report: gyro explain first-timer",
    )
    analyze([log.name], opened=opened)


def _refuse_contradictions(
    several: bool, form: Format, table: Table, out: Path | None
) -> None:
    """Refuse options that contradict each other; `several`: there are several answers."""
    if form in ("json", "latex") and several:
        terminal.refuse(
            "format_for_one_log",
            form=form,
            other="ndjson" if form == "json" else "markdown",
        )
    if table != "runs" and form != "csv":
        terminal.refuse("table_for_csv", table=table)
    if out is not None:
        _refuse_file_for_report(out, form)


def _refuse_watching(logs: Sequence[str], form: Format, out: Path | None) -> None:
    """Refuse to watch anything but one file."""
    if len(logs) > 1 or logs[0] == "-" or form != "text" or out:
        terminal.refuse("watch_one_file")


def _refuse_file_for_report(out: Path, form: Format) -> None:
    """Refuse a name of a file for a report, which is a folder."""
    if out == Path("-"):
        other = "for the report: --out FOLDER; for data on standard output: -f json"
        terminal.refuse("out_is_a_file", out=out, ways=other)
    ending = out.suffix.lower()
    if ending not in FILE_TYPES or ending in DATA.get(form, ()) or out.is_dir():
        return
    ways = [
        f"for a folder with report.html and the figures: --out {out.with_suffix('')}"
    ]
    ways += [
        f"for a file with the data: --format {data} --out {out}"
        for data in DATA
        if ending == f".{data}"
    ]
    if ending == ".pdf":
        ways.append("for a PDF, print report.html from the browser")
    terminal.refuse("out_is_a_file", out=out, ways="; ".join(ways))


class _Request(Struct, frozen=True):
    """The options of one call of ``gyro analyze``."""

    options: Options
    config: Path | None
    form: Format
    table: Table
    figures: Figures
    style: Style
    verbose: bool
    several: bool
    """True if there are several logs."""

    def with_constants(self, config: Path | None) -> _Request:
        """Return the same request with the file of constants of one log."""
        name = None if config is None else config.name
        options = replace(self.options, config=name)
        return replace(self, config=config, options=options)

    def of_logs(
        self, named: Sequence[tuple[str, str]], config: Path | None, quiet: bool
    ) -> list[_Request]:
        """Return the same request with the constants of each log."""
        return [
            self.with_constants(constants_of(log, config, quiet)) for log, _ in named
        ]

    def for_reading(self) -> dict[str, Any]:
        """Return the constants and headers of the options."""
        return {
            "settings": self.options.set,
            "mapping": self.options.map,
            "config": self.config,
        }

    def read(self, **source: Any) -> Readings:
        """Read a log with the constants and headers of the options."""
        from gyrodata.readings import read_log

        return read_log(**source, **self.for_reading())


# --- --watch: the answer again whenever the log is saved ---


def _watch(path: Path, request: _Request) -> None:
    """Print the state of the lab, now and after each change of the log, until Ctrl-C.

    On a terminal each state replaces the last one; elsewhere a line separates them.
    """
    if path.is_fifo():
        terminal.refuse("watch_one_file")
    if not path.is_file():
        request.read(source=path)
    on_terminal = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    before = ""
    for data in contents(path):
        text = (
            f"{path.name}: cannot be read now\n"
            if data is None
            else _state(path.name, data, request)
        )
        if on_terminal:
            # Clear the screen first.
            text = terminal.wrapped(text, sys.stdout)
            text = terminal.coloured(text, sys.stdout)
            terminal.write_out(
                f"\033[H\033[2J{text}\nwatching {path.name}; Ctrl-C ends it\n"
            )
        else:
            terminal.write_out(before + text)
        before = "-" * 72 + "\n"


def contents(path: Path) -> Iterator[bytes | None]:
    """Yield the content of a file after each change; None if it cannot be read.

    Two looks in sequence have to agree, because a program may still be writing the
    file.
    """
    from gyrodata.readings import MAX_BYTES

    data = last = shown = None
    for look in range(sys.maxsize):
        try:
            # To open a pipe without a writer would wait for ever.
            data = _content(path, MAX_BYTES + 1) if path.is_file() else None
        except OSError:
            data = None
        if look == 0 or (data == last and data != shown):
            shown = data
            yield data
        last = data
        time.sleep(PAUSE)


def _content(path: Path, most: int) -> bytes:
    """Return the first bytes of a file, or nothing of a pipe that took its place."""
    number = os.open(
        path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    )
    with os.fdopen(number, "rb") as file:
        return file.read(most) or b""


def _state(name: str, data: bytes, request: _Request) -> str:
    """Write the answer so far, and what ``gyro check`` says of the log."""
    from gyrodata.cli.check_command import check_log
    from gyrodata.reporting.text import answer_line

    def read() -> Readings:
        from gyrodata.readings import read_log

        return read_log(data, name=name, **request.for_reading())

    checked = check_log(name, read, request.options)
    if checked.analysis is None:
        return str(checked)
    return f"{checked}{answer_line(checked.analysis)}\n"


# --- one log ---


def _folders(paths: Sequence[Path]) -> list[Path]:
    """Name the folder of each log's report, below that of the log if there are several.

    Equal names get numbers.
    """
    folders: list[Path] = []
    for path in paths:
        # A folder that is given by mistake may have no name: "." or "/".
        stem = "stdin" if path == Path("-") else ENDINGS.sub("", path.name) or "log"
        parts = (
            [part for part in path.parent.parts if part not in ("..", path.anchor)]
            if len(paths) > 1
            else []
        )
        folder = Path(*parts, f"{stem}-report")
        number = 1
        while folder in folders:
            number += 1
            folder = Path(*parts, f"{stem}-report-{number}")
        folders.append(folder)
    return folders


class _Outcome(Struct, frozen=True):
    """The output for one log."""

    code: int
    """Exit code."""
    text: str
    """Text for standard output."""
    diagnostics: Sequence[Diagnostic]
    analysis: Analysis | None = None
    """None if the log has no answer."""
    report: Path | None = None
    """The report, if one was written."""

    def with_findings(self, findings: Sequence[Diagnostic], code: int) -> _Outcome:
        """Return the same outcome with more findings and another exit code."""
        return replace(self, code=code, diagnostics=(*self.diagnostics, *findings))


def _answer(
    named: Sequence[tuple[str, str]],
    requests: Sequence[_Request],
    below: Path,
    has_report: bool,
) -> _Outcome:
    """Analyse one log, or several together; `below` is a part of the report's path."""
    from gyrodata.analysis import analyze_readings
    from gyrodata.readings.together import read_together

    readings = None
    request = requests[0]
    name = " + ".join(name for _, name in named)
    try:
        readings = read_together(
            [
                of_log.read(**terminal.source_of(*each))
                for each, of_log in zip(named, requests, strict=True)
            ]
        )
        analysis = analyze_readings(readings, request.options)
        text = _formatted(analysis, request, below, has_report)
    except GyroError as error:
        return _without_answer(
            name, readings, request, error.exit_code, error.diagnostics
        )
    except Exception as error:
        fault = terminal.fault(error, name)
        return _without_answer(name, readings, request, terminal.FAULT, (fault,))
    return _Outcome(0, text, analysis.diagnostics, analysis)


def _with_report(outcome: _Outcome, request: _Request, folder: Path | None) -> _Outcome:
    """Write the report of an answer into a folder, if there are both.

    The answer is right also if its report cannot be made: this adds an error then.
    """
    analysis = outcome.analysis
    if folder is None or analysis is None:
        return outcome
    document = DOCUMENTS.get(request.form, "")
    try:
        files, findings = _report_of(analysis, request, document)
        with telling(folder):
            write_folder(folder, files)
    except GyroError as error:
        return outcome.with_findings(error.diagnostics, error.exit_code)
    except Exception as error:
        fault = terminal.fault(error, analysis.name)
        return outcome.with_findings([fault], terminal.FAULT)
    report = folder / (document or "report.html")
    return replace(outcome.with_findings(findings, 0), report=report)


def _report_of(
    analysis: Analysis, request: _Request, document: str
) -> tuple[dict[str, bytes], list[Diagnostic]]:
    """Make the files of a report.

    Also return a warning about each reason why figures cannot be drawn.
    """
    from gyrodata.reporting.page import report_files

    faults: dict[str, str] = {}
    files = report_files(analysis, request.figures, request.style, document, faults)
    reasons = {
        why: [figure for figure in faults if faults[figure] == why]
        for why in faults.values()
    }
    return files, [
        Diagnostic.named(
            "figure_not_drawn", analysis.name, what=listing(figures), why=why
        )
        for why, figures in reasons.items()
    ]


def _without_answer(
    name: str,
    readings: Readings | None,
    request: _Request,
    code: int,
    diagnostics: Sequence[Diagnostic],
) -> _Outcome:
    """Describe a log without an answer; programs get an object or a row for it too."""
    from gyrodata.reporting.data import json_text, log_row
    from gyrodata.results import AnalysisDocument, Input, to_json

    text = ""
    if request.form == "csv" and request.table == "logs":
        text = log_row(name, {}, diagnostics)
    elif request.form in ("json", "ndjson"):
        log = (
            Input(name, readings.sha256, len(readings.runs))
            if readings
            else Input(name, None, None)
        )
        rows = tuple(diagnostic.to_dict() for diagnostic in diagnostics)
        document = AnalysisDocument(
            input=log, options=request.options, result=None, diagnostics=rows
        )
        text = json_text(
            to_json(document), indent=2 if request.form == "json" else None
        )
    return _Outcome(code, text, diagnostics)


def _formatted(
    analysis: Analysis, request: _Request, below: Path, written: bool
) -> str:
    """Write an analysis in the format of the request; `written`: it has a report."""
    from gyrodata.reporting.data import json_text, table_rows

    form = request.form
    after = "\n" * request.several
    if form == "csv":
        return table_rows(analysis, request.table)
    if form in ("json", "ndjson"):
        return json_text(analysis.to_dict(), indent=2 if form == "json" else None)
    if form == "text":
        from gyrodata.reporting.text import summary

        log = analysis.name if re.fullmatch(r"[\w./-]+", analysis.name) else "LOG"
        rest = f"More: gyro analyze {log} -v" + ", or open the HTML report" * written
        return summary(analysis, request.verbose, rest, terminal.columns()) + after
    if form == "markdown":
        from urllib.parse import quote

        from gyrodata.reporting.markdown import markdown_report
        from gyrodata.reporting.page import alternatives, shown_form

        # The document of one log is in the folder of its figures, that of several logs
        # is next to their folders.
        place = quote(os.fsencode(f"{below.as_posix()}/")) if request.several else ""
        figures = f"{place}{{}}.{shown_form(request.figures)}"
        return markdown_report(analysis, figures, alternatives(analysis)) + after
    from gyrodata.reporting.latex import latex_report

    return latex_report(analysis)
