"""The commands: the only place that prints, writes and exits. Heavy modules are imported inside them."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

import typer

from gyrodata import __version__
from gyrodata.errors import Diagnostic, GyroError, InputError, register

if TYPE_CHECKING:
    from gyrodata.analysis import Analysis
    from gyrodata.readings import Readings

G601 = register("G601", "error", "an option is not of the form KEY=VALUE", "analyze log.csv --set turns")
G602 = register("G602", "error", "one JSON object cannot hold several logs", "analyze a.csv b.csv --format json")
G603 = register("G603", "error", "the report cannot be written", "analyze log.csv --out /dev/null")

app = typer.Typer(
    name="gyro",
    help="From a gyroscope lab's log to its moment of inertia, with an uncertainty that can be trusted.",
    no_args_is_help=True,
    add_completion=True,
    # Plain help costs half the start-up time of a coloured one.
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class Format(StrEnum):
    """What is written to standard output."""

    text = "text"
    json = "json"
    ndjson = "ndjson"
    csv = "csv"


class Figures(StrEnum):
    """File type of the figures."""

    png = "png"
    svg = "svg"
    pdf = "pdf"


class ModelChoice(StrEnum):
    """Which equation of motion the fit uses."""

    auto = "auto"
    horizontal = "horizontal"
    steady = "steady"


SettingsOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A constant: --set g="9.803 m/s^2".')
]
MappingOption = Annotated[
    list[str] | None, typer.Option("--map", metavar="ROLE=HEADER", help='Name a column: --map time="T (s)".')
]
ConfigOption = Annotated[Path | None, typer.Option("--config", help="TOML file with constants.")]


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
    out: Path | None
    report: bool
    figures: Figures
    quiet: bool

    def told(self) -> dict[str, Any]:
        """What the output says was asked for: no paths."""
        return {
            "set": dict(sorted(self.settings.items())),
            "map": dict(sorted(self.mapping.items())),
            "config": self.config.name if self.config else None,
            "model": self.model.value,
            "keep_flagged": self.keep_flagged,
            "scale_by_birge": self.scale_by_birge,
        }


@app.callback(invoke_without_command=True)
def _gyro(
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version and exit.")] = False,
) -> None:
    if version:
        _print(f"gyro {__version__}\n")
        raise typer.Exit


@app.command(
    epilog="Example:  gyro analyze sample_data/air_gyroscope.csv --no-report",
)
def analyze(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="CSV logs; - is standard input.")],
    form: Annotated[Format, typer.Option("--format", "-f", help="What to write to standard output.")] = Format.text,
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Folder for the report (several logs: one folder each inside). "
                     "Default: STEM-report, for --format text and files only."),
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    figures: Annotated[Figures, typer.Option("--figures", help="File type of the figures.")] = Figures.png,
    model: Annotated[
        ModelChoice, typer.Option("--model", help="horizontal: eq. (9); steady: eq. (8); auto: what the log needs.")
    ] = ModelChoice.auto,
    keep_flagged: Annotated[bool, typer.Option("--keep-flagged", help="Keep runs that look odd in the fit.")] = False,
    scale_by_birge: Annotated[
        bool, typer.Option("--scale-by-birge", help="Multiply u by the Birge ratio where that is above 1.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on standard error.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when a log has errors.")] = False,
) -> None:  # fmt: skip
    """Fit the moment of inertia I_zz to a log, and write figures and a report.

    Exit codes: 0 done; 1 done, but a log has errors; 2 usage, or a log that cannot be read.
    """
    try:
        request = _Request(
            settings=_pairs(settings, "--set"),
            mapping=_pairs(mapping, "--map"),
            config=config,
            model=model,
            keep_flagged=keep_flagged,
            scale_by_birge=scale_by_birge,
            form=form,
            out=out,
            report=not no_report,
            figures=figures,
            quiet=quiet,
        )
        if form is Format.json and len(logs) > 1:
            _refuse(G602, "--format json is for one log", "use --format ndjson for several: one object a line")
    except GyroError as error:
        _complain(error.diagnostics)
        raise typer.Exit(error.exit_code) from None
    codes = [
        _analyze_one(log, folder, request, len(logs)) for log, folder in zip(logs, _folders(logs, request), strict=True)
    ]
    worst = max(codes)
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _pairs(given: list[str] | None, option: str) -> dict[str, str]:
    """Split KEY=VALUE options; the last of one key wins."""
    pairs: dict[str, str] = {}
    for item in given or []:
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            example = "turns=1/3" if option == "--set" else 'time="T (s)"'
            _refuse(G601, f"{option} {item!r} is not of the form KEY=VALUE", f"for example {option} {example}")
        pairs[key.strip()] = value.strip()
    return pairs


def _refuse(code: str, message: str, hint: str) -> NoReturn:
    raise InputError([Diagnostic(code, "error", message, hint)])


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


def _analyze_one(log: str, folder: Path | None, request: _Request, count: int) -> int:
    """Analyse one log, print and write what was asked for, and give the exit code."""
    from gyrodata.analysis import analyze_readings, envelope
    from gyrodata.readings import read_log

    readings: Readings | None = None
    try:
        readings = read_log(**_source(log), settings=request.settings, mapping=request.mapping, config=request.config)
        analysis = analyze_readings(
            readings, request.told(), request.model.value, request.keep_flagged, request.scale_by_birge
        )
        files = _report_files(analysis, request) if folder else {}
    except GyroError as error:
        _complain(error.diagnostics, request.quiet)
        if request.form in (Format.json, Format.ndjson):
            from gyrodata.reporting import json_text

            name = readings.name if readings else "<stdin>" if log == "-" else Path(log).name
            digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
            document = envelope(name, digest, rows, request.told(), None, error.diagnostics)
            _print(json_text(document, indent=2 if request.form is Format.json else None))
        return error.exit_code
    _complain(analysis.diagnostics, request.quiet)
    _print(_formatted(analysis, request.form, count))
    try:
        if folder:
            _write_folder(folder, files)
            if not request.quiet:
                typer.echo(f"report: {folder / 'report.html'}", err=True)
    except GyroError as error:
        _complain(error.diagnostics)
        return error.exit_code
    return 0


def _source(log: str) -> dict[str, Any]:
    """Where a log is read from, and what it is called."""
    return {"source": sys.stdin.buffer, "name": "<stdin>"} if log == "-" else {"source": log}


def _formatted(analysis: Analysis, form: Format, count: int) -> str:
    from gyrodata import reporting

    if form is Format.text:
        return reporting.summary(analysis) + ("\n" if count > 1 else "")
    if form is Format.csv:
        return reporting.runs_csv(analysis)
    return reporting.json_text(analysis.to_dict(), indent=2 if form is Format.json else None)


# --- check, template, schema --------------------------------------------------------------------------------


class CheckFormat(StrEnum):
    """How `gyro check` tells what it finds."""

    text = "text"
    json = "json"
    ndjson = "ndjson"
    github = "github"


@app.command(epilog="Example:  gyro check sample_data/air_gyroscope.csv")
def check(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="CSV logs; - is standard input.")],
    form: Annotated[
        CheckFormat, typer.Option("--format", "-f", help="github: annotations of a workflow run.")
    ] = CheckFormat.text,
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when something is found.")] = False,
) -> None:
    """Say what is wrong with a log, and what it still lacks, before the weight comes off.

    Exit codes: 0 clean; 1 something was found; 2 usage, or a log that cannot be read.
    """
    try:
        given = _pairs(settings, "--set"), _pairs(mapping, "--map")
        if form is CheckFormat.json and len(logs) > 1:
            _refuse(G602, "--format json is for one log", "use --format ndjson for several: one object a line")
    except GyroError as error:
        _complain(error.diagnostics)
        raise typer.Exit(error.exit_code) from None
    worst = max(_check_one(log, given[0], given[1], config, form) for log in logs)
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _check_one(
    log: str, settings: dict[str, str], mapping: dict[str, str], config: Path | None, form: CheckFormat
) -> int:
    """Check one log, print what was found, and give the exit code."""
    from gyrodata import reporting
    from gyrodata.readings import read_log

    readings: Readings | None = None
    try:
        readings = read_log(**_source(log), settings=settings, mapping=mapping, config=config)
        found = readings.diagnostics
        if not any(diagnostic.severity == "error" for diagnostic in found):
            from gyrodata.procedure import check_procedure

            found = (*found, *check_procedure(readings))
        code = 1 if any(diagnostic.severity != "note" for diagnostic in found) else 0
    except GyroError as error:
        found, code = error.diagnostics, error.exit_code
    found = tuple(sorted(found, key=lambda diagnostic: (diagnostic.line or 0, diagnostic.column or 0)))
    name = readings.name if readings else "<stdin>" if log == "-" else Path(log).name
    if form is CheckFormat.text:
        _print(reporting.check_text(name, len(readings.runs) if readings else None, found))
    elif form is CheckFormat.github:
        _print(reporting.github_annotations(name if log == "-" else log, found))
    else:
        digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
        document = reporting.check_document(name, digest, rows, code == 0, found)
        _print(reporting.json_text(document, indent=2 if form is CheckFormat.json else None))
    return code


class PlainFormat(StrEnum):
    """Text for people or JSON for programs."""

    text = "text"
    json = "json"


@app.command(epilog="Example:  gyro selfcheck sample_data/air_gyroscope.csv --labs 1000")
def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="CSV log; - is standard input.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="How many labs to simulate.")] = 4000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the random numbers.")] = 1,
    form: Annotated[PlainFormat, typer.Option("--format", "-f", help="What to write.")] = PlainFormat.text,
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    """Simulate this very lab many times, and count how often the quoted intervals hold the truth.

    The lab's design, its fitted values as the truth and its stated uncertainties make new readings; the
    recommended fit and those of the textbook are applied to each.
    """
    import time

    from gyrodata import reporting
    from gyrodata.analysis import analyze_readings
    from gyrodata.measurements import select
    from gyrodata.readings import read_log
    from gyrodata.selfcheck import selfcheck as simulate

    try:
        given = _pairs(settings, "--set"), _pairs(mapping, "--map")
        readings = read_log(**_source(log), settings=given[0], mapping=given[1], config=config)
        analysis = analyze_readings(readings, {})
    except GyroError as error:
        _complain(error.diagnostics)
        raise typer.Exit(error.exit_code) from None
    tilted = any(effect.effect == "tilt" and effect.kept for effect in analysis.effects)
    kept = [i for i, run in enumerate(analysis.run_table) if not run.left_out]
    measured = select(analysis.measurements, kept)
    done = simulate(measured, time.perf_counter, labs, seed=seed, tilted=tilted, progress=_progress(labs))
    _print(reporting.json_text(done.to_dict()) if form is PlainFormat.json else done.to_text() + "\n")


def _progress(whole: int) -> Callable[[int], None] | None:
    """Show how far a long computation is, on a terminal only."""
    if not sys.stderr.isatty():
        return None

    def show(done: int) -> None:
        typer.echo(f"\r{done} of {whole}" if done < whole else "\r\033[K", err=True, nl=False)

    return show


@app.command(epilog="Example:  gyro template --weights 20g,40g,60g --position 15cm --spins 200,400,600rpm > log.csv")
def template(
    weights: Annotated[str, typer.Option("--weights", help="Masses of the weights.")] = "20g,40g,60g",
    position: Annotated[str, typer.Option("--position", help="Where the weights sit on the rod.")] = "15cm",
    spins: Annotated[str, typer.Option("--spins", help="Spins to aim at.")] = "200,400,600rpm",
) -> None:
    """Print a blank log to fill in: every weight with every spin, and one run without a weight."""
    from gyrodata.readings import blank_log

    try:
        _print(blank_log(_with_units(weights), position, _with_units(spins)))
    except GyroError as error:
        _complain(error.diagnostics)
        raise typer.Exit(error.exit_code) from None


def _with_units(items: str) -> list[str]:
    """Split "200,400,600rpm" at the commas; an item without a unit has the unit of the next that has one."""
    unit, complete = "", []
    for item in reversed([item.strip() for item in items.split(",") if item.strip()]):
        number = item.rstrip("".join(sorted({c for c in item if not c.isdigit() and c != "."})))
        unit = item[len(number) :].strip() or unit
        complete.append(f"{number} {unit}".strip())
    return complete[::-1]


@app.command(epilog="Example:  gyro schema --diagnostics")
def schema(
    diagnostics: Annotated[
        bool, typer.Option("--diagnostics", help="The table of diagnostic codes, each with an example.")
    ] = False,
    checks: Annotated[bool, typer.Option("--check", help="The schema of gyro check --format json.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The table of diagnostics as JSON.")] = False,
) -> None:
    """Print the JSON Schema of the outputs, or the table of diagnostics."""
    # Codes are registered where they are raised.
    from gyrodata import procedure, reporting
    from gyrodata import schema as schemas

    del procedure
    if diagnostics and as_json:
        _print(reporting.json_text({"diagnostics": schemas.diagnostics_table()}))
    elif diagnostics:
        _print(reporting.diagnostics_text(schemas.diagnostics_table()))
    else:
        _print(reporting.json_text(schemas.check_schema() if checks else schemas.analysis_schema()))


# --- the report folder --------------------------------------------------------------------------------------


def _report_files(analysis: Analysis, request: _Request) -> dict[str, bytes]:
    """Make every file of the report in memory, so that a fault half-way leaves nothing behind."""
    from gyrodata import plotting, reporting

    form: Literal["png", "svg", "pdf"] = request.figures.value
    figures = plotting.render(analysis, form)
    # A browser shows no PDF inside a page.
    shown: Literal["png", "svg"] = "png" if form == "png" else "svg"
    embedded = figures if form == shown else plotting.render(analysis, shown)
    alternatives = {name: plotting.alt_text(analysis, name) for name in figures}
    page = reporting.report_page(analysis, embedded, shown, alternatives)
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


def _write_folder(folder: Path, contents: dict[str, bytes]) -> None:
    """Write files into a folder, each one whole or not at all."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in contents.items():
            unfinished = folder / f".{name}.part"
            unfinished.write_bytes(data)
            unfinished.replace(folder / name)
    except OSError as error:
        reason = error.strerror or str(error)
        _refuse(G603, f"the report cannot be written to {folder}: {reason}", "choose another folder with --out")


# --- standard output and error ------------------------------------------------------------------------------


def _print(text: str) -> None:
    """Write data to standard output; a reader that has gone away (``| head``) is no fault."""
    # A test's or a notebook's stand-in has no encoding to fail on.
    with suppress(AttributeError):
        sys.stdout.reconfigure(errors="replace")  # type: ignore[union-attr]
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes standard output once more at exit: let that go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None


def _complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error, those that stop the analysis last, where they are seen."""
    order = {"note": 0, "warning": 1, "error": 2}
    shown: Sequence[Diagnostic] = sorted(
        (d for d in diagnostics if not quiet or d.severity == "error"),
        key=lambda d: (order[d.severity], d.line or 0, d.column or 0),
    )
    for diagnostic in shown:
        typer.echo(str(diagnostic), err=True)
