"""Which column serves which role: by header, by unit, by what the others are; asked about, never guessed."""

from __future__ import annotations

import re
from collections.abc import Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from gyrodata.diagnostics import (
    COLUMN_NOT_USED,
    HEADER_FITS_TWO_ROLES,
    HEADER_READ_AS,
    HEADER_UNKNOWN,
    LAPS_OF_ONE_CLOCK,
    MAPPED_HEADER_UNKNOWN,
    MAPPED_ROLE_UNKNOWN,
)
from gyrodata.quantities import fold_number, to_float
from gyrodata.readings.headers import Header, clock_word, is_of_the_spin, split_unit, turns_in, unit_for
from gyrodata.readings.lablog import Faults, Text, listing
from gyrodata.readings.layout import Layout, is_of_means
from gyrodata.readings.roles import (
    BY_NAME,
    COUNTS,
    NOT_THE_WEIGHT,
    ONE_TURN,
    SPIN_SETS,
    SUMMARY_WORDS,
    THEORY_WORDS,
    TIMINGS,
    UNCERTAINTIES,
    UNSURE_WORDS,
    derived_roles,
    kind_of_role,
    squeeze,
    squeezed_words,
)
from gyrodata.readings.settings import Settings
from gyrodata.units import KINDS, kinds_of


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


class Choice(Struct):
    """Which column serves which role."""

    used: dict[str, list[Chosen]] = field(default_factory=dict)
    """One column for each role; several for repeats of the time."""
    others: list[Chosen] = field(default_factory=list)
    """Further columns of a role that is served already, and ``inertia``."""
    unplaced: list[Text] = field(default_factory=list)
    """Headers that name no role."""
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


def choose(layout: Layout, mapping: Mapping[str, str], settings: Settings, faults: Faults) -> Choice:
    """Give each column its role: by --map, by its name, by the turns that it states, by elimination, by its unit."""
    choice = Choice()
    mapped = _mapped(layout, mapping, faults)
    for chosen in mapped.values():
        choice.serve(chosen)
    open_columns: dict[int, Header] = {}
    stating: list[int] = []
    named = {squeeze(split_unit(header.text)[0]): header.roles for header in layout.headers}
    # A mean stands back behind the readings that it is made of, and a bare letter behind a name.
    for at, header in sorted(enumerate(layout.headers), key=lambda item: (is_of_means(item[1].text), _letter(item[1]))):
        texts = [row.texts[at] if at < len(row.texts) else "" for row in layout.rows]
        if at in mapped or at in layout.combined:
            continue
        mark, symbol = (name := squeeze(split_unit(header.text)[0]))[:1], name[1:]
        if not header.roles and mark and mark in "Δδσε" and named.get(symbol):  # "ΔT" next to "T"
            header = replace(header, roles=tuple(f"u_{role}" for role in named[symbol] if f"u_{role}" in UNCERTAINTIES))
        if _letter(header) and len(texts) > 3 and texts == [str(number) for number, _ in enumerate(texts, 1)]:
            choice.serve(Chosen(at, layout.cells[at], header, "run"))  # "n" that is 1, 2, 3, … numbers the runs
        elif header.roles in ((), ("time",), ("precession_period",)) and _is_time(header) and turns_in(header.text):
            stating.append(at)
        elif len(header.roles) == 1:
            choice.serve(Chosen(at, layout.cells[at], header, header.roles[0], header.number))
        elif header.roles:
            open_columns[at] = header
        elif layout.cells[at].text or any(texts):
            choice.unplaced.append(layout.cells[at])
    _serve_stated(layout, stating, choice, settings)
    _eliminate(layout, open_columns, choice, settings, faults)
    _serve_by_unit(choice, layout, settings, faults)
    _ask_about_laps(layout, choice, faults)
    choice.unplaced.sort(key=lambda cell: cell.column)
    for repeats in choice.used.values():
        repeats.sort(key=lambda chosen: chosen.number or 0)
    return choice


def _letter(header: Header) -> bool:
    """Know a bare "n", "m" or "count", which may number the runs."""
    return header.unit is None and (len(header.text) == 1 or header.text.lower() == "count")


def _is_time(header: Header) -> bool:
    return "time" in kinds_of(header.unit or "")


