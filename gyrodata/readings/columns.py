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
from gyrodata.readings.headers import Header, is_of_the_spin, parse_header, split_unit, turns_in, unit_for
from gyrodata.readings.lablog import Faults, Text, listing
from gyrodata.readings.layout import Layout, is_of_means
from gyrodata.readings.roles import (
    BY_NAME,
    COUNTS,
    END_WORDS,
    NOT_THE_WEIGHT,
    ONE_TURN,
    SPIN_SETS,
    START_WORDS,
    SUMMARY_WORDS,
    THEORY_WORDS,
    TIMINGS,
    UNSURE_WORDS,
    derived_roles,
    kind_of_role,
    squeeze,
)
from gyrodata.readings.settings import Settings
from gyrodata.units import KINDS, UnitError, kinds_of, parse_unit


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
        present = self.used.get(chosen.role)
        if present is None and chosen.role != "inertia":
            self.used[chosen.role] = [chosen]
        elif (
            present is not None
            and chosen.number is not None
            and all(c.number is not None and c.number != chosen.number for c in present)
        ):
            present.append(chosen)
        else:
            self.others.append(chosen)


def choose(layout: Layout, mapping: Mapping[str, str], settings: Settings, faults: Faults) -> Choice:
    """Give each column its role."""
    choice = Choice()
    layout = replace(layout, headers=_without_time_that_went_by(layout.headers))
    mapped = _mapped(layout, mapping, faults)
    for chosen in mapped.values():
        choice.serve(chosen)
    open_columns: list[tuple[int, tuple[str, ...]]] = []
    stating: list[int] = []
    # A mean stands back behind the readings that it is made of, and a bare letter behind a name.
    for at, header in sorted(enumerate(layout.headers), key=lambda item: (is_of_means(item[1].text), _letter(item[1]))):
        if at in mapped or at in layout.combined:
            continue
        if _letter(header) and _numbers_rows(layout, at, header, choice):
            choice.serve(Chosen(at, layout.cells[at], header, "run"))
        elif _states_turns(header):
            stating.append(at)
        elif not header.roles:
            if layout.cells[at].text or any(len(row.texts) > at and row.texts[at] for row in layout.rows):
                choice.unplaced.append(layout.cells[at])
        elif len(header.roles) == 1:
            choice.serve(Chosen(at, layout.cells[at], header, header.roles[0], header.number))
        else:
            open_columns.append((at, header.roles))
    _serve_stated(layout, stating, choice, settings)
    _eliminate(layout, open_columns, choice, settings, faults)
    _serve_by_unit(choice, layout, settings, faults)
    _ask_about_laps(layout, choice, faults)
    choice.unplaced.sort(key=lambda cell: cell.column)
    for repeats in choice.used.values():
        repeats.sort(key=lambda chosen: chosen.number or 0)
    return choice


def _without_time_that_went_by(headers: list[Header]) -> list[Header]:
    """Read "ΔT" as the uncertainty of "T" only, where a column "T" is there as well."""
    plain = {squeeze(split_unit(header.text)[0]) for header in headers}
    return [
        replace(header, roles=tuple(role for role in header.roles if role[:2] == "u_"))
        if header.text[:1] in "Δ∆" and squeeze(split_unit(header.text)[0])[1:] in plain
        else header
        for header in headers
    ]


def _letter(header: Header) -> bool:
    """Know a bare "n", "m" or "count", which may number the runs."""
    return header.unit is None and (len(header.text) == 1 or header.text.lower() == "count")


def _numbers_rows(layout: Layout, at: int, header: Header, choice: Choice) -> bool:
    """Tell whether a column only counts the rows: 1, 2, 3, … where another says more, or where there are many."""
    texts = [row.texts[at] if at < len(row.texts) else "" for row in layout.rows]
    counts = texts == [str(number) for number in range(1, len(texts) + 1)]
    return counts and (len(texts) > 3 or not choice.used.keys().isdisjoint(header.roles))


def _states_turns(header: Header) -> bool:
    """Know "Time for 1/3 rev (s)": a time whose turns stand in its header."""
    timed = header.unit is not None and "time" in kinds_of(header.unit)
    return timed and header.roles in ((), ("time",), ("precession_period",)) and bool(turns_in(header.text))


def _serve_stated(layout: Layout, stating: list[int], choice: Choice, settings: Settings) -> None:
    """Take the times whose headers state their turns: of the precession, or of the ball's spin."""
    there = set(choice.used) | set(settings.roles)
    spins = any(there.issuperset(roles) for roles in SPIN_SETS)
    for at in stating:
        header, cell = layout.headers[at], layout.cells[at]
        turns = turns_in(header.text)
        if is_of_the_spin(header.text):
            words = {squeeze(word).lower() for word in header.text.split()}
            if words & (START_WORDS | END_WORDS) or "spin_time" in choice.used:
                choice.unplaced.append(cell)
            else:
                choice.serve(Chosen(at, cell, header, "spin_time", turns=turns))
        elif not spins and turns.isdigit() and int(turns) >= 5:
            choice.unplaced.append(cell)  # ten turns may be the ball's
        else:
            number = len(choice.used.get("time", [])) + 1
            if all(chosen.number is not None for chosen in choice.used.get("time", [])):
                choice.serve(Chosen(at, cell, header, "time", number, turns))
            else:
                choice.others.append(Chosen(at, cell, header, "time", number, turns))


