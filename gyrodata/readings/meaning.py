"""What every run must have, what is missing, and every way to supply it."""

from __future__ import annotations

import math
import re
from collections.abc import Collection

from gyrodata import diagnostics as codes
from gyrodata.readings.cells import PREFIX
from gyrodata.readings.columns import Choice
from gyrodata.readings.headers import MAX_HEADER, counts_weights, is_of_the_spin, parse_header, suggest_role, turns_in
from gyrodata.readings.lablog import Faults, Place, Readings, Text, header_of, listing, span
from gyrodata.readings.roles import BY_NAME, COUNTS, KEYS, ONE_TURN, SPIN_SETS, TEXTS, altered_role, kind_of_role
from gyrodata.readings.source import Grid, Row
from gyrodata.units import DISPLAY, kinds_of


def check_meaning(table: Readings, choice: Choice, unread: set[str], faults: Faults, is_told: bool) -> None:
    """Add a fault for everything that is missing or contradicts itself; `is_told`: --map names the period."""
    said = any(diagnostic.code == codes.VALUE_BELOW_ITS_FIRST_ROW for diagnostic in faults.found)
    there, mass = set(table.columns) | unread, table.columns.get("mass")
    loaded = mass is None or "force" in there or any(value != 0 for value in mass.values)
    missing = [role for role in _missing_roles(there, table.columns, loaded) if role not in choice.asked]
    if "precession_period" in choice.asked and "turns" in missing:
        missing.remove("turns")  # needed or not, by what is answered
    unread = unread | choice.asked
    texts = [cell.text for cell in choice.unplaced if cell.text]
    told = [_missing(role, missing, texts, choice) for role in missing]
    if len(told) >= SEVERAL:
        told = [("; ".join(message for message, _ in told), "\n".join(hint for _, hint in told))]
    for message, hint in told:
        faults.add(codes.QUANTITY_MISSING, message, hint)
    if not missing and not any(kind_of_role(role) != "text" and role[:2] != "u_" for role in unread) and not said:
        _check_runs(table, faults)
    _check_turns(table, faults)
    if not is_told:
        _check_period(table, faults)


def _missing_roles(there: set[str], columns: Collection[str], loaded: bool) -> list[str]:
    """Name what a run lacks, or the whole log; of several roles that serve, one that the log has a column of."""
    missing: list[str] = []
    if "torque" not in there and loaded:
        load = next((role for role in ("mass", "force", "torque") if role in columns), "mass")
        missing += [load] if there.isdisjoint(("mass", "force")) else []
        missing += ["position"] if "position" not in there and load != "torque" else []
    if not any(there.issuperset(roles) for roles in SPIN_SETS):
        begun = (roles for roles in SPIN_SETS if not (there | set(columns)).isdisjoint(roles))
        missing += [role for role in next(begun, ("spin",)) if role not in there]
    if there.isdisjoint(ONE_TURN):
        whole = [role for role in ONE_TURN if role in columns and "time" not in columns]
        missing += (whole[:1] or ["time"]) if "time" not in there else []
        if there.isdisjoint(COUNTS) and not whole:
            missing.append(next((role for role in COUNTS if role in columns), "turns"))
    return missing


SEVERAL = 4
"""So many quantities that are missing are told of together."""


def _missing(role: str, missing: list[str], texts: list[str], choice: Choice) -> tuple[str, str]:
    """Say what is missing, and every way to supply it."""
    unit, known = DISPLAY[kind_of_role(role)], BY_NAME[role]
    sample = known.sample or f"1 {unit}"
    quoted = f'"{sample}"' if " " in sample else sample
    hint = f"add a column {header_of(role, unit)}"
    hint += f'; or a line "# {role}: {sample}"; or --set {role}={quoted}' if role != "time" else ""
    hint += f"; or --map {role}=HEADER to name the column that contains it{known.instead}"
    message = f"{role} is missing{f' ({known.meaning})' if known.meaning else ''}"
    if texts and role == missing[0]:
        message += f"; headers that could not be placed: {listing(texts)}"
    if role == "spin" and (rate := choice.used.get("precession_rate")):
        # The lab sheet calls the spin so too.
        header = rate[0].header.text
        hint = f'is it "{header}", which is read as the rate of the precession? --map spin="{header}"; {hint}'
    return message, hint if role == "turns" and "time" in missing else advise(role, texts) + hint


def _check_runs(table: Readings, faults: Faults) -> None:
    """Find the runs that lack what the others have."""
    columns = table.columns
    lacking: dict[str, list[int]] = {}
    # A run with every cell filled lacks nothing. A cell that could not be read has been told of; its text is there.
    blanks = (run for column in columns.values() for run, cell in enumerate(column.readings) if not cell.text)
    for run in sorted(set(blanks)):
        there = {role for role, column in columns.items() if column.readings[run].text}
        loaded = "mass" not in columns or columns["mass"].values[run] != 0
        for role in _missing_roles(there, columns, loaded):
            lacking.setdefault(role, []).append(run)
    for role, runs in lacking.items():
        lines = list(dict.fromkeys(table.lines[run] for run in runs))
        hint = f"write it there; a blank cell takes the {role} above only within one block of filled rows"
        if role in COUNTS:
            hint = f'write it there, or for all blank cells a line "# {role}: …"'
        faults.add(codes.RUN_LACKS_QUANTITY, f"{span(lines)}: no {role}", hint, Place(lines[0], 1))


