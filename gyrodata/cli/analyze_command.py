"""``gyro analyze``: from logs to answers, figures and reports."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base.disk import telling, write_folder, write_whole
from gyrodata.base.errors import Diagnostic, count_text
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    Reader,
    SettingsOption,
    input_of,
    stem_of,
)
from gyrodata.cli.terminal import (
    answer_text,
    columns,
    complain,
    explained,
    finish,
    in_parts,
    named_logs,
    refuse,
    tell,
    write_out,
    write_text,
)
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.cli.terminal import Log
    from gyrodata.readings import Readings
    from gyrodata.reporting.page import Form
    from gyrodata.results import Analysis, Options

DATA = {"json": (".json",), "ndjson": (".ndjson", ".jsonl", ".json"), "csv": (".csv",)}
"""Endings of a file with data, by their format."""

DOCUMENTS = {"markdown": "report.md", "latex": "report.tex"}
"""Name of the document next to its figures, by its format."""

REPORT = ("report.html", "results.json", "runs.csv", *DOCUMENTS.values())
"""Files of a report, which could be logs; the page shows that a folder is a report."""

PAUSE = 0.5
"""Time between two looks at a watched file [s]."""

OpenOption = Annotated[
    bool, typer.Option("--open", help="Open the report in the browser.")
]


def analyze(
    *,
    logs: Annotated[
        list[str],
        typer.Argument(metavar="LOG", help="Logs: CSV, text or workbook; - is stdin."),
    ],
    form: Annotated[
        Literal["text", "json", "ndjson", "csv", "markdown", "latex"],
        typer.Option("--format", "-f", help="What to write to standard output."),
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
        Literal["runs", "logs"],
        typer.Option(
            "--table", help="For --format csv: one row for each run, or for each log."
        ),
    ] = "runs",
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Write no report.")
    ] = False,
    figures: Annotated[
        Literal["png", "svg", "pdf"],
        typer.Option("--figures", help="File type of the figures."),
    ] = "svg",
    style: Annotated[
        Literal["screen", "print"],
        typer.Option(
            "--style",
            help="Figures for the screen or for one column of a printed page (300 dots"
            " per inch).",
        ),
    ] = "screen",
    model: Annotated[
        Literal[
            "auto",
            "horizontal",
            "steady",
            "released",
        ],
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
    parts = in_parts(logs, together, form)
    file, out = _file_and_folder(form, out)
    has_folder = out is not None or (form == "text" and "-" not in logs)
    has_report = has_folder and not no_report
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
    output.refuse_contradictions()
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
        if form != "text" or out:
            refuse("watch_one_file")
        _watch(logs, replace(reader, quiet=True), options)
        return
    if form == "csv":
        from gyrodata.reporting.data import table_header

        output.show(table_header(table))
    worst = 0
    for part, folder in zip(parts, output.folders(parts), strict=True):
        worst = max(worst, _analyze_part(part, reader, options, output, folder))
    output.finish()
    finish(worst, exit_zero)


def _file_and_folder(form: str, out: Path | None) -> tuple[Path | None, Path | None]:
    """Return the file for data, and the folder for the report, that --out names."""
    is_standard_output = out == Path("-")
    if is_standard_output and form == "text":
        refuse("out_is_standard_output")
    if out is None or is_standard_output:
        return None, None
    ending = out.suffix.lower()
    if ending in DATA.get(form, ()):
        return out, None
    # A name with letters at its end is meant as a file, such as report.pdf.
    if ending[1:].isalpha() and not out.is_dir():
        data = form if form in DATA else "json"
        folder = out.with_suffix("")
        refuse("out_is_a_file", out=out, folder=folder, form=data)
    return None, out


def _analyze_part(
    logs: Sequence[Log],
    reader: Reader,
    options: Options,
    output: _Output,
    folder: Path | None,
) -> int:
    """Analyse one log, or several together, and return the exit code.

    Parameters
    ----------
    logs : sequence of Log
    reader : Reader
    options : Options
    output : _Output
        Where the answer goes.
    folder : Path or None
        The folder of the report, if there is one.
    """
    from gyrodata.analysis import analyze_readings

    constants = reader.constants_of(logs[0].path)
    options = replace(options, config=constants and constants.name)
    name = " + ".join(log.name for log in logs)
    output.refuse_to_replace_data(logs, folder)
    readings = None
    try:
        readings = reader.read(logs)
        analysis = analyze_readings(readings, options)
        text = output.text_of(analysis)
    except Exception as error:
        findings, code = explained(error, name)
        output.show(output.text_without(name, readings, options, findings))
        complain(findings, output.quiet)
        return code
    # The answer is on the screen while the figures are drawn.
    output.show(text)
    code = 0
    findings = analysis.diagnostics
    if folder is not None:
        try:
            faults = output.write_report(analysis, folder)
        except Exception as error:
            # The answer is right also if its report cannot be made.
            faults, code = explained(error, name)
            folder = None
        findings = (*findings, *faults)
    complain(findings, output.quiet)
    output.end(analysis, findings, folder)
    return code


class _Output(Struct):
    """How the answers are written, and where they go."""

    form: str
    table: str
    figures: Form
    style: str
    verbose: bool
    several: bool
    """True if there are several answers."""
    file: Path | None
    """Data go into a file completely, or not at all."""
    out: Path | None
    """The folder for the report, if the user names one."""
    has_report: bool
    opened: bool
    quiet: bool
    parts: list[str] = []
    """The texts so far."""

    def refuse_contradictions(self) -> None:
        """Refuse options that contradict each other."""
        if self.table != "runs" and self.form != "csv":
            refuse("table_for_csv", table=self.table)
        for option, is_used in {"--open": self.opened, "--out": self.out}.items():
            if is_used and not self.has_report:
                refuse("option_without_report", option=option)

    def folders(self, parts: Sequence[Sequence[Log]]) -> Iterator[Path | None]:
        """Yield the folder of each report; None without a report.

        Several reports are below the folders of their logs. Equal names get numbers.
        """
        used: Counter[Path] = Counter()
        for logs in parts:
            path = logs[0].short
            together = "-together" * (len(logs) > 1)
            folder = Path(f"{stem_of(path)}{together}-report")
            if self.several:
                steps = [step for step in path.parent.parts if step != ".."]
                folder = Path(self.out or "", *steps, folder)
            elif self.out is not None:
                folder = self.out
            used[folder] += 1
            if used[folder] > 1:
                folder = folder.with_name(f"{folder.name}-{used[folder]}")
            yield folder if self.has_report else None

    def refuse_to_replace_data(self, logs: Sequence[Log], folder: Path | None) -> None:
        """Refuse an output that would replace a log, or other data of the user."""
        outputs = [self.file] if self.file else []
        is_ours = True
        if folder is not None:
            outputs = [folder / name for name in REPORT]
            is_ours = folder != self.out or outputs[0].exists()
        sources = {Path(log.path).resolve() for log in logs}
        for out in outputs:
            if out.resolve() in sources or (out.exists() and not is_ours):
                refuse("file_exists", out=out)

    def text_of(self, analysis: Analysis) -> str:
        """Write an analysis in the format of the command."""
        if self.form == "csv":
            from gyrodata.reporting.data import table_rows

            return table_rows(analysis, self.table)
        if self.form == "latex":
            from gyrodata.reporting.latex import latex_report

            return latex_report(analysis)
        after = "\n" * self.several
        if self.form == "markdown":
            from gyrodata.reporting.markdown import markdown_report
            from gyrodata.reporting.page import shown_form

            figures = f"{{}}.{shown_form(self.figures)}"
            return markdown_report(analysis, figures) + after
        if self.form == "text":
            from gyrodata.reporting.text import summary

            more = "More: the same command with -v"
            more += ", or open the HTML report" * self.has_report
            return summary(analysis, self.verbose, more, columns()) + after
        return answer_text(self.form, analysis.to_dict())

    def text_without(
        self,
        name: str,
        readings: Readings | None,
        options: Options,
        findings: Sequence[Diagnostic],
    ) -> str:
        """Describe a log without an answer: an object or a row for programs."""
        from gyrodata.reporting.data import log_row
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
        return answer_text(self.form, to_json(document))

    def show(self, text: str) -> None:
        """Print a text, or keep it for the file."""
        self.parts.append(text)
        if self.form == "text":
            write_text(text)
        elif self.file is None:
            write_out(text)

    def write_report(self, analysis: Analysis, folder: Path) -> Sequence[Diagnostic]:
        """Write the report of an answer into a folder.

        Return a warning if figures cannot be drawn.
        """
        from gyrodata.reporting.page import report_files

        document = DOCUMENTS.get(self.form, "")
        faults: dict[str, str] = {}
        files = report_files(analysis, self.figures, self.style, document, faults)
        with telling(folder):
            write_folder(folder, files)
        if not faults:
            return []
        why = "; ".join(dict.fromkeys(faults.values()))
        what = listing([*faults])
        return [Diagnostic.named("figure_not_drawn", analysis.name, what=what, why=why)]

    def end(
        self, analysis: Analysis, findings: Sequence[Diagnostic], folder: Path | None
    ) -> None:
        """Print where the report is, and the answer if messages moved it off a screen."""
        if folder and self.opened:
            import webbrowser

            webbrowser.open((folder / "report.html").resolve().as_uri())
        if self.quiet:
            return
        if folder is not None:
            tell(f"report: {folder / DOCUMENTS.get(self.form, 'report.html')}")
        warnings = sum(finding.severity == "warning" for finding in findings)
        if warnings and self.form == "text" and sys.stdout.isatty():
            from gyrodata.reporting.text import answer_line

            count = count_text(warnings, "warning")
            tell(f"{count} above; {answer_line(analysis)}")

    def finish(self) -> None:
        """Write the file, if the data go into one."""
        if self.file is not None:
            with telling(self.file.parent):
                write_whole(self.file, ["".join(self.parts).encode()])


# --- --watch: the answer again whenever the log is saved ---


def _watch(logs: Sequence[str], reader: Reader, options: Options) -> None:
    """Print the state of the lab, now and whenever the log is saved, until Ctrl-C.

    On a terminal, each state replaces the last one.
    """
    from rich.console import Console

    from gyrodata.cli.check_command import check_log
    from gyrodata.reporting.text import answer_line

    log, *others = named_logs(logs)
    file = Path(log.path)
    if others or not file.is_file():
        refuse("watch_one_file")
    for is_there in states(file):
        text = f"{log.name}: cannot be read now\n"
        if is_there:
            checked = check_log(log.name, partial(reader.read, [log]), options)
            text = str(checked)
            if checked.analysis is not None:
                text += f"{answer_line(checked.analysis)}\n"
        Console().clear()
        write_text(f"watching {log.name}; Ctrl-C ends it\n{text}")


def states(file: Path) -> Iterator[bool]:
    """Yield whether a file is there, now and whenever it is saved or removed."""
    last: int | None = 0
    while True:
        saved = None
        # Some programs remove a file for a moment when they save it. To open a pipe
        # without a writer would wait for ever.
        with suppress(FileNotFoundError):
            if file.is_file():
                saved = file.stat().st_mtime_ns
        if saved != last:
            yield saved is not None
        last = saved
        time.sleep(PAUSE)
