"""What a student reports: the ``# reported_…`` lines of the log and an ``answers.toml`` beside it, as one."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gyrodata.diagnostics import (
    ANSWER_NOT_ASKED_FOR,
    ANSWERS_CANNOT_BE_READ,
    ANSWERS_CONTRADICT_LOG,
    ANSWERS_NO_TOML,
    CODES,
)
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.grading.toml_table import find_places
from gyrodata.readings import (
    REPORTED_KINDS,
    Faults,
    Readings,
    Reported,
    canonical_key,
    decode,
    read_reported,
    split_lines,
)

__all__ = ["Answers", "Reported", "read_answers"]


_FILE = "answers.toml"
_TABLES = ("reported", "answers")
_UNCERTAINTIES = ("u", "uncertainty", "error", "standard_uncertainty")
_MOST_LINES = 1000


@dataclass(frozen=True, slots=True)
class Answers:
    """What a student reports, from wherever it stands.

    Attributes
    ----------
    inertia : Reported or None
        I_zz [kg*m^2]; None where nothing is reported.
    others : mapping of str to Reported
        All else by its key: ``imbalance`` [N*m], ``timing_bias`` [s], ``exponent`` [1], and what the student added.
    diagnostics : tuple of Diagnostic
        What whoever grades should know of how it was read.
    """

    inertia: Reported | None = None
    others: Mapping[str, Reported] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()


def read_answers(readings: Readings | None, toml: bytes | None) -> Answers:
    """Bring together what the log and the answers file report; the file wins, and a difference is told.

    `toml`: The answers file: ``inertia = "4.4e-3 ± 0.1e-3 kg m^2"`` for each value, or a table with ``value``, ``u``
    and ``unit``; at the top or in ``[reported]``. One that is no TOML is read line by line. It never raises: a
    value that cannot be read says so itself.
    """
    found: dict[str, Reported] = dict(readings.reported) if readings is not None else {}
    told: list[Diagnostic] = []
    if toml is not None:
        for key, reported in _read_file(toml, told).items():
            before = found.get(key)
            if before is not None and (before.value, before.u) != (reported.value, reported.u):
                message = f'{key} is "{before.text}" in the log and "{reported.text}" in {_FILE}; the latter is graded'
                told.append(_diagnostic(ANSWERS_CONTRADICT_LOG, message, "", reported.line))
            found[key] = reported
    inertia = found.pop("inertia", None)
    return Answers(inertia, found, tuple(told))


def _read_file(data: bytes, told: list[Diagnostic]) -> dict[str, Reported]:
    try:
        text = decode(data, Faults(_FILE))[0]
    except GyroError as error:
        told.append(_diagnostic(ANSWERS_CANNOT_BE_READ, f"{_FILE} cannot be read: {error.diagnostics[0].message}"))
        return {}
    try:
        # Digits as they are typed: 4.40 is not 4.4.
        entries = _flat(tomllib.loads(text, parse_float=str), ())
        places = find_places("\n".join(split_lines(text)))
        lines = [next((places[path[:n]].line for n in (2, 1) if path[:n] in places), None) for path, _ in entries]
        values = [(path[-1], value, line) for (path, value), line in zip(entries, lines, strict=True)]
        values = values or _read_lines(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        message = f"{_FILE} is no TOML and is read line by line: {error}"
        told.append(
            _diagnostic(ANSWERS_NO_TOML, message, 'put each value in quotes: inertia = "4.4e-3 ± 0.1e-3 kg m^2"')
        )
        values = _read_lines(text)
    found: dict[str, Reported] = {}
    for key, value, line in values:
        reported = read_reported(key, value, line)
        _tell_misspelt(key, reported, told)
        found.setdefault(reported.key, reported)
    return found


def _flat(table: Mapping[str, Any], path: tuple[str, ...]) -> list[tuple[tuple[str, ...], str]]:
    """Give each answer as the text that it could have been written as."""
    found: list[tuple[tuple[str, ...], str]] = []
    for key, value in table.items():
        if isinstance(value, dict) and key.lower() in _TABLES and not path:
            found += _flat(value, (key,))
        elif isinstance(value, dict):
            parts = {name.lower(): str(part) for name, part in value.items()}
            spread = next((f" ± {parts[name]}" for name in _UNCERTAINTIES if name in parts), "")
            found.append(((*path, key), f"{parts.get('value', '')}{spread} {parts.get('unit', '')}".strip()))
        else:
            found.append(((*path, key), str(value)))
    return found


_LINE = re.compile(r"[#\s]*([^\W\d][\w .-]{0,60}?)\s*[:=]\s*(.+?)\s*")


def _read_lines(text: str) -> list[tuple[str, str, int | None]]:
    """Read ``inertia = 4.4e-3 ± 0.1e-3 kg m^2`` and ``inertia: …`` without quotes."""
    found: list[tuple[str, str, int | None]] = []
    for number, line in enumerate(split_lines(text)[:_MOST_LINES], 1):
        match = _LINE.fullmatch(line[:500])
        if match:
            value = match[2].partition(" #")[0].strip().strip("\"'").strip()
            found.append((re.sub(r"[\s.-]+", "_", match[1]), value, number))
    return found


def _tell_misspelt(key: str, reported: Reported, told: list[Diagnostic]) -> None:
    close = (
        []
        if reported.key in REPORTED_KINDS
        else difflib.get_close_matches(canonical_key(key), REPORTED_KINDS, n=1, cutoff=0.75)
    )
    if close:
        told.append(
            _diagnostic(ANSWER_NOT_ASKED_FOR, f'"{key}" is not asked for: was {close[0]} meant?', line=reported.line)
        )


def _diagnostic(code: str, message: str, hint: str = "", line: int | None = None) -> Diagnostic:
    return Diagnostic(code, CODES[code].severity, message, hint, _FILE, line)
