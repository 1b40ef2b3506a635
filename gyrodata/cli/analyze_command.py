"""``gyro analyze``: from logs to answers, figures and reports."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from msgspec import Struct

from gyrodata.cli.options import ConfigOption, MappingOption, SettingsOption, StdinOption, pairs
from gyrodata.cli.terminal import (
    FAULT,
    STDIN,
    coloured,
    complain,
    fault,
    names_of,
    refuse,
    short_paths,
    source_of,
    tell,
    wrapped,
    write_out,
)
from gyrodata.diagnostics import (
    CANNOT_BE_WATCHED,
    FORMAT_FOR_ONE_LOG,
    OPTION_NOT_FOR_FORMAT,
    OUT_IS_NO_FOLDER,
    REPORT_CANNOT_BE_WRITTEN,
)
from gyrodata.disk import telling, write_folder, write_whole
from gyrodata.errors import Diagnostic, GyroError

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, Options


DATA = {"json": (".json",), "ndjson": (".ndjson", ".jsonl", ".json"), "csv": (".csv",)}
"""Endings of a file with data, by their format."""

FILE_TYPES = {
    *(".pdf", ".html", ".htm", ".txt", ".md", ".tex", ".doc", ".docx", ".odt", ".rtf", ".xls", ".xlsx", ".ods", ".zip"),
    *(".png", ".svg", ".jpg", ".json", ".ndjson", ".jsonl", ".csv", ".tsv"),
}
"""Endings of a name that is meant as that of a file, and not of the report's folder."""

DOCUMENTS = {"markdown": "report.md", "latex": "report.tex"}
"""What a document is called beside its figures, by its format."""

Format = Literal["text", "json", "ndjson", "csv", "markdown", "latex"]
Model = Literal["auto", "horizontal", "steady", "released"]
Figures = Literal["png", "svg", "pdf"]
Style = Literal["screen", "slides", "print"]
Table = Literal["runs", "logs"]