def _serve_stated(layout: Layout, stating: list[int], choice: Choice, settings: Settings) -> None:
    """Take the times whose headers state their turns, "Time for 1/3 rev (s)": of the precession, or of the ball."""
    there = set(choice.used) | set(settings.roles)
    spins = any(there.issuperset(roles) for roles in SPIN_SETS)
    for at in stating:
        header, cell = layout.headers[at], layout.cells[at]
        turns, of_the_spin = turns_in(header.text), is_of_the_spin(header.text)
        if of_the_spin and not clock_word(header.text) and "spin_time" not in choice.used:
            choice.serve(Chosen(at, cell, header, "spin_time", turns=turns))
        elif of_the_spin or (not spins and turns.isdigit() and int(turns) >= 5):
            choice.unplaced.append(cell)  # ten turns may be the ball's
        else:
            choice.serve(Chosen(at, cell, header, "time", len(choice.used.get("time", [])) + 1, turns))


def _ask_about_laps(layout: Layout, choice: Choice, faults: Faults) -> None:
    """Find times in the ratio 1 : 2 : 3 in every row: laps of one clock, and not repeats of one time."""
    spots = [chosen.at for chosen in choice.used.get("time", []) if chosen.number is not None and not chosen.turns]
    if not spots and choice.used.keys().isdisjoint(TIMINGS):
        unknown = [(at, header) for at, header in enumerate(layout.headers) if layout.cells[at] in choice.unplaced]
        spots = [at for at, header in unknown if _is_time(header) and not turns_in(header.text)]
    try:
        rows = [[to_float(fold_number(row.texts[at])) for at in spots] for row in layout.rows]
    except (ValueError, IndexError):
        return
    if len(spots) > 1 and all(abs(t - k * row[0]) < 0.1 * k * row[0] for row in rows for k, t in enumerate(row, 1)):
        first, last = layout.cells[spots[0]], layout.cells[spots[-1]]
        names, ratio = f'"{first.text}" to "{last.text}"', " : ".join(str(k) for k, _ in enumerate(spots, 1))
        message = f"{names} grow as {ratio} in every row: laps of one clock, not repeats of one time"
        hint = f'if each lap is one turn, use the last: --map time="{last.text}" --set turns={len(spots)}'
        faults.add(LAPS_OF_ONE_CLOCK, message, hint, first)
        choice.asked.update(("time", "turns"))


def _mapped(layout: Layout, mapping: Mapping[str, str], faults: Faults) -> dict[int, Chosen]:
    """Find the columns that ``--map`` names."""
    found: dict[int, Chosen] = {}
    texts = [cell.text for cell in layout.cells]
    for key, wanted in mapping.items():
        exact = [at for at, text in enumerate(texts) if text == wanted.strip()]
        loose = [at for at, text in enumerate(texts) if text and squeeze(text) == squeeze(wanted)]
        places = exact or loose
        if not places:
            hint = f"""the headers are: {listing([f'"{t}"' for t in texts if t], 40)}"""
            raise faults.refuse(MAPPED_HEADER_UNKNOWN, f"--map {key}={wanted!r}: there is no such header", hint)
        at = places[0]
        if at in found:
            message = f"--map gives the header {wanted!r} two roles, {found[at].role} and {key}"
            raise faults.refuse(MAPPED_ROLE_UNKNOWN, message, f"leave --map {key}=… out, or give it another header")
        role, number = ("time", int(key[5:])) if key.startswith("time_") else (key, None)
        header, unit = layout.headers[at], None
        if kind_of_role(role) != "text":
            unit = header.unit or unit_for(header.text, kind_of_role(role)) or header.spread.partition(" ")[2] or None
        found[at] = Chosen(at, layout.cells[at], replace(header, unit=unit), role, number)
    return found


def _eliminate(
    layout: Layout, open_columns: dict[int, Header], choice: Choice, settings: Settings, faults: Faults
) -> None:
    """Decide headers of several roles where only one role is left; ask about the rest if they are needed."""
    for at, header in list(open_columns.items()):
        if header.roles == ("time", "precession_period") and _is_one_turn(layout, choice, settings):
            cell = layout.cells[at]
            choice.serve(Chosen(at, cell, header, "precession_period"))
            del open_columns[at]
            message = f'"{cell.text}" is read as the time of one whole turn of the precession'
            hint = f'if it covers another number of turns: --map time="{cell.text}" --set turns=…'
            faults.add(HEADER_READ_AS, message, hint, cell)
    while decided := [at for at, header in open_columns.items() if len(_left(header.roles, choice, settings)) == 1]:
        header = open_columns.pop(decided[0])
        role = _left(header.roles, choice, settings)[0]
        choice.serve(Chosen(decided[0], layout.cells[decided[0]], header, role))
    there = set(choice.used) | set(settings.roles)
    for at, header in open_columns.items():
        left, cell = _left(header.roles, choice, settings), layout.cells[at]
        if set(left) <= derived_roles(there) or not _may_be_needed(left, there):
            message = f'the column "{cell.text}" is not used: it fits {" and ".join(header.roles)}'
            faults.add(COLUMN_NOT_USED, message, "", cell)
            continue
        ways = {role: f'--map {role}="{cell.text}"' for role in left}
        if "time" in ways and "precession_period" in ways and there.isdisjoint(COUNTS):
            ways["time"] += " (with --set turns=…)"
        choice.asked.update(left)
        message = f'the header "{cell.text}" fits {" and ".join(left)}'
        faults.add(HEADER_FITS_TWO_ROLES, message, f"say which: {' or '.join(ways.values())}", cell)


