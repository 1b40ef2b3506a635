"""``gyro analyze``: from logs to answers, figures and reports."""

from __future__ import annotations

import itertools
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.disk import telling, write_folder, write_whole
from gyrodata.base.errors import Diagnostic, count_text
from gyrodata.cli import terminal
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    Reader,
    SettingsOption,
    input_of,
    stem_of,
)
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.cli.terminal import Log
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, Options

DATA = {"json": (".json",), "ndjson": (".ndjson", ".jsonl", ".json"), "csv": (".csv",)}
"""Endings of a file with data, by their format."""

DOCUMENTS = {"markdown": "report.md", "latex": "report.tex"}
"""Name of the document next to its figures, by its format."""

REPORT = ("report.html", "results.json", "runs.csv", *DOCUMENTS.values())
"""Files of a report, which could be logs; the page shows that a folder is a report."""

FILE_TYPES = {".pdf", ".html", ".txt", ".md", ".tex", ".docx", ".xlsx", ".png", ".svg"}
FILE_TYPES |= {".json", ".ndjson", ".jsonl", ".csv"}
"""Endings of a name that users mean as a file, not as the folder of a report."""

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
    logs: Annotated[
        list[str],
        typer.Argument(metavar="LOG", help="Logs: CSV, text or workbook; - is stdin."),
    ],
    form: Annotated[
        Format, typer.Option("--format", "-f", help="What to write to standard output.")
    ] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="Folder for the report; several logs have one folder each inside it. "
            "Default: LOG-report, if the format is text. A LaTeX or Markdown document "
            "goes there too with its figures. With FILE.json, .ndjson or .csv, the "
            "data go into this file.",
        ),
    ] = None,
    table: Annotated[
        Table,
        typer.Option(
            "--table", help="For --format csv: one row for each run, or for each log."
        ),
    ] = "runs",
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Write no report.")
    ] = False,
    figures: Annotated[
        Figures, typer.Option("--figures", help="File type of the figures.")
    ] = "svg",
    style: Annotated[
        Style,
        typer.Option(
            "--style",
            help="Figures for the screen or for one column of a printed page (300 dots"
            " per inch).",
        ),
    ] = "screen",
    model: Annotated[
        Model,
        typer.Option(
            "--model",
            help="horizontal: eq. (9); steady: eq. (8); released: released from rest; "
            "auto: the simplest model that is sufficient.",
        ),
    ] = "auto",
    keep_flagged: Annotated[
        bool, typer.Option("--keep-flagged", help="Keep suspected outliers in the fit.")
    ] = False,
    worksheet: Annotated[
        bool,
        typer.Option(
            "--worksheet",
            help="In the report, ask questions with hints instead of giving "
            "conclusions.",
        ),
    ] = False,
    together: Annotated[
        bool,
        typer.Option(
            "--together",
            help="Analyze several logs of one gyroscope as one: days, groups.",
        ),
    ] = False,
    watched: Annotated[
        bool,
        typer.Option(
            "--watch",
            help="During the lab: whenever you save the file, print the answer and "
            "what gyro check says. Ctrl-C ends it. No report is written.",
        ),
    ] = False,
    opened: OpenOption = False,
    verbose: Annotated[
        bool,
        typer.Option("--verbose", "-v", help="Print the full report in the terminal."),
    ] = False,
    quiet: Annotated[
        bool,
        typer.Option("--quiet", "-q", help="On standard error, print errors only."),
    ] = False,
    exit_zero: Annotated[
        bool, typer.Option("--exit-zero", help="Exit with 0 even if a log has errors.")
    ] = False,
) -> None:
    """Fit the moment of inertia I_zz to a log, and write figures and a report.

    Exit codes: 0 done; 1 done, but a log has errors; 2 wrong use, or a log that cannot
    be read; 3 a fault of gyro, which affects that log only.

    Example:  gyro analyze demo.csv
              gyro analyze demo.csv --worksheet
              gyro analyze demo.csv --no-report --format json
    """
    if form != "text" and out == Path("-"):
        # Data go to standard output without --out too.
        out = None
    parts = terminal.in_parts(logs, together, form)
    _refuse_contradictions(form, table, out, no_report)
    from gyrodata.results import Options

    reader = Reader.of_options(settings, mapping, config, quiet)
    options = Options(
        set=reader.settings,
        map=reader.mapping,
        model=model,
        keep_flagged=keep_flagged,
        worksheet=worksheet,
    )
    if watched:
        _watch(logs, reader, options, alone=form == "text" and out is None)
        return
    file = _data_file(out, form)
    has_report = not no_report and _goes_with_report(form, out, file)
    if opened and not has_report:
        terminal.refuse("open_without_report")
    output = _Output(
        form=form,
        table=table,
        figures=figures,
        style=style,
        verbose=verbose,
        several=len(parts) > 1,
        file=file,
        out=out,
        has_report=has_report,
        opened=opened,
        quiet=quiet,
    )
    worst = 0
    for part, below in zip(parts, _report_folders(parts), strict=True):
        worst = max(worst, _analyze_part(part, reader, options, output, below))
    output.finish()
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _data_file(out: Path | None, form: Format) -> Path | None:
    """Return the file for the data; None if ``--out`` is a folder, or is not given."""
    if out is not None and out.suffix.lower() in DATA.get(form, ()):
        return out
    return None