def analyze(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="Logs: CSV, text or workbook; - is stdin.")],
    form: Annotated[Format, typer.Option("--format", "-f", help="What to write to standard output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder for the report; several logs have one folder each inside it. "
                     "Default: LOG-report, if the format is text. A LaTeX or Markdown document goes there too with "
                     "its figures. With FILE.json, .ndjson or .csv, the data go into this file."),
    ] = None,
    table: Annotated[
        Table, typer.Option("--table", help="For --format csv: one row for each run, or for each log.")
    ] = "runs",
    stdin: StdinOption = STDIN,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    figures: Annotated[Figures, typer.Option("--figures", help="File type of the figures.")] = "png",
    style: Annotated[
        Style, typer.Option("--style", help="Figures for the screen, for slides (1920 x 1080, large letters), or for "
                     "print (300 dots per inch).")
    ] = "screen",
    model: Annotated[
        Model, typer.Option("--model", help="horizontal: eq. (9); steady: eq. (8); released: released from rest; "
                     "auto: the simplest model that is sufficient.")
    ] = "auto",
    keep_flagged: Annotated[bool, typer.Option("--keep-flagged", help="Keep suspected outliers in the fit.")] = False,
    worksheet: Annotated[
        bool, typer.Option("--worksheet", help="In the report, ask questions with hints instead of giving conclusions.")
    ] = False,
    watched: Annotated[
        bool,
        typer.Option("--watch", help="During the lab: whenever you save the file, print what is missing and which run "
                     "to repeat. Ctrl-C ends it. No report is written."),
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Print the full report in the terminal.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="On standard error, print errors only.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even if a log has errors.")] = False,
) -> None:  # fmt: skip
    """Fit the moment of inertia I_zz to a log, and write figures and a report.

    Exit codes: 0 done; 1 done, but a log has errors; 2 wrong use, or a log that cannot be read; 3 a fault of gyro,
    which affects that log only.
    """
    given = {"set": pairs(settings, "--set"), "map": pairs(mapping, "--map")}
    _refuse_what_does_not_go_together(logs, form, table, out, watched)
    from gyrodata.results import Options

    options = Options(
        set=dict(sorted(given["set"].items())),
        map=dict(sorted(given["map"].items())),
        config=config.name if config else None,
        model=model,
        keep_flagged=keep_flagged,
        worksheet=worksheet,
    )
    request = _Request(options, config, form, table, figures, style, verbose)
    # Data go into a file whole, or not at all.
    file = out if out is not None and form in DATA and out.suffix.lower() in DATA[form] else None
    if watched:
        _watch(Path(logs[0]), request)
        return
    paths = short_paths(logs)
    names, folders = names_of(paths, stdin), _folders(paths)
    reported = not no_report and file is None and (out is not None or form == "text")
    jobs = [
        _Job(log, name, folder, out, reported and (out is not None or log != "-"), request, len(logs))
        for log, name, folder in zip(logs, names, folders, strict=True)
    ]
    worst, header, whole = 0, _header(form, table), []
    # A document that is written to a file is not printed on a terminal too.
    spared = form in DOCUMENTS and sys.stdout.isatty()
    for told in map(_analyze_one, jobs):
        if told.text and file is not None:
            whole.append(told.text)
        elif told.text and not (spared and told.report):
            for_people = coloured(wrapped(told.text, sys.stdout), sys.stdout) if form == "text" else told.text
            write_out(header + for_people)
            header = ""
        complain(told.diagnostics, quiet)
        complain(told.not_written)
        if told.report and not quiet:
            tell(f"report: {told.report}")
        worst = max(worst, told.code)
    if file is not None:
        with telling(file.parent, REPORT_CANNOT_BE_WRITTEN):
            write_whole(file, ["".join([header, *whole]).encode()])
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _refuse_what_does_not_go_together(
    logs: Sequence[str], form: Format, table: Table, out: Path | None, watched: bool
) -> None:
    several = len(logs) > 1
    if form == "json" and several:
        refuse(FORMAT_FOR_ONE_LOG, "--format json is for one log", "use --format ndjson for several: one object a line")
    if form == "latex" and several:
        refuse(
            FORMAT_FOR_ONE_LOG,
            "--format latex is for one log: a document that compiles",
            "give one log, or use --format markdown",
        )
    if table != "runs" and form != "csv":
        hint = "add --format csv, or leave --table out"
        refuse(OPTION_NOT_FOR_FORMAT, f"--table {table} is for --format csv", hint)
    if (
        out is not None
        and out.suffix.lower() in FILE_TYPES
        and not (form in DATA and out.suffix.lower() in DATA[form])
        and not out.is_dir()
    ):
        data = next((one for one, endings in DATA.items() if out.suffix.lower() in endings), None)
        ways = [f"for a file with the data: --format {data} --out {out}"] if data else []
        text = {".txt": "text", ".md": "markdown", ".tex": "latex"}.get(out.suffix.lower())
        ways += [f"for a file with the text: --no-report --format {text} > {out}"] if text else []
        ways.append(f"for a folder with report.html and the figures: --out {out.with_suffix('')}")
        if out.suffix.lower() == ".pdf":
            ways.append("then print report.html to a PDF from the browser")
        refuse(OUT_IS_NO_FOLDER, f"--out {out} is the name of a file, and this report is a folder", "; ".join(ways))
    if watched and (several or logs[0] == "-" or form != "text" or out):
        refuse(
            CANNOT_BE_WATCHED,
            "--watch is for one file, and prints text only",
            "for example: gyro analyze log.csv --watch",
        )


class _Request(Struct, frozen=True):
    """The options of one call of ``gyro analyze``."""

    options: Options
    config: Path | None
    form: Format
    table: Table
    figures: Figures
    style: Style
    verbose: bool

    def read(self, **source: Any) -> Readings:
        """Read a log, with the constants and headers given as options."""
        from gyrodata.readings import read_log

        return read_log(**source, settings=self.options.set, mapping=self.options.map, config=self.config)


def _watch(path: Path, request: _Request) -> None:
    from gyrodata.analysis import analyze_readings
    from gyrodata.cli.watching import watch

    if not path.is_file():
        request.read(source=path)
    watch(
        path,
        lambda data: request.read(source=data, name=path.name),
        lambda readings: analyze_readings(readings, request.options),
    )


def _header(form: Format, table: Table) -> str:
    """Return the header above the rows of all logs."""
    if form != "csv":
        return ""
    from gyrodata.reporting.data import table_header

    return table_header(table)


def _folders(paths: Sequence[Path]) -> list[Path]:
    """Name the folder of each log's report, below that of the log where there are several; one name gets numbers."""
    folders: list[Path] = []
    taken: dict[Path, int] = {}
    for path in paths:
        # A folder that is given by mistake may have no name: "." or "/".
        stem = Path("stdin" if path == Path("-") else _stem(path.name) or "log")
        if len(paths) > 1:
            # Never above the folder that is asked for.
            stem = Path(*(part for part in path.parent.parts if part not in ("..", path.anchor)), stem)
        taken[stem] = taken.get(stem, 0) + 1
        told = f"{stem.name}-report" if taken[stem] == 1 else f"{stem.name}-report-{taken[stem]}"
        folders.append(stem.with_name(told))
    return folders