_BY_UNIT = {
    "mass": ("mass", "force", "torque"),
    "position": ("position", "torque"),
    "spin": ("spin", "spin_start", "spin_end"),
    "time": TIMINGS,
}
"""What a column without a known name can be by its unit alone, if none of these roles is there."""
_OTHER_THINGS = NOT_THE_WEIGHT | THEORY_WORDS | UNSURE_WORDS | SUMMARY_WORDS


def _serve_by_unit(choice: Choice, layout: Layout, settings: Settings, faults: Faults) -> None:
    """Give a column without a known name the role that is missing, if no other column has such a unit."""
    there = set(choice.used) | set(settings.roles) | choice.asked
    for role, present in _BY_UNIT.items():
        kind = kind_of_role(role)
        headers = {cell: layout.headers[layout.cells.index(cell)] for cell in choice.unplaced}
        fit = [cell for cell, header in headers.items() if kind in kinds_of(header.unit or "")]
        if len(fit) != 1 or not there.isdisjoint(present) or (role == "time" and there.isdisjoint(COUNTS)):
            continue
        (cell,) = fit
        # "T/2 (s)", "Weight #1 (g)" and "σt (s)" say something else.
        if squeezed_words(cell.text) & _OTHER_THINGS or re.match(r"[^\[^]*[0-9]|[σε]\w", cell.text):
            continue
        choice.serve(Chosen(layout.cells.index(cell), cell, headers[cell], role))
        choice.unplaced.remove(cell)
        message = f'"{cell.text}" is read as the {role}, because no other column is {KINDS[kind].words}'
        faults.add(HEADER_READ_AS, message, f"if it is not, name the {role} with --map {role}=HEADER", cell)


def _is_one_turn(layout: Layout, choice: Choice, settings: Settings) -> bool:
    """Tell whether "T" can only be the time of one turn: no turns are counted, or each time covers one."""
    if {"time", "precession_period", "angle"} & set(choice.used) or {"turns", "angle"} & set(settings.roles):
        return False
    counts = choice.used.get("turns", [])
    return {text for row in layout.rows for one in counts for text in row.texts[one.at : one.at + 1]} <= {"", "1"}


def _left(roles: tuple[str, ...], choice: Choice, settings: Settings) -> list[str]:
    """Give the roles that a header may still serve."""
    there = set(choice.used) | set(settings.roles)
    if roles == ("time", "precession_period") and "time" in choice.used and there.isdisjoint(COUNTS):
        return []  # beside a time whose turns are not told, "T" may be the mean of such times as well
    # An uncertainty goes where its symbol went, "σ_T" with "T"; else to a role that has a column.
    bases = tuple(role.removeprefix("u_") for role in roles)
    same = [f"u_{used[0].role}" for used in choice.used.values() if bases != roles and used[0].header.roles == bases]
    if same and same[0] in roles:
        return same
    open_roles = [role for role in roles if role not in there and (role[:2] != "u_" or role[2:] in choice.used)]
    # Nobody needs a quantity that the readings give already, if the header can be another one.
    return [role for role in open_roles if role not in derived_roles(there)] or open_roles


def _may_be_needed(left: list[str], there: set[str]) -> bool:
    timing = not there.isdisjoint(ONE_TURN) or ("time" in there and not there.isdisjoint(COUNTS))
    served = {
        "spin": any(there.issuperset(roles) for roles in SPIN_SETS[:3]),
        "timing": timing,
        "count": timing,
        "load": "torque" in there or ("position" in there and not there.isdisjoint(("mass", "force"))),
    }
    return any(role.startswith("u_") or not served.get(BY_NAME[role].part, False) for role in left)


def note_unplaced(choice: Choice, faults: Faults) -> None:
    """Say which headers name nothing known."""
    if choice.unplaced:
        texts = [cell.text or f"(column {cell.column}, no header)" for cell in choice.unplaced]
        word = "column is" if len(texts) == 1 else "columns are"
        faults.add(
            HEADER_UNKNOWN, f"the {word} not used: {listing(texts)}", "if one is needed, name it with --map role=HEADER"
        )