def _goes_with_report(form: Format, out: Path | None, file: Path | None) -> bool:
    """Return whether a report is written, unless the user wants none."""
    if out is None:
        return form == "text"
    return file is None


def _refuse_contradictions(
    form: Format, table: Table, out: Path | None, no_report: bool
) -> None:
    """Refuse options that contradict each other."""
    if table != "runs" and form != "csv":
        terminal.refuse("table_for_csv", table=table)
    if out is not None:
        _refuse_file_for_report(out, form)
        if no_report and _data_file(out, form) is None:
            terminal.refuse("folder_without_report", out=out)


def _refuse_file_for_report(out: Path, form: Format) -> None:
    """Refuse a name of a file for a report, which is a folder."""
    if out == Path("-"):
        terminal.refuse("out_is_standard_output")
    ending = out.suffix.lower()
    if ending not in FILE_TYPES or ending in DATA.get(form, ()) or out.is_dir():
        return
    folder = out.with_suffix("")
    data = ending.removeprefix(".")
    if data in DATA:
        terminal.refuse("out_is_data", out=out, folder=folder, form=data)
    terminal.refuse("out_is_a_file", out=out, folder=folder)


# --- the folders of reports ---


def _report_folders(parts: Sequence[Sequence[Log]]) -> Iterator[Path]:
    """Name the folder of each report, below that of the log if there are several.

    Equal names get numbers.
    """
    used: Counter[Path] = Counter()
    paths = terminal.short_paths([part[0].path for part in parts])
    for part, path in zip(parts, paths, strict=True):
        name = stem_of(path) + "-together" * (len(part) > 1)
        above = Path()
        if len(parts) > 1:
            above = above.joinpath(
                *(step for step in path.parent.parts if step not in ("..", path.anchor))
            )
        folder = above / f"{name}-report"
        used[folder] += 1
        if used[folder] > 1:
            folder = folder.with_name(f"{folder.name}-{used[folder]}")
        yield folder


# --- one answer ---


def _analyze_part(
    logs: Sequence[Log],
    reader: Reader,
    options: Options,
    output: _Output,
    below: Path,
) -> int:
    """Analyse one log, or several together, and return the exit code.

    Parameters
    ----------
    logs : sequence of Log
    reader : Reader
    options : Options
    output : _Output
        Where the answer goes.
    below : Path
        The folder of the report, relative to the folder of all reports.
    """
    from gyrodata.analysis import analyze_readings

    options = replace(options, config=reader.name_of_constants(logs[0].path))
    name = " + ".join(log.name for log in logs)
    folder = output.folder_of(logs, below)
    output.refuse_to_replace_data(logs, folder)
    readings = None
    try:
        readings = reader.read(logs)
        analysis = analyze_readings(readings, options)
        command = reader.command_for(logs)
        text = output.text_of(analysis, below, folder is not None, command)
    except Exception as error:
        findings, code = terminal.explained(error, name)
        output.show(output.text_without(name, readings, options, findings))
        terminal.complain(findings, output.quiet)
        return code
    # The answer is on the screen while the figures are drawn.
    output.show(text, folder is not None)
    code = 0
    findings = analysis.diagnostics
    report = None
    if folder is not None:
        try:
            report, faults = output.write_report(analysis, folder)
        except Exception as error:
            # The answer is right also if its report cannot be made.
            faults, code = terminal.explained(error, name)
        findings = (*findings, *faults)
    terminal.complain(findings, output.quiet)
    output.end(analysis, findings, report)
    return code


