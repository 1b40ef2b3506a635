"""Which column serves which role: by header, by unit, by what the others are; asked about, never guessed."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata.quantities import fold_number, to_float
from gyrodata.readings import roles
from gyrodata.readings.lablog import PREFIX, Faults, Place, Readings, Text, header_of, listing, span
from gyrodata.readings.layout import Layout, is_of_means
from gyrodata.readings.roles import TEXTS, Header, kind_of_role, parse_header, squeeze, turns_in
from gyrodata.readings.settings import Settings
from gyrodata.readings.source import Grid, Row
from gyrodata.units import DISPLAY, KINDS, kinds_of

TWO_READINGS = re.compile(r"([0-9]+(?:[.,][0-9]+)?)\s*(?:-|->|→|/|to|bis|à|до)\s*([0-9]+(?:[.,][0-9]+)?)")
_BY_UNIT = {
    "mass": ("mass", "force", "torque"),
    "position": ("position", "torque"),
    "spin": ("spin", "spin_start", "spin_end"),
    "time": roles.TIMINGS,
}
"""What a column without a known name can be by its unit alone, if none of these roles is there."""
_TIMED = (*(("time", count) for count in roles.COUNTS), *((role,) for role in roles.ONE_TURN))
_LOADED = (("torque",), ("position", "mass"), ("position", "force"))
_ENOUGH = {"spin": roles.SPIN_SETS[:3], "timing": _TIMED, "count": _TIMED, "load": _LOADED}
"""Sets of roles that give a part of a run."""
_OTHER_THINGS = (
    {"reading", "mark", "ruler", "scale"}
    | roles.NOT_THE_WEIGHT
    | roles.THEORY_WORDS
    | roles.UNSURE_WORDS
    | roles.SUMMARY_WORDS
)


class Chosen(Struct, frozen=True):
    """A column with the role it serves."""

    at: int
    """Number of the column, from 0."""
    cell: Text
    header: Header
    role: str
    number: int | None = None
    """Number of a repeat (``time_2``: 2)."""
    turns: str = ""
    """Turns that the header states its times to cover: "1/3"."""
    part: int = 0
    """Which of the two readings in each cell is meant, from 1; 0 if there is one."""


class Choice(Struct):
    """Which column serves which role."""

    there: set[str]
    """Roles that have a column, or one value for the whole log."""
    used: dict[str, list[Chosen]] = field(default_factory=dict)
    """One column for each role; several for repeats of the time."""
    others: list[Chosen] = field(default_factory=list)
    """Further columns of a role that is served already, and ``inertia``."""
    unplaced: list[Text] = field(default_factory=list)
    """Headers that name no role."""
    stated: bool = False
    """Whether headers state the turns of their times."""
    asked: set[str] = field(default_factory=set)
    """Roles that a header may mean, and the log's author has been asked."""

    def serve(self, chosen: Chosen) -> None:
        """Take a column for its role, or put it with the others."""
        present = self.used.get(chosen.role, [])
        is_repeat = chosen.number is not None and {None, chosen.number}.isdisjoint(one.number for one in present)
        if chosen.role == "inertia" or (present and not is_repeat):
            self.others.append(chosen)
        else:
            self.used[chosen.role] = [*present, chosen]
            self.there.add(chosen.role)


def choose(layout: Layout, mapping: Mapping[str, str], settings: Settings, faults: Faults) -> Choice:
    """Give each column its role: by --map, by its name, by the turns that it states, by elimination, by its unit."""
    choice = Choice(set(settings.roles))
    mapped = _mapped(layout, mapping, faults)
    for chosen in mapped.values():
        choice.serve(chosen)
    columns = [Chosen(at, layout.cells[at], header, "") for at, header in enumerate(layout.headers)]
    named = {squeeze(roles.split_unit(one.cell.text)[0]): one.header.roles for one in columns}
    several: list[Chosen] = []
    stating: list[Chosen] = []
    # A mean stands back behind the readings that it is made of, and a bare letter behind a name.
    for column in sorted(columns, key=lambda one: (is_of_means(one.cell.text), _is_letter(one.header))):
        at, header = column.at, column.header
        texts = [row.texts[at] if at < len(row.texts) else "" for row in layout.rows]
        if at in mapped:
            continue
        name = squeeze(roles.split_unit(header.text)[0])
        if not header.roles and name and name[0] in "Δδσε":  # "ΔT" next to "T"
            found = tuple(f"u_{role}" for role in named.get(name[1:], ()) if f"u_{role}" in roles.UNCERTAINTIES)
            column = replace(column, header=replace(header, roles=found))
        found = column.header.roles
        if _is_letter(header) and len(texts) > 3 and texts == [str(number) for number, _ in enumerate(texts, 1)]:
            choice.serve(replace(column, role="run"))  # "n" that is 1, 2, 3, … numbers the runs
        elif found in ((), ("time",), ("precession_period",)) and _is_time(header) and turns_in(header.text):
            stating.append(column)
        elif found == ("spin",) and texts and all(TWO_READINGS.fullmatch(fold_number(text)) for text in texts):
            message = f'"{header.text}" has two readings in each cell: the spin at the start and at the end'
            faults.add(codes.HEADER_READ_AS, message, "if not, write them in columns of their own", column.cell)
            choice.serve(replace(column, role="spin_start", part=1))
            choice.serve(replace(column, role="spin_end", part=2))
        elif len(found) == 1:
            choice.serve(replace(column, role=found[0], number=header.number))
        elif found:
            several.append(column)
        elif header.text or any(texts):
            choice.unplaced.append(column.cell)
    _serve_stated(stating, choice)
    _eliminate(layout, several, choice, faults)
    _serve_turns(columns, layout, choice, faults)
    _serve_by_unit(columns, choice, faults)
    _ask_about_laps(layout, choice, faults)
    choice.unplaced.sort(key=lambda cell: cell.column)
    for repeats in choice.used.values():
        repeats.sort(key=lambda chosen: chosen.number or 0)
    return choice