def _check_turns(table: Readings, faults: Faults) -> None:
    """Compare turns with the swept angle, where a log gives both."""
    turns, angle = table.columns.get("turns"), table.columns.get("angle")
    if turns is None or angle is None:
        return
    for run, (count, swept) in enumerate(zip(turns.readings, angle.readings, strict=True)):
        if count.value is None or swept.value is None:
            continue
        if abs(swept.value - 2 * math.pi * count.value) > max(swept.step or 0.0, 0.01 * abs(swept.value)):
            message = f"run {table.runs[run]}: {count.text} turns are {360 * count.value:.4g} degrees, not {swept.text}"
            hint = "correct one of the two, or take one column out"
            faults.add(codes.TURNS_CONTRADICT_ANGLE, message, hint, angle.place(run))


def _check_period(table: Readings, faults: Faults) -> None:
    """Ask, where what is called a period or a rate may be no single turn's: the costliest of all misreadings."""
    columns = table.columns
    period, time = columns.get("precession_period"), columns.get("time")
    counted = columns.get("turns") or columns.get("angle")
    if counted is None or period is None or (time is not None and time.header == period.header):
        return
    full = 1.0 if counted.role == "turns" else 2 * math.pi
    turned = [abs(value) / full if value is not None else None for value in counted.values]
    if time is None:
        if all(value is None or abs(value - 1) < 1e-3 for value in turned):
            return
        message = f'"{period.header}" is the time of one whole turn, and yet {counted.role} is given'
        hint = f'if it is the time of the {counted.role} given: --map time="{period.header}"'
        hint += f"; if not, take {counted.role} out"
        place = next(filter(None, map(counted.place, range(len(turned)))), period.place(0))
        faults.add(codes.TURNS_FOR_ONE_PERIOD, message, hint, place)
        return
    exchanged = [
        abs(value / seconds - count) < 0.02 * count
        for seconds, value, count in zip(time.values, period.values, turned, strict=True)
        if seconds and value and count and not 0.8 < count < 1.25
    ]
    if 2 * sum(exchanged) > len(exchanged):
        message = f'"{period.header}" is the turns times "{time.header}": the first is the time, the second the period'
        hint = f'--map time="{period.header}" --map precession_period="{time.header}"'
        faults.add(codes.TIME_AND_PERIOD_EXCHANGED, message, hint, period.place(0), len(period.readings[0].text))


def warn_of_notes(grid: Grid, faults: Faults) -> None:
    """Warn of every note that may say that a reading is not what is typed, as "twice the real rpm"."""
    kept = ((f"{key}: ", text) for key, text in grid.metadata if key.lower() not in KEYS or key.lower() in TEXTS)
    told: dict[str, Text | tuple[Row, int]] = {text.text: text for text in grid.comments}
    told |= {f"{key}{text.text}": text for key, text in kept if not key.lower().startswith(PREFIX)}
    word = re.compile(r"[^\W\d_]{3}")
    for row in grid.rows:
        if word.search(grid.lines[row.line - 1]):
            said = {at: text for at, text in enumerate(row.texts) if word.search(text) and not parse_header(text).roles}
            # A row of words may be one note, which a comma parts.
            whole = len(said) == len(row.texts) - row.texts.count("")
            for at, text in ((min(said), ", ".join(said.values())),) if whole else said.items():
                told.setdefault(text, (row, at))
    for note, place in told.items():
        if role := altered_role(note).replace("_", " "):
            message = f'the note "{note[:100]}" may change the {role}, and gyro uses each number as it is typed'
            hint = 'correct the typed values if they need it; then delete the note, or write "corrected:" before it'
            cell = place if isinstance(place, Text) else grid.cell(*place)
            faults.add(codes.NOTE_MAY_CHANGE_READING, message, hint, cell)


_DEGREES = r"([0-9]+(?:[.,][0-9]+)?)\s*(?:°|º|˚|deg)"
_PART = r"(?i)(?<!\w)[0-9]|half|\bsemi|halb|demi|medi[oa]\b|meia|pół|полов|½"


def stated_turns(header: str) -> str:
    """Find the turns or the angle that a header says its time covers, for --set."""
    if match := re.search(_DEGREES, header):
        return f'angle="{match[1].replace(",", ".")} deg"'
    turns = turns_in(header) or ("…" if re.search(_PART, header) else "")  # whoever wrote "5 half turns" knows
    return f"turns={turns}" if turns else ""


def advise(role: str, headers: list[str]) -> str:
    """Propose what to type for a missing role, from the headers that could not be placed."""
    headers = [header for header in headers if len(header) <= MAX_HEADER]
    timed = [header for header in headers if "time" in kinds_of(parse_header(header).unit or "")]
    close = [header for header in headers if suggest_role(header) == role and (role != "turns" or header not in timed)]
    if role in ("time", "turns"):
        told = [(one, turns) for one in timed if not is_of_the_spin(one) and (turns := stated_turns(one))]
        if len(told) == 1:
            return f'is it --map time="{told[0][0]}" --set {told[0][1]}? '
        whole = [header for header in timed if suggest_role(header) == "precession_period"]
        if role == "time" and whole:
            return f'is it --map precession_period="{whole[0]}", the time of one whole turn? '
    elif role == "mass" and (counts := [header for header in headers if counts_weights(parse_header(header))]):
        return f'"{counts[0]}" counts weights: write their mass instead, in a column mass [g], as 40.3 or 2 x 20.15; '
    elif role == "spin" and (turned := [one for one in timed if is_of_the_spin(one) and stated_turns(one)]):
        return f'is it "{turned[0]}"? divide by the turns, and write spin_period [s] (or _start, _end); '
    return f'is it "{close[0]}"? ' if close else ""