class _Output(Struct):
    """How the answers are written, and where they go."""

    form: Format
    table: Table
    figures: Figures
    style: Style
    verbose: bool
    several: bool
    """True if there are several answers."""
    file: Path | None
    """Data go into a file completely, or not at all."""
    out: Path | None
    """The folder for the reports, if the user names one."""
    has_report: bool
    opened: bool
    quiet: bool
    parts: list[str] = []
    """The texts of the answers so far."""

    def folder_of(self, logs: Sequence[Log], below: Path) -> Path | None:
        """Return the folder of a report; None without a report.

        Standard input has a report only with ``--out``.
        """
        if not self.has_report or (self.out is None and logs[0].path == "-"):
            return None
        if self.out is None:
            return below
        return self.out / below if self.several else self.out

    def refuse_to_replace_data(self, logs: Sequence[Log], folder: Path | None) -> None:
        """Refuse an output that would replace a log, or other data of the user."""
        outputs = [self.file] if self.file else []
        if folder is not None:
            outputs = [folder / name for name in REPORT]
            is_report = outputs[0].exists()
            is_named = self.out is not None
            if is_named and not is_report and any(out.exists() for out in outputs):
                terminal.refuse("folder_with_data", out=folder)
        sources = {Path(log.path).resolve() for log in logs}
        if not sources.isdisjoint([out.resolve() for out in outputs]):
            terminal.refuse("out_is_the_log", out=self.out)

    def text_of(
        self, analysis: Analysis, below: Path, has_report: bool, command: str
    ) -> str:
        """Write an analysis in the format of the command.

        `command` is what a user types for the full report.
        """
        from gyrodata.reporting.data import json_text, table_rows

        after = "\n" * self.several
        if self.form == "csv":
            return table_rows(analysis, self.table)
        if self.form in ("json", "ndjson"):
            return json_text(analysis.to_dict(), self._indent())
        if self.form == "text":
            from gyrodata.reporting.text import summary

            more = f"More: {command} -v"
            more += ", or open the HTML report" * has_report
            return summary(analysis, self.verbose, more, terminal.columns()) + after
        if self.form == "markdown":
            return self._markdown(analysis, below) + after
        from gyrodata.reporting.latex import latex_report

        return latex_report(analysis)

    def _indent(self) -> int | None:
        return 2 if self.form == "json" else None

    def _markdown(self, analysis: Analysis, below: Path) -> str:
        from urllib.parse import quote

        from gyrodata.reporting.markdown import markdown_report
        from gyrodata.reporting.page import shown_form

        figures = f"{{}}.{shown_form(self.figures)}"
        if self.several:
            # The document of several logs is next to the folders of their figures.
            figures = quote(os.fsencode(f"{below.as_posix()}/")) + figures
        return markdown_report(analysis, figures)

    def text_without(
        self,
        name: str,
        readings: Readings | None,
        options: Options,
        findings: Sequence[Diagnostic],
    ) -> str:
        """Describe a log without an answer: an object or a row for programs."""
        from gyrodata.reporting.data import json_text, log_row
        from gyrodata.results import AnalysisDocument, to_json

        if self.form == "csv" and self.table == "logs":
            return log_row(name, {}, findings)
        if self.form not in ("json", "ndjson"):
            return ""
        document = AnalysisDocument(
            input=input_of(name, readings),
            options=options,
            result=None,
            diagnostics=tuple([finding.to_dict() for finding in findings]),
        )
        return json_text(to_json(document), self._indent())

    def show(self, text: str, has_report: bool = False) -> None:
        """Print the text about one log, or keep it for the file."""
        if not text:
            return
        if self.form == "csv" and not self.parts:
            from gyrodata.reporting.data import table_header

            text = table_header(self.table) + text
        self.parts.append(text)
        if self.file is not None:
            return
        if self.form == "text":
            terminal.write_text(text)
            return
        # A document is next to its figures: a terminal need not show it.
        is_in_folder = has_report and self.form in DOCUMENTS
        if not (is_in_folder and sys.stdout.isatty()):
            terminal.write_out(text)

    def write_report(
        self, analysis: Analysis, folder: Path
    ) -> tuple[Path, Sequence[Diagnostic]]:
        """Write the report of an answer into a folder.

        Return the page or the document, and a warning about each reason why figures
        cannot be drawn.
        """
        from gyrodata.reporting.page import report_files

        document = DOCUMENTS.get(self.form, "")
        faults: dict[str, str] = {}
        files = report_files(analysis, self.figures, self.style, document, faults)
        with telling(folder):
            write_folder(folder, files)
        warnings = []
        for why in dict.fromkeys(faults.values()):
            figures = listing([name for name in faults if faults[name] == why])
            warnings.append(
                Diagnostic.named(
                    "figure_not_drawn", analysis.name, what=figures, why=why
                )
            )
        return folder / (document or "report.html"), warnings

    def end(
        self, analysis: Analysis, findings: Sequence[Diagnostic], report: Path | None
    ) -> None:
        """Print where the report is, and the answer if messages moved it off a screen."""
        if report is not None and self.opened:
            import webbrowser

            webbrowser.open(report.with_name("report.html").resolve().as_uri())
        if self.quiet:
            return
        if report is not None:
            terminal.tell(f"report: {report}")
        counts = Counter(finding.severity for finding in findings)
        words = [
            count_text(counts[severity], severity)
            for severity in ("error", "warning")
            if counts[severity]
        ]
        if words and self.form == "text" and sys.stdout.isatty():
            from gyrodata.reporting.text import answer_line

            terminal.tell(f"{' and '.join(words)} above; {answer_line(analysis)}")

    def finish(self) -> None:
        """Write the file, if the data go into one."""
        if self.file is not None:
            with telling(self.file.parent):
                write_whole(self.file, ["".join(self.parts).encode()])