def _is_letter(header: Header) -> bool:
    """Know a bare "n", "m" or "count", which may number the runs."""
    return header.unit is None and (len(header.text) == 1 or header.text.lower() == "count")


def _is_time(header: Header) -> bool:
    return "time" in kinds_of(header.unit or "")


def _mapped(layout: Layout, mapping: Mapping[str, str], faults: Faults) -> dict[int, Chosen]:
    """Find the columns that ``--map`` names."""
    found: dict[int, Chosen] = {}
    texts = [cell.text for cell in layout.cells]
    for key, wanted in mapping.items():
        same = [at for at, text in enumerate(texts) if text and squeeze(text) == squeeze(wanted)]
        if not same:
            hint = f"""the headers are: {listing([f'"{t}"' for t in texts if t], 40)}"""
            raise faults.refuse(codes.MAPPED_HEADER_UNKNOWN, f"--map {key}={wanted!r}: there is no such header", hint)
        at = next((at for at in same if texts[at] == wanted.strip()), same[0])
        if at in found:
            message = f"--map gives the header {wanted!r} two roles, {found[at].role} and {key}"
            hint = f"leave --map {key}=… out, or give it another header"
            raise faults.refuse(codes.MAPPED_ROLE_UNKNOWN, message, hint)
        role, number = ("time", int(key[5:])) if key.startswith("time_") else (key, None)
        header, kind = layout.headers[at], kind_of_role(role)
        ends = (header.text.rpartition(mark)[2].strip() for mark in ",;/_ " if mark in header.text)
        unit = header.unit or next((end for end in ends if kind in kinds_of(end)), header.spread.partition(" ")[2])
        header = replace(header, unit=None if kind == "text" else unit or None)
        found[at] = Chosen(at, layout.cells[at], header, role, number)
    return found


def _serve_stated(stating: list[Chosen], choice: Choice) -> None:
    """Take the times whose headers state their turns, "Time for 1/3 rev (s)": of the precession, or of the ball."""
    spins = any(choice.there.issuperset(one) for one in roles.SPIN_SETS)
    for column in stating:
        turns, of_the_spin = turns_in(column.cell.text), roles.is_of_the_spin(column.cell.text)
        if of_the_spin and not roles.clock_word(column.cell.text) and "spin_time" not in choice.used:
            choice.serve(replace(column, role="spin_time", turns=turns))
        elif of_the_spin or (not spins and turns.isdigit() and int(turns) >= 5):
            choice.unplaced.append(column.cell)  # ten turns may be the ball's
        else:
            choice.serve(replace(column, role="time", number=len(choice.used.get("time", [])) + 1, turns=turns))
            choice.stated = True