def _ask_about_laps(layout: Layout, choice: Choice, faults: Faults) -> None:
    """Find times in the ratio 1 : 2 : 3 in every row: laps of one clock, and not repeats of one time."""
    spots = [chosen.at for chosen in choice.used.get("time", []) if chosen.number is not None and not chosen.turns]
    if not spots and choice.used.keys().isdisjoint(TIMINGS):
        units = [(cell, parse_header(cell.text).unit or unit_for(cell.text, "time") or "") for cell in choice.unplaced]
        timed = [cell for cell, unit in units if "time" in kinds_of(unit)]
        spots = [at for at, cell in enumerate(layout.cells) if cell in timed and not turns_in(cell.text)]
        if [re.findall(r"[0-9]+", layout.cells[at].text) for at in spots] != [[str(k)] for k, _ in enumerate(spots, 1)]:
            return
    try:
        rows = [[to_float(fold_number(row.texts[at])) for at in spots] for row in layout.rows]
    except (ValueError, IndexError):
        return
    if len(spots) < 2 or not all(
        abs(lap - k * row[0]) < 0.1 * k * row[0] for row in rows for k, lap in enumerate(row, 1)
    ):
        return
    first, *_, last = (layout.cells[at] for at in spots)
    ratio = " : ".join(str(k) for k, _ in enumerate(spots, 1))
    message = (
        f'"{first.text}" to "{last.text}" grow as {ratio} in every row: laps of one clock, not repeats of one time'
    )
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
        role, _, number = key.partition("_") if key.startswith("time_") else (key, "", "")
        header = layout.headers[at]
        if header.unit is None:
            header = replace(header, unit=unit_for(header.text, kind_of_role(role)))
        if header.unit is None and header.spread.partition(" ")[2]:
            header = replace(header, unit=header.spread.partition(" ")[2])
        if kind_of_role(role) == "text":
            header = replace(header, unit=None)
        index = int(number) if number else None
        found[at] = Chosen(at, layout.cells[at], header, role, index)
    return found


def _eliminate(
    layout: Layout,
    open_columns: list[tuple[int, tuple[str, ...]]],
    choice: Choice,
    settings: Settings,
    faults: Faults,
) -> None:
    """Decide headers of several roles where only one role is left; ask about the rest if they are needed."""
    numbered = [at for at, roles in open_columns if "spin_start" in roles or "spin_end" in roles]
    if len(numbered) == 2 and all(_counts_turns(layout.headers[at]) for at in numbered) and "spin" not in choice.used:
        # Rates in rpm numbered 0, 1 or 1, 2 are the spin before and after; in rad/s one may be the precession.
        for at, role in zip(
            sorted(numbered, key=lambda a: layout.cells[a].text), ("spin_start", "spin_end"), strict=True
        ):
            choice.serve(Chosen(at, layout.cells[at], layout.headers[at], role))
        shown = listing([layout.cells[at].text for at in numbered])
        faults.add(
            COLUMN_NOT_USED, f"{shown}: taken as the spin at the start and at the end", "if not, name them with --map"
        )
        open_columns = [(at, roles) for at, roles in open_columns if at not in numbered]
    for at, roles in list(open_columns):
        if roles == ("time", "precession_period") and _is_one_turn(layout, choice, settings):
            cell = layout.cells[at]
            choice.serve(Chosen(at, cell, layout.headers[at], "precession_period"))
            open_columns.remove((at, roles))
            message = f'"{cell.text}" is read as the time of one whole turn of the precession'
            hint = f'if it covers another number of turns: --map time="{cell.text}" --set turns=…'
            faults.add(HEADER_READ_AS, message, hint, cell)
    progress = True
    while progress and open_columns:
        progress = False
        for at, roles in list(open_columns):
            left = _left(roles, choice, settings)
            if len(left) == 1 and len(left) < len(roles):
                choice.serve(Chosen(at, layout.cells[at], layout.headers[at], left[0]))
                open_columns.remove((at, roles))
                progress = True
    roles_there = set(choice.used) | set(settings.roles)
    for at, roles in sorted(open_columns, key=lambda column: column[1] != _bases(column[1])):
        left = _left(roles, choice, settings)
        cell = layout.cells[at]
        if roles != _bases(roles) and choice.asked.intersection(_bases(roles)):
            continue  # it follows what is asked about
        if left and not set(left) <= derived_roles(roles_there) and _may_be_needed(left, roles_there):
            untold = roles_there.isdisjoint(COUNTS) and "precession_period" in left
            unsure = [layout.cells[k].text for k, other in open_columns if _bases(other) == roles != other]
            ways = " or ".join(
                f'--map {role}="{cell.text}"'
                + "".join(f' --map u_{role}="{text}"' for text in unsure)
                + (" (with --set turns=…)" if untold and role == "time" else "")
                for role in left
            )
            message = f'the header "{cell.text}" fits {" and ".join(left)}'
            choice.asked.update(left)
            faults.add(HEADER_FITS_TWO_ROLES, message, f"say which: {ways}", cell)
        else:
            message = f'the column "{cell.text}" is not used: it fits {" and ".join(roles)}'
            faults.add(COLUMN_NOT_USED, message, "", cell)