class _Job(Struct, frozen=True):
    """One log to analyse."""

    log: str
    name: str
    """What it is called."""
    below: Path
    """Folder of its report, …"""
    out: Path | None
    """… below this one, which is that folder itself for a single log, …"""
    written: bool
    """… if it has one."""
    request: _Request
    count: int
    """How many logs there are."""

    @property
    def folder(self) -> Path:
        """Where its report goes."""
        if self.out is None:
            return self.below
        return self.out if self.count == 1 else self.out / self.below


class _Told(Struct, frozen=True):
    """The output for one log."""

    code: int
    """To exit with."""
    text: str
    """For standard output."""
    diagnostics: Sequence[Diagnostic]
    report: str | None = None
    """Where the report was written."""
    not_written: Sequence[Diagnostic] = ()
    """Why it was not."""


def _analyze_one(job: _Job) -> _Told:
    """Analyse one log and write its report; what there is to print is given back."""
    from gyrodata.analysis import analyze_readings

    name, folder, request = job.name, job.folder, job.request
    readings: Readings | None = None
    try:
        readings = request.read(**source_of(job.log, name))
        analysis = analyze_readings(readings, request.options)
        files = _files(analysis, request) if job.written else {}
        text = _formatted(analysis, request, job.below if job.count > 1 else None, job.written)
    except GyroError as error:
        return _without_answer(name, readings, request, error.exit_code, error.diagnostics)
    except Exception as error:
        return _without_answer(name, readings, request, FAULT, (fault(error, name),))
    if not job.written:
        return _Told(0, text, analysis.diagnostics)
    try:
        with telling(folder, REPORT_CANNOT_BE_WRITTEN):
            write_folder(folder, files)
    except GyroError as error:
        return _Told(error.exit_code, text, analysis.diagnostics, not_written=error.diagnostics)
    return _Told(0, text, analysis.diagnostics, report=str(folder / DOCUMENTS.get(request.form, "report.html")))


def _without_answer(
    name: str, readings: Readings | None, request: _Request, code: int, diagnostics: Sequence[Diagnostic]
) -> _Told:
    """Tell why a log has no answer; a pipe gets an object or a row for it all the same."""
    if request.form == "csv" and request.table == "logs":
        from gyrodata.reporting.data import unanswered_row

        return _Told(code, unanswered_row(name, diagnostics), diagnostics)
    if request.form not in ("json", "ndjson"):
        return _Told(code, "", diagnostics)
    from gyrodata.reporting.data import json_text
    from gyrodata.results import AnalysisDocument, Input, to_json

    digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
    log, found = Input(name, digest, rows), tuple(one.to_dict() for one in diagnostics)
    made = to_json(AnalysisDocument(input=log, options=request.options, result=None, diagnostics=found))
    return _Told(code, json_text(made, indent=2 if request.form == "json" else None), diagnostics)


def _formatted(analysis: Analysis, request: _Request, below: Path | None, written: bool) -> str:
    """Write a log in the form that is asked for.

    `below`: the folder of its report if there are several logs; `written`: whether it has a report.
    """
    from gyrodata.reporting.data import json_text, table_rows

    form = request.form
    after = "" if below is None else "\n"
    if form == "csv":
        return table_rows(analysis, request.table)
    if form in ("json", "ndjson"):
        return json_text(analysis.to_dict(), indent=2 if form == "json" else None)
    if form == "text":
        from gyrodata.reporting.text import summary

        log = analysis.name if re.fullmatch(r"[\w./-]+", analysis.name) else "LOG"
        rest = f"More: gyro analyze {log} -v" + (", or open the HTML report" if written else "")
        return summary(analysis, request.verbose, rest) + after
    if form == "markdown":
        from urllib.parse import quote

        from gyrodata.reporting.files import alternatives, shown_form
        from gyrodata.reporting.markdown import markdown_report

        # The document of one log is in the folder of its figures, that of several logs is next to their folders.
        place = "" if below is None else quote(os.fsencode(f"{below.as_posix()}/"))
        figures = f"{place}{{}}.{shown_form(request.figures)}"
        return markdown_report(analysis, figures, alternatives(analysis)) + after
    from gyrodata.reporting.latex import latex_report

    return latex_report(analysis)


def _files(analysis: Analysis, request: _Request) -> dict[str, bytes]:
    from gyrodata.reporting.files import report_files

    return report_files(analysis, request.figures, request.style, DOCUMENTS.get(request.form, ""))


def _stem(name: str) -> str:
    for suffix in (".gz", ".csv", ".txt", ".tsv", ".xlsx"):
        if name.lower().endswith(suffix) and len(name) > len(suffix):
            name = name[: -len(suffix)]
    return name
