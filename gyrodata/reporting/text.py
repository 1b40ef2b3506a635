"""Printed texts about an analysis and a check: the summary, and the findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import compress
from textwrap import indent

from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import PICTURES, Diagnostic
from gyrodata.reporting import values
from gyrodata.reporting.content import brief, report
from gyrodata.reporting.elements import (
    NOTHING,
    Block,
    Report,
    Table,
    Text,
    plain,
)
from gyrodata.results import NO_BALL, Analysis, is_wide

Columns = Callable[[Sequence[Sequence[str]]], Iterable[str]]
"""What writes rows of cells, the first of heads, as lines."""

MORE = "More: gyro analyze LOG -v, or open the HTML report"


def summary(
    analysis: Analysis,
    verbose: bool = True,
    rest: str = MORE,
    columns: Columns = values.in_columns,
) -> str:
    """Write the answer and what a screen has room for, or the full report.

    Parameters
    ----------
    analysis : Analysis
    verbose : bool
        True for the full report: everything up to the diagnostics, which are printed
        elsewhere, but no figures.
    rest : str
        Last line of the short form, which says where the rest is.
    columns : callable
        Sets the cells of tables under each other.

    Returns
    -------
    str
    """
    whole = report(analysis)
    meaning = "" if is_wide(analysis.inertia) else "   (± u, one standard uncertainty)"
    doubts = map(plain, whole.doubts)
    top = [*doubts, f"{plain(whole.answer)}{meaning}"]
    if not verbose:
        lines = [*top, *map(plain, brief(whole.numbers)), rest]
        return _joined([_first_lines(whole), _indented(lines)])
    top += _lines_of(whole.top, columns)
    blocks = [_first_lines(whole), _indented(top)]
    for section in whole.sections:
        if section.anchor == "diagnostics":
            break
        if section.blocks:
            below = _indented(_lines_of(section.blocks, columns))
            blocks.append([section.title, *below])
    return _joined(blocks)


def _lines_of(blocks: Iterable[Block], columns: Columns) -> Iterator[str]:
    """Write blocks as lines; without the figures."""
    for block in blocks:
        # The terminal prints the warnings below the report, with their remedies.
        if isinstance(block, Text) and block.kind != "warning":
            yield from map(plain, block.sentences)
        elif isinstance(block, Table):
            yield from _table(block, columns)


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def answer_line(analysis: Analysis) -> str:
    """Write the answer in one line, with a word of warning if it is doubted."""
    whole = report(analysis)
    words = "; do not rely on it" if whole.doubts else ""
    return f"{plain(whole.answer)}{words}"


def _joined(blocks: Iterable[Iterable[str]]) -> str:
    paragraphs = map("\n".join, blocks)
    return "\n\n".join(paragraphs).translate(PICTURES) + "\n"


def _first_lines(whole: Report) -> list[str]:
    name = whole.numbers.analysis.name
    size = f"{name}: {plain(whole.size)}"
    return [size, f"  {plain(whole.read_as)}"]


def _table(table: Table, columns: Columns) -> Iterable[str]:
    """Write a table, without the columns that only the page has room for."""
    is_used = [not head.page_only for head in table.heads]
    lines = [[*map(str, compress(table.heads, is_used))]]
    for row in table.rows:
        cells = compress(row, is_used)
        lines.append(["-" if cell == NOTHING else plain(cell) for cell in cells])
    return columns(lines)


# --- what a check has found, and the table of codes ---


def check_text(
    name: str,
    runs: int | None,
    diagnostics: Sequence[Diagnostic],
    well: str = "complete",
    analysis: Analysis | None = None,
) -> str:
    """Write what ``gyro check`` found.

    Parameters
    ----------
    name : str
        Of the log.
    runs : int, optional
        Number of runs, if the log was read.
    diagnostics : sequence of Diagnostic
    well : str
        The verdict if nothing was found.
    analysis : Analysis, optional
        Its reading of a run and its doubts come first.

    Returns
    -------
    str
        The last line is the verdict.
    """
    counts: Counter[str] = Counter(finding.severity for finding in diagnostics)
    lines = []
    if analysis is not None:
        lines = _lines_above(analysis)
        counts["doubt"] = len(analysis.doubts)
    kinds = [kind for kind in ("doubt", "error", "warning", "note") if counts[kind]]
    verdict = ", ".join([values.count_text(counts[kind], kind) for kind in kinds])
    if counts["note"] == counts.total():
        verdict = f"{well} ({verdict})" if verdict else well
    read = ""
    if runs is not None:
        read = f"{values.count_text(runs, 'run')}, "
    printed = [f"{name}: {line}" for line in lines]
    printed += map(str, diagnostics)
    printed.append(f"{name}: {read}{verdict}\n")
    return "\n".join(printed).translate(PICTURES)


def _lines_above(analysis: Analysis) -> list[str]:
    """List what is above the findings: how a run was read, and the doubts."""
    whole = report(analysis)
    lines = [plain(whole.read_as)]
    if analysis.ball is None:
        lines.append(NO_BALL)
    return [*lines, *map(plain, whole.doubts)]


def diagnostics_text() -> str:
    """Write the table of diagnostic codes, each with an example that raises it."""
    blocks = []
    for code, entry in explanations().items():
        head = f"{code}  {entry.severity:7}  {entry.title}"
        # A tab in an example stays a tab.
        example = entry.example.rstrip("\n").translate({**PICTURES, 9: "\t"})
        blocks.append(f"{head}\n{indent(example, '      ')}\n")
    return "\n".join(blocks)