_BY_UNIT = ("mass", "position", "spin", "time")
"""What a column without a known name can be by its unit alone."""


def _serve_by_unit(choice: Choice, layout: Layout, settings: Settings, faults: Faults) -> None:
    """Give a column without a known name the role that is missing, if no other column has such a unit."""
    there = set(choice.used) | set(settings.roles) | choice.asked
    headers = [(cell, layout.headers[layout.cells.index(cell)]) for cell in choice.unplaced]
    for role in _BY_UNIT:
        kind = kind_of_role(role)
        part = [one for one in BY_NAME.values() if one.part == BY_NAME[role].part]
        if any(one.name in there and one.kind == kind for one in part) or (kind == "mass" and "force" in there):
            continue
        if not there.isdisjoint(ONE_TURN if role == "time" else ("torque",) if BY_NAME[role].part == "load" else ()):
            continue
        if role == "time" and not there.intersection(COUNTS):
            continue
        fit = [(cell, header) for cell, header in headers if header.unit and kind in kinds_of(header.unit)]
        words = {squeeze(word).lower() for cell, _ in fit for word in re.split(r"[\W_]+", cell.text)}
        if len(fit) != 1 or words & (NOT_THE_WEIGHT | THEORY_WORDS | UNSURE_WORDS | SUMMARY_WORDS):
            continue
        if any(letter.isdigit() for letter in fit[0][0].text.partition("[")[0].partition("^")[0]):
            continue  # "T/2 (s)" and "Weight #1 (g)" say something else
        cell, header = fit[0]
        choice.serve(Chosen(layout.cells.index(cell), cell, header, role))
        choice.unplaced.remove(cell)
        message = f'"{cell.text}" is read as the {role}, because no other column is {KINDS[kind].words}'
        faults.add(HEADER_READ_AS, message, f"if it is not, name the {role} with --map {role}=HEADER", cell)


def _is_one_turn(layout: Layout, choice: Choice, settings: Settings) -> bool:
    """Tell whether "T" can only be the time of one turn: no turns are counted, or each time covers one."""
    if {"time", "precession_period", "angle"} & set(choice.used) or {"turns", "angle"} & set(settings.roles):
        return False
    counts = choice.used.get("turns")
    texts = {row.texts[counts[0].at] for row in layout.rows if counts[0].at < len(row.texts)} if counts else set()
    return texts <= {"", "1"}


def _counts_turns(header: Header) -> bool:
    if header.unit is None:
        return False
    try:
        return parse_unit(header.unit, "rate").text in ("rpm", "rps", "Hz")
    except UnitError:
        return False


def _left(roles: tuple[str, ...], choice: Choice, settings: Settings) -> list[str]:
    """Give the roles that a header may still serve."""
    counted = (set(choice.used) | set(settings.roles)).intersection(COUNTS)
    if roles == ("time", "precession_period") and "time" in choice.used and not counted:
        return []  # beside a time whose turns are not told, "T" may be the mean of such times as well
    bases = _bases(roles)
    if bases != roles:
        # An uncertainty goes where its symbol went: "σ_T" with "T", whatever "T" turned out to be.
        same = [used[0].role for used in choice.used.values() if used[0].header.roles == bases]
        if same and f"u_{same[0]}" in roles:
            return [f"u_{same[0]}"]
    open_roles = [role for role in roles if not _is_served(role, choice, settings)]
    # Nobody needs a quantity that the readings give already, if the header can be another one.
    needed = [role for role in open_roles if role not in derived_roles(set(choice.used) | set(settings.roles))]
    return needed or open_roles


def _bases(roles: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(role.removeprefix("u_") for role in roles)


def _is_served(role: str, choice: Choice, settings: Settings) -> bool:
    base = role.removeprefix("u_")
    if role != base:
        # An uncertainty belongs to the role that its symbol has: "σ_T" goes where "T" went.
        return base not in choice.used or role in choice.used
    return role in choice.used or role in settings.roles


def _may_be_needed(left: list[str], there: set[str]) -> bool:
    timed = "time" in there and not there.isdisjoint(COUNTS)
    timing = timed or not there.isdisjoint(ONE_TURN)
    served = {
        "spin": "spin" in there or {"spin_start", "spin_end"} <= there or "spin_period" in there,
        "timing": timing,
        "count": timing,
        "load": "torque" in there or ("position" in there and bool(there & {"mass", "force"})),
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