def _eliminate(layout: Layout, several: list[Chosen], choice: Choice, faults: Faults) -> None:
    """Decide headers of several roles if only one role is left; ask about the rest if they are needed."""
    counts = choice.used.get("turns", [])
    counted = {text for row in layout.rows for one in counts for text in row.texts[one.at : one.at + 1]}
    for column in list(several):
        # "T" can only be the time of one turn if no turns are counted, or each time covers one.
        known = {"time", "precession_period", "angle"} & choice.there
        if column.header.roles != ("time", "precession_period") or known or not counted <= {"", "1"}:
            continue
        if "turns" not in choice.there or counts:
            several.remove(column)
            choice.serve(replace(column, role="precession_period"))
            message = f'"{column.cell.text}" is read as the time of one whole turn of the precession'
            hint = f'if it covers another number of turns: --map time="{column.cell.text}" --set turns=…'
            faults.add(codes.HEADER_READ_AS, message, hint, column.cell)
    while decided := [column for column in several if len(_left(column, choice)) == 1]:
        several.remove(decided[0])
        choice.serve(replace(decided[0], role=_left(decided[0], choice)[0]))
    for column in several:
        left, cell = _left(column, choice), column.cell
        if not _may_be_needed(left, choice.there):
            message = f'the column "{cell.text}" is not used: it fits {" and ".join(column.header.roles)}'
            faults.add(codes.COLUMN_NOT_USED, message, "", cell)
            continue
        ways = {role: f'--map {role}="{cell.text}"' for role in left}
        choice.asked.update(left)
        message = f'the header "{cell.text}" fits {" and ".join(left)}'
        faults.add(codes.HEADER_FITS_TWO_ROLES, message, f"say which: {' or '.join(ways.values())}", cell)


def _left(column: Chosen, choice: Choice) -> list[str]:
    """Give the roles that a header may still serve."""
    found, there = column.header.roles, choice.there | ({"turns"} if choice.stated else set())
    if found == ("time", "precession_period") and "time" in choice.used and there.isdisjoint(roles.COUNTS):
        return []  # next to a time without turns, "T" may be the mean of such times as well
    # An uncertainty belongs to the role that its symbol has, "σ_T" to "T"; else to a role that has a column.
    bases = tuple(role.removeprefix("u_") for role in found)
    for used in choice.used.values():
        if bases != found and used[0].header.roles == bases and used[0].role in bases:
            return [f"u_{used[0].role}"]
    open_roles = [role for role in found if role not in there and (role[:2] != "u_" or role[2:] in choice.used)]
    # Nobody needs a quantity that the readings give already, if the header can be another one.
    return [role for role in open_roles if role not in roles.derived_roles(there)] or open_roles


def _may_be_needed(left: list[str], there: set[str]) -> bool:
    served = {part for part, sets in _ENOUGH.items() if any(there.issuperset(one) for one in sets)}
    return any(role[:2] == "u_" or roles.BY_NAME[role].part not in served for role in left)


def _serve_turns(columns: list[Chosen], layout: Layout, choice: Choice, faults: Faults) -> None:
    """Take the one column that can only count turns or swept angles, if no other column or line says them."""
    fit = []
    for column in columns if choice.there.isdisjoint((*roles.COUNTS, *roles.ONE_TURN)) else ():
        texts = [text for row in layout.rows for text in row.texts[column.at : column.at + 1] if text]
        if column.cell in choice.unplaced and roles.are_turns(column.header, texts):
            fit.append(replace(column, role="turns"))
        elif column.cell in choice.unplaced and kinds_of(column.header.unit or "") == {"angle"} and all(texts):
            fit.append(replace(column, role="angle"))
    if len(fit) == 1:
        choice.serve(fit[0])
        choice.unplaced.remove(fit[0].cell)
        message = f'"{fit[0].cell.text}" is read as the {fit[0].role} that each time covers'
        hint = f"if it is not, name the {fit[0].role} with --map {fit[0].role}=HEADER"
        faults.add(codes.HEADER_READ_AS, message, hint, fit[0].cell)


def _serve_by_unit(columns: list[Chosen], choice: Choice, faults: Faults) -> None:
    """Give a column without a known name the role that is missing, if no other column has such a unit."""
    there = choice.there | choice.asked
    for role, present in _BY_UNIT.items():
        kind = kind_of_role(role)
        unplaced = [column for column in columns if column.cell in choice.unplaced]
        fit = [column for column in unplaced if kind in kinds_of(column.header.unit or "")]
        if len(fit) != 1 or not there.isdisjoint(present) or (role == "time" and there.isdisjoint(roles.COUNTS)):
            continue
        cell = fit[0].cell
        # "T/2 (s)", "Weight #1 (g)" and "σt (s)" say something else.
        of_the_rod = role == "spin" and re.search(roles.PRECESSION, cell.text)
        other = roles.squeezed_words(cell.text) & _OTHER_THINGS or re.match(r"[^\[^]*[0-9]|[σε]\w", cell.text)
        if of_the_rod or other:
            continue
        choice.serve(replace(fit[0], role=role))
        choice.unplaced.remove(cell)
        message = f'"{cell.text}" is read as the {role}, because no other column is {KINDS[kind].words}'
        faults.add(codes.HEADER_READ_AS, message, f"if it is not, name the {role} with --map {role}=HEADER", cell)


