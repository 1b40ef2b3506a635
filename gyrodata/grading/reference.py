"""What I_zz should be: stated for each station, or taken from the class itself."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable
from dataclasses import dataclass

from gyrodata.diagnostics import RUBRIC_PARTS_CONTRADICT
from gyrodata.fitting import MAD_TO_SD
from gyrodata.grading.toml_table import Table
from gyrodata.quantities import parse_quantity, parse_uncertainty
from gyrodata.units import UnitError


@dataclass(frozen=True, slots=True)
class Reference:
    """The value that a station's gyroscope should give."""

    inertia: float
    """[kg*m^2]"""
    u: float
    """Standard uncertainty [kg*m^2]."""
    source: str
    """Where it comes from, in words."""


def station_key(text: str) -> str:
    """Write the name of a station in one way, so that "Bench A" of a log is "bench a" of a rubric."""
    return " ".join(text.split()).casefold()


def read_references(top: Table) -> tuple[dict[str, Reference], bool]:
    """Read the table ``[reference]`` of a rubric.

    Gives: References by station ("all" for every other), and whether the class itself is the reference.
    """
    table = top.table("reference")
    if table is None:
        return {}, False
    from_class = table.choice("from", ("class", "rubric"), "rubric") == "class"
    references: dict[str, Reference] = {}
    for station, value in table.values.items():
        if station == "from":
            continue
        if not isinstance(value, dict):
            hint = "head the values of station 3 with [reference.3], those of all stations with [reference.all]"
            table.wrong(station, f'"{station}" stands outside of a station', hint)
            table.asked.append(station)
            continue
        one = table.table(station)
        reference = _reference(one, station) if one else None
        if reference is not None:
            references[station_key(station)] = reference
    table.done()
    if from_class and references:
        hint = 'remove from = "class", or remove the stations'
        table.wrong(
            "from", "the reference comes from the class, and stations are given too", hint, RUBRIC_PARTS_CONTRADICT
        )
    if not from_class and not references and len(table.values) == 0:
        top.wrong("reference", "[reference] is empty", 'write from = "class", or [reference.3] with inertia and u')
    return references, from_class


def _reference(table: Table, station: str) -> Reference | None:
    inertia = table.text("inertia", '"4.44e-3 kg m^2"', required=True)
    u = table.text("u", '"0.03e-3 kg m^2" or "1 %"', required=True)
    table.done()
    if inertia is None or u is None:
        return None
    key = "inertia"
    try:
        value = parse_quantity(inertia, "inertia")
        key = "u"
        width = parse_uncertainty(u, "inertia").at(value)
    except UnitError as error:
        table.wrong(key, f"{key}: {error}", error.hint or f'write {key} = "0.03e-3 kg m^2"')
        return None
    if value <= 0:
        table.wrong("inertia", "inertia is not above zero", 'write inertia = "4.44e-3 kg m^2"')
        return None
    return Reference(value, width, "the rubric" if station == "all" else f"the rubric, station {station}")


# --- the class as its own reference -------------------------------------------------------------------------

FEW = 5
"""With fewer logs of a station than this, its median is that of the whole class."""

MEDIAN_TO_MEAN = 1.2533
"""Standard uncertainty of a median over that of a mean, √(π/2), for normal values."""


def class_references(values: Iterable[tuple[str | None, float, float]]) -> dict[str, Reference]:
    """Take the reference of each station from the logs of a class.

    `values`: For each log its station (None where it says none), I_zz and its u [kg*m^2], in any order. Gives: A
    station with at least `FEW` logs has its own; "all" is for every other. u is that of a median, from the median
    absolute deviation, for a station; for "all" it is the scatter itself, for the gyroscopes may differ. Neither is
    smaller than what the logs' own u allow. Empty for no logs.
    """
    stations: dict[str, list[tuple[float, float]]] = {}
    everyone: list[tuple[float, float]] = []
    for station, value, u in values:
        everyone.append((value, u))
        if station is not None:
            stations.setdefault(station, []).append((value, u))
    if not everyone:
        return {}
    references = {}
    for station, logs in sorted(stations.items()):
        if len(logs) >= FEW:
            median, scatter, least = _robust(logs)
            u = max(MEDIAN_TO_MEAN * scatter / math.sqrt(len(logs)), least)
            references[station] = Reference(median, u, f"the median of the {len(logs)} logs of station {station}")
    median, scatter, least = _robust(everyone)
    words = "this log alone" if len(everyone) == 1 else f"the median of all {len(everyone)} logs"
    references["all"] = Reference(median, max(scatter, least), words)
    return references


def _robust(logs: list[tuple[float, float]]) -> tuple[float, float, float]:
    """Median, scatter about it, and the u that the median has from the logs' own."""
    median = statistics.median(value for value, _ in logs)
    scatter = MAD_TO_SD * statistics.median(abs(value - median) for value, _ in logs)
    return median, scatter, statistics.median(u for _, u in logs) / math.sqrt(len(logs))