def demo(opened: OpenOption = False) -> None:
    """Write a sample log, demo.csv, into this folder, and analyze it.

    The log contains ten runs with an air gyroscope.

    Example:  gyro demo
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


# --- --watch: the answer again whenever the log is saved ---


def _watch(logs: Sequence[str], reader: Reader, options: Options, alone: bool) -> None:
    """Print the state of the lab, now and after each change of the log, until Ctrl-C.

    On a terminal each state replaces the last one; elsewhere a line separates them.
    `alone` says that no other output is asked for.
    """
    path = Path(logs[0])
    if len(logs) > 1 or logs[0] == "-" or path.is_fifo() or not alone:
        terminal.refuse("watch_one_file")
    constants = reader.constants_of(str(path))
    options = replace(options, config=reader.name_of_constants(str(path)))
    if not path.is_file():
        reader.read_source(path, path.name, constants)
    on_terminal = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    before = ""
    for data in contents(path):
        text = f"{path.name}: cannot be read now\n"
        if data is not None:
            read = partial(reader.read_source, data, path.name, constants)
            text = _state(path.name, read, options)
        if on_terminal:
            # Clear the screen first.
            terminal.write_out("\033[H\033[2J")
            text += f"\nwatching {path.name}; Ctrl-C ends it\n"
        terminal.write_text(before + text)
        if not on_terminal:
            before = "-" * 72 + "\n"


def contents(path: Path) -> Iterator[bytes | None]:
    """Yield the content of a file after each change; None if it cannot be read.

    Two looks in sequence have to agree, because a program may still be writing the
    file.
    """
    last = shown = None
    for look in itertools.count():
        data = None
        try:
            # To open a pipe without a writer would wait for ever.
            if path.is_file():
                data = path.read_bytes()
        except OSError:
            pass
        if look == 0 or (data == last and data != shown):
            shown = data
            yield data
        last = data
        time.sleep(PAUSE)


def _state(name: str, read: partial[Readings], options: Options) -> str:
    """Write what ``gyro check`` says of the log, and the answer so far."""
    from gyrodata.cli.check_command import check_log
    from gyrodata.reporting.text import answer_line

    checked = check_log(name, read, options)
    if checked.analysis is None:
        return str(checked)
    return f"{checked}{answer_line(checked.analysis)}\n"