def _ask_about_laps(layout: Layout, choice: Choice, faults: Faults) -> None:
    """Find times in the ratio 1 : 2 : 3 in every row: laps of one clock, and not repeats of one time."""
    laps = [chosen for chosen in choice.used.get("time", []) if chosen.number is not None and not chosen.turns]
    try:
        rows = [[to_float(fold_number(row.texts[lap.at])) for lap in laps] for row in layout.rows]
    except (ValueError, IndexError):
        return
    if len(laps) > 1 and all(abs(t - k * row[0]) < 0.1 * k * row[0] for row in rows for k, t in enumerate(row, 1)):
        names = f'"{laps[0].cell.text}" to "{laps[-1].cell.text}"'
        message = f"{names} grow as 1 : 2 : … in every row: laps of one clock, not repeats of one time"
        hint = f'if each lap is one turn, use the last: --map time="{laps[-1].cell.text}" --set turns={len(laps)}'
        faults.add(codes.LAPS_OF_ONE_CLOCK, message, hint, laps[0].cell)
        choice.asked.update(("time", "turns"))


def note_unplaced(choice: Choice, faults: Faults) -> None:
    """Say which headers name nothing known."""
    if choice.unplaced:
        texts = [cell.text or f"(column {cell.column}, no header)" for cell in choice.unplaced]
        message = f"not used: the column{'s' * (len(texts) > 1)} {listing(texts)}"
        faults.add(codes.HEADER_UNKNOWN, message, "if one is needed, name it with --map role=HEADER")


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
    if not any(there.issuperset(one) for one in roles.SPIN_SETS):
        begun = (one for one in roles.SPIN_SETS if not (there | set(columns)).isdisjoint(one))
        missing += [role for role in next(begun, ("spin",)) if role not in there]
    if there.isdisjoint(roles.ONE_TURN):
        whole = [role for role in roles.ONE_TURN if role in columns and "time" not in columns]
        missing += (whole[:1] or ["time"]) if "time" not in there else []
        if there.isdisjoint(roles.COUNTS) and not whole:
            missing.append(next((role for role in roles.COUNTS if role in columns), "turns"))
    return missing


SEVERAL = 4
"""So many quantities that are missing are told of together."""


def _missing(role: str, missing: list[str], texts: list[str], choice: Choice) -> tuple[str, str]:
    """Say what is missing, and every way to supply it."""
    unit, known = DISPLAY[kind_of_role(role)], roles.BY_NAME[role]
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
    # A run with every cell filled lacks nothing. A cell that could not be read is reported already; its text is there.
    blanks = (run for column in columns.values() for run, cell in enumerate(column.readings) if not cell.text)
    for run in sorted(set(blanks)):
        there = {role for role, column in columns.items() if column.readings[run].text}
        loaded = "mass" not in columns or columns["mass"].values[run] != 0
        for role in _missing_roles(there, columns, loaded):
            lacking.setdefault(role, []).append(run)
    for role, runs in lacking.items():
        lines = list(dict.fromkeys(table.lines[run] for run in runs))
        hint = f"write it there; a blank cell takes the {role} above only within one block of filled rows"
        if role in roles.COUNTS:
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
    kept = ((f"{key}: ", text) for key, text in grid.metadata if key.lower() not in roles.KEYS or key.lower() in TEXTS)
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
        if role := roles.altered_role(note).replace("_", " "):
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
    headers = [header for header in headers if len(header) <= roles.MAX_HEADER]
    timed = [header for header in headers if "time" in kinds_of(parse_header(header).unit or "")]
    close = [
        header for header in headers if roles.suggest_role(header) == role and (role != "turns" or header not in timed)
    ]
    if role in ("time", "turns"):
        told = [(one, turns) for one in timed if not roles.is_of_the_spin(one) and (turns := stated_turns(one))]
        if len(told) == 1:
            return f'is it --map time="{told[0][0]}" --set {told[0][1]}? '
        whole = [header for header in timed if roles.suggest_role(header) == "precession_period"]
        if role == "time" and whole:
            return f'is it --map precession_period="{whole[0]}", the time of one whole turn? '
    elif role == "mass" and (counts := [header for header in headers if roles.counts_weights(parse_header(header))]):
        return f'"{counts[0]}" counts weights: write their mass instead, in a column mass [g], as 40.3 or 2 x 20.15; '
    elif role == "spin" and (turned := [one for one in timed if roles.is_of_the_spin(one) and stated_turns(one)]):
        return f'is it "{turned[0]}"? divide by the turns, and write spin_period [s] (or _start, _end); '
    return f'is it "{close[0]}"? ' if close else ""
