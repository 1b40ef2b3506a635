"""Which column serves which role: by header, by unit, by what the others are; asked about, never guessed."""

from __future__ import annotations

import re
from collections.abc import Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata import diagnostics as codes
from gyrodata.quantities import fold_number, to_float
from gyrodata.readings import roles
from gyrodata.readings.headers import Header, are_turns, clock_word, is_of_the_spin, split_unit, turns_in
from gyrodata.readings.lablog import Faults, Text, listing
from gyrodata.readings.layout import Layout, is_of_means
from gyrodata.readings.roles import kind_of_role, squeeze
from gyrodata.readings.settings import Settings
from gyrodata.units import KINDS, kinds_of

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
    named = {squeeze(split_unit(one.cell.text)[0]): one.header.roles for one in columns}
    several: list[Chosen] = []
    stating: list[Chosen] = []
    # A mean stands back behind the readings that it is made of, and a bare letter behind a name.
    for column in sorted(columns, key=lambda one: (is_of_means(one.cell.text), _is_letter(one.header))):
        at, header = column.at, column.header
        texts = [row.texts[at] if at < len(row.texts) else "" for row in layout.rows]
        if at in mapped:
            continue
        name = squeeze(split_unit(header.text)[0])
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
        turns, of_the_spin = turns_in(column.cell.text), is_of_the_spin(column.cell.text)
        if of_the_spin and not clock_word(column.cell.text) and "spin_time" not in choice.used:
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
        return []  # beside a time whose turns are not told, "T" may be the mean of such times as well
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
        if column.cell in choice.unplaced and are_turns(column.header, texts):
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
        if roles.squeezed_words(cell.text) & _OTHER_THINGS or re.match(r"[^\[^]*[0-9]|[σε]\w", cell.text):
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
