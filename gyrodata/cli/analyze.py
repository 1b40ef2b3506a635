"""``gyro analyze``: from logs to answers, figures and reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import G602, ConfigOption, MappingOption, SettingsOption, pairs
from gyrodata.cli.parallel import in_order
from gyrodata.cli.terminal import FAULT, complain, fault, name_of, refuse, source_of, write_folder, write_out
from gyrodata.errors import Diagnostic, GyroError, register

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, Options

G604 = register("G604", "error", "values are not words in this form", "analyze log.csv --format csv --values short")
G605 = register("G605", "error", "what cannot be watched", "analyze a.csv b.csv --watch")


class Format(StrEnum):
    """What is written to standard output."""

    text = "text"
    json = "json"
    ndjson = "ndjson"
    csv = "csv"
    markdown = "markdown"
    latex = "latex"


class Values(StrEnum):
    """How a value stands with its uncertainty."""

    plain = "plain"
    short = "short"


class Figures(StrEnum):
    """File type of the figures."""

    png = "png"
    svg = "svg"
    pdf = "pdf"


class Style(StrEnum):
    """What the figures are made for."""

    screen = "screen"
    slides = "slides"
    print = "print"


class ModelChoice(StrEnum):
    """Which equation of motion the fit uses."""

    auto = "auto"
    horizontal = "horizontal"
    steady = "steady"
    released = "released"


@dataclass(frozen=True)
class _Request:
    """What one call of ``gyro analyze`` asks for."""

    settings: dict[str, str]
    mapping: dict[str, str]
    config: Path | None
    model: ModelChoice
    keep_flagged: bool
    scale_by_birge: bool
    form: Format
    values: Values
    out: Path | None
    report: bool
    figures: Figures
    style: Style
    quiet: bool

    def told(self) -> Options:
        """What the output says was asked for: no paths."""
        from gyrodata.results import Options

        return Options(
            set=dict(sorted(self.settings.items())),
            map=dict(sorted(self.mapping.items())),
            config=self.config.name if self.config else None,
            model=self.model.value,
            keep_flagged=self.keep_flagged,
            scale_by_birge=self.scale_by_birge,
        )


def analyze(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="CSV logs; - is standard input.")],
    form: Annotated[Format, typer.Option("--format", "-f", help="What to write to standard output.")] = Format.text,
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    values: Annotated[
        Values, typer.Option("--values", help="plain: 4.44 ± 0.06; short: 4.44(6). In text, Markdown and LaTeX.")
    ] = Values.plain,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder for the report (several logs: one folder each inside). "
                     "Default: STEM-report, for --format text and files only."),
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    figures: Annotated[Figures, typer.Option("--figures", help="File type of the figures.")] = Figures.png,
    style: Annotated[
        Style, typer.Option("--style", help="Figures for the screen, for slides (1920 x 1080, large letters), or for "
                     "print (300 dots to the inch, shades that differ in black and white too).")
    ] = Style.screen,
    model: Annotated[
        ModelChoice, typer.Option("--model", help="horizontal: eq. (9); steady: eq. (8); released: let go from rest; "
                     "auto: what the log needs.")
    ] = ModelChoice.auto,
    keep_flagged: Annotated[bool, typer.Option("--keep-flagged", help="Keep runs that look odd in the fit.")] = False,
    scale_by_birge: Annotated[
        bool, typer.Option("--scale-by-birge", help="Multiply u by the Birge ratio where that is above 1.")
    ] = False,
    watched: Annotated[
        bool,
        typer.Option("--watch", help="During the lab: say what is missing and which run to repeat, whenever the file "
                     "is saved, until Ctrl-C. Writes no report."),
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on standard error.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when a log has errors.")] = False,
) -> None:  # fmt: skip
    """Fit the moment of inertia I_zz to a log, and write figures and a report.

    Exit codes: 0 done; 1 done, but a log has errors; 2 usage, or a log that cannot be read; 3 a fault
    of gyro itself, which costs that log only.
    """
    request = _Request(
        settings=pairs(settings, "--set"),
        mapping=pairs(mapping, "--map"),
        config=config,
        model=model,
        keep_flagged=keep_flagged,
        scale_by_birge=scale_by_birge,
        form=form,
        values=values,
        out=out,
        report=not no_report,
        figures=figures,
        style=style,
        quiet=quiet,
    )
    _refuse_what_does_not_go_together(logs, request, watched)
    if watched:
        _watch(Path(logs[0]), request)
        return
    jobs = [_Job(log, folder, request, len(logs)) for log, folder in zip(logs, _folders(logs, request), strict=True)]
    worst, header = 0, _header(form)
    # Standard input can be read in this process only.
    for told in map(_analyze_one, jobs) if "-" in logs else in_order(_analyze_one, jobs):
        complain(told.diagnostics, quiet)
        if told.text:
            write_out(header + told.text)
            header = ""
        complain(told.not_written)
        if told.report and not quiet:
            typer.echo(f"report: {told.report}", err=True)
        worst = max(worst, told.code)
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _refuse_what_does_not_go_together(logs: Sequence[str], request: _Request, watched: bool) -> None:
    form, several = request.form, len(logs) > 1
    if form is Format.json and several:
        refuse(G602, "--format json is for one log", "use --format ndjson for several: one object a line")
    if form is Format.latex and several:
        refuse(
            G602, "--format latex is for one log: a document that compiles", "give one log, or use --format markdown"
        )
    if request.values is Values.short and form in (Format.json, Format.ndjson, Format.csv):
        refuse(G604, f"--values short is not for --format {form}, where value and u are numbers of their own",
               "leave it out, or use --format text, markdown or latex")  # fmt: skip
    if watched and (several or logs[0] == "-" or form is not Format.text or request.out):
        refuse(G605, "--watch is for one file, and prints text only", "for example: gyro analyze log.csv --watch")


def _watch(path: Path, request: _Request) -> None:
    from gyrodata.analysis import analyze_readings
    from gyrodata.cli.watch import watch
    from gyrodata.readings import read_log

    def read(data: bytes | Path) -> Readings:
        return read_log(data, name=path.name, settings=request.settings, mapping=request.mapping, config=request.config)

    def analyse(readings: Readings) -> Analysis:
        return analyze_readings(readings, request.told())

    if not path.is_file():
        read(path)
    watch(path, read, analyse, request.values.value)


def _header(form: Format) -> str:
    """What stands once above the rows of all logs."""
    if form is not Format.csv:
        return ""
    from gyrodata.reporting import runs_header

    return runs_header()


def _folders(logs: Sequence[str], request: _Request) -> list[Path | None]:
    """Give each log the folder of its report, None for no report; logs of one name get numbers."""
    folders: list[Path | None] = []
    taken: dict[str, int] = {}
    for log in logs:
        if not request.report or (request.out is None and (log == "-" or request.form is not Format.text)):
            folders.append(None)
            continue
        if request.out is not None and len(logs) == 1:
            folders.append(request.out)
            continue
        stem = "stdin" if log == "-" else _stem(log)
        taken[stem] = taken.get(stem, 0) + 1
        name = f"{stem}-report" if taken[stem] == 1 else f"{stem}-report-{taken[stem]}"
        folders.append((request.out or Path()) / name)
    return folders


@dataclass(frozen=True)
class _Job:
    """One log to analyse."""

    log: str
    folder: Path | None
    """Where its report goes; None: nowhere."""
    request: _Request
    count: int
    """How many logs there are."""


@dataclass(frozen=True)
class _Told:
    """What is said of one log."""

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
    from gyrodata.readings import read_log

    log, folder, request = job.log, job.folder, job.request
    readings: Readings | None = None
    try:
        readings = read_log(**source_of(log), settings=request.settings, mapping=request.mapping, config=request.config)
        analysis = analyze_readings(readings, request.told())
        files = _report_files(analysis, request) if folder else {}
        text = _formatted(analysis, request, job.count)
    except GyroError as error:
        return _without_answer(log, readings, request, error.exit_code, error.diagnostics)
    except Exception as error:
        return _without_answer(log, readings, request, FAULT, (fault(error, name_of(log)),))
    if folder is None:
        return _Told(0, text, analysis.diagnostics)
    try:
        write_folder(folder, files)
    except GyroError as error:
        return _Told(error.exit_code, text, analysis.diagnostics, not_written=error.diagnostics)
    return _Told(0, text, analysis.diagnostics, report=str(folder / "report.html"))


def _without_answer(
    log: str, readings: Readings | None, request: _Request, code: int, diagnostics: Sequence[Diagnostic]
) -> _Told:
    """Tell why a log has no answer; a pipe gets an object for it all the same."""
    if request.form not in (Format.json, Format.ndjson):
        return _Told(code, "", diagnostics)
    from gyrodata.reporting import json_text
    from gyrodata.results import document

    digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
    made = document(name_of(log), digest, rows, request.told(), None, tuple(diagnostics))
    return _Told(code, json_text(made, indent=2 if request.form is Format.json else None), diagnostics)


def _formatted(analysis: Analysis, request: _Request, count: int) -> str:
    from gyrodata import reporting

    form = request.form
    writing: Literal["plain", "short"] = request.values.value
    after = "\n" if count > 1 else ""
    if form is Format.text:
        return reporting.summary(analysis, writing) + after
    if form is Format.markdown:
        return reporting.markdown_report(analysis, writing) + after
    if form is Format.latex:
        return reporting.latex_report(analysis, writing)
    if form is Format.csv:
        return reporting.runs_rows(analysis)
    return reporting.json_text(analysis.to_dict(), indent=2 if form is Format.json else None)


def _report_files(analysis: Analysis, request: _Request) -> dict[str, bytes]:
    """Make every file of the report in memory, so that a fault half-way leaves nothing behind."""
    from gyrodata import plotting, reporting

    form: Literal["png", "svg", "pdf"] = request.figures.value
    medium = plotting.MEDIA[request.style.value]
    figures = plotting.render(analysis, form, medium)
    # A browser shows no PDF inside a page.
    shown: Literal["png", "svg"] = "png" if form == "png" else "svg"
    embedded = figures if form == shown else plotting.render(analysis, shown, medium)
    alternatives = {name: plotting.alt_text(analysis, name) for name in figures}
    looks = plotting.list_looks(analysis, medium.grey_safe)
    page = reporting.report_page(analysis, embedded, shown, alternatives, looks)
    contents = {f"{name}.{form}": data for name, data in figures.items()}
    contents["report.html"] = page.encode()
    contents["results.json"] = reporting.json_text(analysis.to_dict()).encode()
    contents["runs.csv"] = reporting.runs_csv(analysis).encode()
    return contents


def _stem(log: str) -> str:
    name = Path(log).name
    for suffix in (".gz", ".csv", ".txt", ".tsv", ".xlsx"):
        if name.lower().endswith(suffix) and len(name) > len(suffix):
            name = name[: -len(suffix)]
    return name
