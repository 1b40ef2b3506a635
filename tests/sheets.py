"""Logs as students type them: habits of typing, each laid over a lab of a known truth.

A habit takes the runs of a lab and gives the text of a CSV file, or the sheets of a workbook. What must happen to it
stands beside it: it is read, or it is refused and the remedy is right. Nothing is stored; every log is made anew.
"""

from __future__ import annotations

import datetime
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

INERTIA = 4.44e-3
IMBALANCE = 0.4e-3
G = 9.803
ARM = 0.148
RADIUS = 0.0508
MASSES, SPINS = ("20.1", "40.3", "60.2"), (212, 398, 604)


class Run(NamedTuple):
    mass: str
    position: str
    spin: str
    time: str
    turns: str


Cells = list[Any]
"""Rows of cells."""
Made = str | bytes | dict[str, Cells]


class Habit(NamedTuple):
    name: str
    make: Callable[[list[Run]], Made]
    settings: Mapping[str, str] = MappingProxyType({})
    """The remedy: what the message says to give with --set."""
    mapping: Mapping[str, str] = MappingProxyType({})
    """The remedy: what the message says to give with --map."""
    edit: tuple[str, str] | None = None
    """The remedy: what the message says to change in the file."""
    says: str = ""
    """What the message or the note must hold."""
    turns: tuple[str, str, str] = ("1/3", "1/3", "1")
    unloaded: bool = False
    """Whether there is a run without a weight."""

    @property
    def asked(self) -> bool:
        return bool(self.settings or self.mapping or self.edit)


def lab(seed: int, turns: tuple[str, str, str] = ("1/3", "1/3", "1"), unloaded: bool = False) -> list[Run]:
    """Draw one lab as it is read off: three weights with three spins, timed by hand."""
    random = np.random.default_rng(7000 + seed)
    runs = []
    for mass, count in zip(MASSES, turns, strict=True):
        for spin in SPINS:
            torque = float(mass) / 1000 * G * ARM + IMBALANCE
            exact = 2 * np.pi * float(Fraction(count)) * INERTIA * spin * np.pi / 30 / torque
            runs.append(Run(mass, "14.8", str(spin), f"{exact + 0.14 * random.standard_normal():.2f}", count))
    if unloaded:
        exact = 2 * np.pi / 12 * INERTIA * 398 * np.pi / 30 / IMBALANCE
        runs.append(Run("0", "", "398", f"{exact:.2f}", "1/12"))
    return runs


def workbook(sheets: dict[str, Cells], merges: tuple[str, ...] = ()) -> bytes:
    import openpyxl

    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, cells in sheets.items():
        sheet = book.create_sheet(title)
        for row in cells:
            sheet.append(row)
        for merge in merges:
            sheet.merge_cells(merge)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def text_of(cells: Cells, delimiter: str = ",") -> str:
    def cell(value: Any) -> str:
        text = "" if value is None else str(value)
        return '"' + text.replace('"', '""') + '"' if delimiter in text or '"' in text else text

    return "".join(delimiter.join(map(cell, row)) + "\n" for row in cells)


def number(text: str) -> Any:
    """Give a number as a spreadsheet holds it; a fraction stays a text."""
    if not text:
        return None
    return text if "/" in text else float(text) if "." in text else int(text)


def source(made: Made) -> bytes:
    if isinstance(made, dict):
        return workbook(made)
    return made if isinstance(made, bytes) else made.encode()


HEAD = ["Mass (g)", "Position (cm)", "Spin (rpm)", "Time (s)", "Turns"]


def rows(runs: list[Run], head: list[str] | None = None) -> Cells:
    return [list(head or HEAD), *(list(run) for run in runs)]


def typed(cells: Cells) -> Cells:
    """Give cells as a workbook holds them: numbers as numbers."""
    return [[number(c) if isinstance(c, str) and is_plain(c) else c or None for c in row] for row in cells]


def is_plain(text: str) -> bool:
    return bool(text) and text.replace(".", "", 1).isdigit()


def by_mass(runs: list[Run]) -> dict[str, list[Run]]:
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.mass, []).append(run)
    return groups


class Language(NamedTuple):
    head: list[str]
    title: str
    mean: str
    weight: str
    note: str
    comma: bool = True


LANGUAGES = {
    "en": Language(HEAD, "Lab 4: Gyroscope", "Average", "Weight", "The ball was polished before we began", False),
    "de": Language(["Masse (g)", "Abstand (cm)", "Drehzahl (U/min)", "Zeit (s)", "Umdrehungen"],
        "Versuch 4: Der Kreisel", "Mittelwert", "Gewicht", "Die Kugel wurde vorher geputzt"),
    "fr": Language(["Masse (g)", "Distance au centre (cm)", "Vitesse de rotation (tr/min)", "Temps (s)",
        "Nombre de tours"], "TP 4 : le gyroscope", "Moyenne", "Masse", "La boule a été nettoyée avant"),
    "ru": Language(["Масса (г)", "Расстояние (см)", "Скорость вращения (об/мин)", "Время (с)", "Обороты"],
        "Работа 4: гироскоп", "Среднее", "Груз", "Шар протёрли перед опытом"),
    "es": Language(["Masa (g)", "Distancia al centro (cm)", "Velocidad de giro (rpm)", "Tiempo (s)", "Vueltas"],
        "Práctica 4: el giroscopio", "Promedio", "Masa", "Limpiamos la bola antes de empezar"),
    "pl": Language(["Masa (g)", "Ramię (cm)", "Prędkość obrotowa (obr/min)", "Czas (s)", "Liczba obrotów"],
        "Ćwiczenie 4: żyroskop", "Średnia", "Masa", "Kula została wyczyszczona"),
    "pt": Language(["Massa (g)", "Braço (cm)", "Velocidade de rotação (rpm)", "Tempo (s)", "Voltas"],
        "Prática 4: o giroscópio", "Média", "Massa", "A bola foi limpa antes"),
    "zh": Language(["质量 (g)", "位置 (cm)", "转速 (rpm)", "时间 (s)", "圈数"],
        "实验四：陀螺仪", "平均值", "砝码", "实验前擦拭了球", False),
}  # fmt: skip


def _language_habits() -> list[Habit]:
    def plain(words: Language, runs: list[Run]) -> str:
        return text_of(rows(runs, words.head))

    def local(words: Language, runs: list[Run]) -> str:
        sign, delimiter = (",", ";") if words.comma else (".", "\t")
        cells = [[cell.replace(".", sign) for cell in run] for run in runs]
        return "\ufeff" + text_of([words.head, *cells], delimiter)

    def titled(words: Language, runs: list[Run]) -> Made:
        mean = round(sum(float(run.time) for run in runs) / len(runs), 3)
        body = typed(rows(runs, words.head))
        return {"Tabelle1": [[words.title], [], *body, [words.mean, None, None, mean, None], [], [words.note]]}

    def captioned(words: Language, runs: list[Run]) -> Made:
        cells: Cells = [[words.title]]
        for i, (mass, group) in enumerate(by_mass(runs).items(), 1):
            cells += [[f"{words.weight} {i}: {mass} g"], *typed([words.head[1:], *(run[1:] for run in group)]), []]
        return {"Sheet1": cells}

    def sheets(words: Language, runs: list[Run]) -> Made:
        groups = by_mass(runs).items()
        return {f"{mass} g": typed([words.head[1:], *(run[1:] for run in group)]) for mass, group in groups}

    ways = {
        "plain": plain, "decimal sign of the country, BOM": local, "xlsx with title, mean and note": titled,
        "xlsx, one table a weight": captioned, "xlsx, one sheet a weight": sheets,
    }  # fmt: skip
    return [
        Habit(f"{code}: {way}", partial(make, words)) for code, words in LANGUAGES.items() for way, make in ways.items()
    ]


def _table(
    head: Sequence[Any] = HEAD,
    row: Callable[[Run], Iterable[Any]] = list,
    above: Sequence[list[Any]] = (),
    below: Sequence[list[Any]] = (),
) -> Callable[[list[Run]], Made]:
    """Make one table with its own header, cells, and rows above and below."""
    return lambda runs: text_of([*above, head, *map(row, runs), *below])


def _column(at: int, header: str) -> Callable[[list[Run]], Made]:
    """Make the usual table with one other header."""
    return _table([*HEAD[:at], header, *HEAD[at + 1 :]])


def _without_turns(header: str) -> Callable[[list[Run]], Made]:
    return _table([*HEAD[:3], header], lambda run: run[:4])


def _sheet(change: Callable[[list[Run]], Cells], *merges: str) -> Callable[[list[Run]], Made]:
    """Make a workbook of one sheet."""
    return lambda runs: workbook({"Sheet1": typed(change(runs))}, merges)


def _blocks(
    caption: Callable[[int, str], list[Any]],
    keep: slice = slice(1, 5),
    repeat: bool = True,
    after: Callable[[list[Run]], Cells] = lambda group: [],
) -> Callable[[list[Run]], Cells]:
    """Lay one table for each weight below the other, each with its caption."""

    def make(runs: list[Run]) -> Cells:
        cells: Cells = []
        for i, (mass, group) in enumerate(by_mass(runs).items(), 1):
            head = [HEAD[keep]] if repeat or i == 1 else []
            first = [*head, caption(i, mass)] if not repeat else [caption(i, mass), *head]
            cells += [*first, *(list(run[keep]) for run in group), *after(group)]
        return cells

    return make


def _trials(count: int, head: list[str], mean: str = "", first: bool = False) -> Callable[[list[Run]], Cells]:
    """Lay repeats beside each other: the time, and readings 0.1 s around it."""

    def make(runs: list[Run]) -> Cells:
        cells: Cells = [[*HEAD[:3], *([mean] if mean and first else []), *head]]
        cells[0] += [mean] if mean and not first else []
        cells[0].append("Turns")
        for run in runs:
            times = [float(run.time) + shift for shift in (0.0, 0.11, -0.09)[:count]]
            average = [f"{sum(times) / count:.3f}"] if mean else []
            shown = [f"{time:.2f}" for time in times]
            cells.append([*run[:3], *(average if first else []), *shown, *([] if first else average), run.turns])
        return cells

    return make


def _csv(cells: Callable[[list[Run]], Cells], delimiter: str = ",") -> Callable[[list[Run]], Made]:
    return lambda runs: text_of(cells(runs), delimiter)


def _merged(columns: str) -> Callable[[list[Run]], Made]:
    """Merge the cells of the weight, and others, down each block of three runs."""

    def make(runs: list[Run]) -> Made:
        cells = typed(rows(runs))
        merges = []
        for first in range(1, len(runs), 3):
            for letter in columns:
                for at in range(first + 1, first + 3):
                    cells[at]["ABCDE".index(letter)] = None
                merges.append(f"{letter}{first + 1}:{letter}{first + 3}")
        return workbook({"Sheet1": cells}, tuple(merges))

    return make


def _date(text: str) -> datetime.datetime:
    """Give what a spreadsheet makes of 1/3 where the month comes first."""
    month, _, day = text.partition("/")
    return datetime.datetime(2026, int(month), int(day or 1))


def _dated(written: dict[str, str]) -> Callable[[list[Run]], Made]:
    return _table(row=lambda run: run._replace(turns=written.get(run.turns, run.turns)))


def _cells_side_by_side(runs: list[Run]) -> Cells:
    groups = list(by_mass(runs).values())
    cells: Cells = [[*HEAD, "", *HEAD, "", *HEAD]]
    return typed(cells + [[*a, "", *b, "", *c] for a, b, c in zip(*groups, strict=True)])


def _mean_row(runs: list[Run]) -> Made:
    mean = sum(float(run.time) for run in runs) / len(runs)
    return text_of([*rows(runs), [], ["", "", "404.67", f"{mean:.3f}", ""]])


def _series(runs: list[Run]) -> Made:
    head = ["Time (s)", "Gyroscope x (rad/s)", "Gyroscope y (rad/s)", "Gyroscope z (rad/s)"]
    return text_of([head, *([f"{k * 0.01:.2f}", "0.01", "-0.02", f"{22.2 - k * 1e-4:.4f}"] for k in range(200))])


def _spin_of_ten(run: Run) -> list[Any]:
    return [run.mass, run.position, f"{600 / float(run.spin):.3f}", run.time, run.turns]


def _surface(run: Run) -> list[Any]:
    return [run.mass, f"{100 * (ARM - RADIUS):.2f}", *run[2:]]


def _tip(run: Run) -> list[Any]:
    return [run.mass, f"{25.0 - 100 * ARM:.1f}", *run[2:]]


_HALVES = ("1/2", "1/2", "1")
_THIRDS = ("1/3", "2/3", "1")
_SAME = ("1/3", "1/3", "1/3")
_FROM_SURFACE = ["Mass (g)", "Distance from ball surface (cm)", *HEAD[2:]]
_BALL = {"ball_diameter": "10.16 cm"}

HABITS: list[Habit] = [
    *_language_habits(),
    # what states itself
    *(
        Habit(f"header: {header}", _without_turns(header), turns=turns)
        for header, turns in (
            ("Time for 1/3 rev (s)", _SAME),
            ("t(1/3 rev) [s]", _SAME),
            ("Time for 2/3 turn (s)", ("2/3",) * 3),
            ("Time for one revolution (s)", ("1",) * 3),
            ("Time for a full turn (s)", ("1",) * 3),
            ("time of half a revolution (s)", ("1/2",) * 3),
            ("Time for ⅓ turn (s)", _SAME),
            ("Time for 120° (s)", _SAME),
            ("Time for 1/3 of a revolution (s)", _SAME),
            ("Time one third of a turn (s)", _SAME),
            ("t_1/3 (s)", _SAME),
            ("Zeit für 1/3 Umdrehung (s)", _SAME),
            ("Temps pour 1/3 de tour (s)", _SAME),
            ("Время 1/3 оборота (с)", _SAME),
        )
    ),
    Habit("turns became dates, d-mmm", _dated({"1/3": "3-Jan", "2/3": "3-Feb"}), turns=_THIRDS),
    Habit("turns became dates, German", _dated({"1/3": "01. Mrz", "2/3": "02. Mrz"}), turns=_THIRDS),
    Habit("turns became dates, 03.Jan", _dated({"1/3": "03.Jan", "2/3": "03.Feb"}), turns=_THIRDS),
    Habit("turns became dates, Jan-03", _dated({"1/3": "Jan-03", "2/3": "Feb-03"}), turns=_THIRDS),
    Habit("xlsx, turns became dates",
        lambda runs: workbook({"Sheet1": [HEAD,
        *([*typed([list(r[:4])])[0], _date(r.turns) if "/" in r.turns else 1] for r in runs)]}), turns=_THIRDS),
    Habit("turns in words", _dated({"1/3": "one third", "2/3": "two thirds", "1": "full"}), turns=_THIRDS),
    Habit("turns with the word behind", _table(row=lambda run: run._replace(turns=f"{run.turns} rev")), turns=_THIRDS),
    Habit("turns as ⅓", _dated({"1/3": "⅓", "2/3": "⅔"}), turns=_THIRDS),
    Habit("turns in degrees", _dated({"1/3": "120°", "2/3": "240°", "1": "360°"}), turns=_THIRDS),
    Habit("turns 0.33", _dated({"1/3": "0.33", "2/3": "0.67"}), turns=_THIRDS, says="1/3"),
    Habit("turns 0.66", _dated({"1/3": "0.33", "2/3": "0.66"}), turns=_THIRDS, says="2/3"),
    Habit("turns 0.3", _dated({"1/3": "0.3", "2/3": "0.7"}), turns=_THIRDS, says="1/3"),
    Habit("turns 0.333", _dated({"1/3": "0.333", "2/3": "0.667"}), turns=_THIRDS),
    Habit("turns 0.5", _dated({"1/2": "0.5"}), turns=_HALVES),
    # the sheet as a spreadsheet makes it
    Habit("two title rows and names", _table(above=[["Lab 4"], ["Anna, Ben", "", "", "Section 3"], []])),
    Habit("title with the date", _table(above=[["Gyroscope lab", "", "", "12 March"]])),
    Habit("title with delimiters behind", _table(above=[["Lab 4", "", "", "", ""]])),
    Habit("Numbers export", _table(above=[["Table 1", "", "", "", ""]])),
    Habit("units in the second row",
        lambda runs: text_of([["Mass", "Position", "Spin", "Time", "Turns"], ["g", "cm", "rpm", "s", ""],
        *map(list, runs)])),
    Habit("units in brackets in the second row",
        lambda runs: text_of([["Mass", "Position", "Spin", "Time", "Turns"], ["(g)", "(cm)", "(rpm)", "(s)", ""],
        *map(list, runs)])),
    *(Habit(f"summary row {word}", _table(below=[[word, "14.8", "404.67", "10.98", ""]])) for word in ("Average",
        "Mean", "Mittelwert", "σ", "St. dev.", "Total")),
    Habit("mean and deviation below", _table(below=[["Mean", "", "404.7", "10.98"], ["Std dev", "", "170", "6.1"]])),
    Habit("note below", _table(below=[["Note: run 4 was a bit late"]])),
    Habit("blank rows and notes below", _table(below=[[], ["Notes"], ["the stopwatch belongs to Ben"]])),
    Habit("note in the third column", _table(below=[["", "", "tachometer held by hand"]])),
    Habit("results below",
        _table(below=[[], ["Results"], ["Mass (g)", "I_zz (kg m^2)"], ["20.1", "0.00441"], ["40.3", "0.00446"]])),
    Habit("table a weight, header again", _csv(_blocks(lambda i, m: [f"Weight {i}: {m} g"]))),
    Habit("table a weight, header once", _csv(_blocks(lambda i, m: [f"Weight {i}: {m} g"], repeat=False))),
    Habit("table a weight with its arm",
        _csv(_blocks(lambda i, m: [f"Weight {i}: {m} g at 14.8 cm"], slice(2, 5)))),
    Habit("m = in the caption", _csv(_blocks(lambda i, m: [f"m = {m} g, x = 14.8 cm"], slice(2, 5)))),
    Habit("caption in two cells", _csv(_blocks(lambda i, m: ["Mass:", f"{m} g"]))),
    Habit("caption in three cells", _csv(_blocks(lambda i, m: ["Mass", m, "g"]))),
    Habit("caption with its unit in brackets", _csv(_blocks(lambda i, m: ["Mass (g)", m]))),
    Habit("table a weight, mean below each",
        _csv(_blocks(lambda i, m: [f"{m} g"], after=lambda group: [["Average", "", "9.99"], []]))),
    Habit("whole tables below each other", _csv(_blocks(lambda i, m: [f"Part {i}"], slice(0, 5)))),
    Habit("header repeated without captions", _csv(lambda runs: [*rows(runs[:6]), [], *rows(runs[6:])])),
    Habit("columns in another order in the second table",
        _csv(lambda runs: [*rows(runs[:6]), HEAD[::-1], *(list(run)[::-1] for run in runs[6:])])),
    Habit("whole tables side by side", _csv(_cells_side_by_side)),
    Habit("xlsx, mass merged", _merged("A")),
    Habit("xlsx, mass, arm and turns merged", _merged("ABE")),
    Habit("xlsx with an empty first row and column", _sheet(lambda runs: [[], *([None, *r] for r in rows(runs))])),
    Habit("xlsx, results on a second sheet",
        lambda runs: workbook({"Data": typed(rows(runs)),
        "Analysis": [["Mass (g)", "I_zz (kg m^2)"], [20.1, 0.0044], [40.3, 0.0045]]})),
    Habit("xlsx, a copy on a second sheet",
        lambda runs: workbook({"Raw": typed(rows(runs)), "Copy": typed(rows(runs))})),
    Habit("xlsx, notes on a second sheet",
        lambda runs: workbook({"Sheet1": typed(rows(runs)), "Sheet2": [["remember to ask for the scale"]]})),
    Habit("xlsx, whole tables on two sheets",
        lambda runs: workbook({"Monday": typed(rows(runs[:5])), "Tuesday": typed(rows(runs[5:]))})),
    Habit("xlsx, three trials", _sheet(_trials(3, ["Trial 1 (s)", "Trial 2 (s)", "Trial 3 (s)"]))),
    Habit("xlsx, three trials and their mean",
        _sheet(_trials(3, ["t1 (s)", "t2 (s)", "t3 (s)"], "Average time (s)"))),
    Habit("mean before the trials", _csv(_trials(2, ["Trial 1 (s)", "Trial 2 (s)"], "Average time (s)", True))),
    Habit("trials named time", _csv(_trials(3, ["Time 1 (s)", "Time 2 (s)", "Time 3 (s)"], "Mean (s)"))),
    Habit("trials in German", _csv(_trials(3, ["1. Messung (s)", "2. Messung (s)", "3. Messung (s)"]))),
    Habit("xlsx, time merged over 1, 2, 3",
        _sheet(lambda runs: [["Mass (g)", "Position (cm)", "Spin (rpm)", "Time (s)", "", "", "Turns"],
        ["", "", "", "1", "2", "3", ""], *_trials(3, ["1", "2", "3"])(runs)[1:]], "D1:F1")),
    Habit("spin merged over before and after",
        lambda runs: text_of([["Mass (g)", "Position (cm)", "Spin (rpm)", "", "Time (s)", "Turns"],
        ["", "", "before", "after", "", ""],
        *([r.mass, r.position, str(int(r.spin) + 1), str(int(r.spin) - 1), *r[3:]] for r in runs)])),
    Habit("two equal weights",
        _table(row=lambda run: run._replace(mass="2 x 10.05 g" if run.mass == "20.1" else run.mass))),
    Habit("a thousand, quoted", lambda runs: text_of(rows(runs)).replace(",604,", ',"1,015",'),
        edit=('"1,015"', "604")),
    Habit("weights that are none", lambda runs: text_of(rows(runs)).replace("\n0,", "\nnone,"), unloaded=True),
    Habit("no weight in words", lambda runs: text_of(rows(runs)).replace("\n0,", "\nno weight,"), unloaded=True),
    Habit("xlsx, numbers as text", lambda runs: workbook({"Sheet1": rows(runs)})),
    Habit("xlsx, times as times of the day",
        lambda runs: workbook({"Sheet1": [HEAD,
        *([*typed([list(r[:3])])[0], datetime.timedelta(seconds=float(r.time)), number(r.turns)] for r in runs)]})),
    Habit("xlsx, worked out beside",
        _sheet(lambda runs: [[*HEAD, "Period (s)", "Torque (N m)"],
        *([*r, f"{float(r.time) / float(Fraction(r.turns)):.2f}",
        f"{float(r.mass) / 1000 * G * ARM:.4f}"] for r in runs)])),
    Habit("xlsx, means of each weight below it",
        _sheet(_blocks(lambda i, m: [f"Weight {i}", f"{m} g"], after=lambda group: [["Mean", "", "9.99"], []]))),
    Habit("xlsx, trials below each other, merged",
        lambda runs: workbook({"Sheet1": typed([["Mass (g)", "Position (cm)", "Spin (rpm)", "Trial", "Time (s)",
        "Turns"],
        *([*(r[:3] if k == 0 else ("", "", "")), str(k + 1), f"{float(r.time) + 0.1 * k:.2f}",
        r.turns] for r in runs for k in range(2))])})),
    Habit("xlsx, tables side by side", lambda runs: workbook({"S": _cells_side_by_side(runs)})),
    Habit("xlsx, means on a second sheet",
        lambda runs: workbook({"Data": typed(rows(runs)),
        "Averages": typed(rows([Run(m, "14.8", "404", "9.99", g[0].turns) for m, g in by_mass(runs).items()]))})),
    Habit("xlsx, values above the table",
        _sheet(lambda runs: [["Position (cm)", "14.8"], [], [HEAD[0], *HEAD[2:]], *([r[0], *r[2:]] for r in runs)])),
    Habit("a dash for no weight", lambda runs: text_of(rows(runs)).replace("\n0,", "\n-,"), unloaded=True),
    Habit("means without a name", _mean_row),
    Habit("the arm changes on the way",
        _csv(lambda runs: [[HEAD[0], *HEAD[2:]], ["x = 14.8 cm"], *([r[0], *r[2:]] for r in runs)])),
    # what looks like an answer and is none
    Habit("a ball in the title",
        lambda runs: text_of([["Ball: 4.3 kg, diameter 10.16 cm"], HEAD[1:], *(list(run[1:]) for run in runs[:3])]),
        settings={"mass": "20.1 g"}, says="--set mass"),
    Habit("a rod in the title",
        lambda runs: text_of([["Rod length 30.0 cm"], [HEAD[0], *HEAD[2:]], *([r[0], *r[2:]] for r in runs)]),
        settings={"position": "14.8 cm"}, says="--set position"),
    Habit("two weights in one caption",
        lambda runs: text_of([["Weights 20.1 g and 40.3 g"], HEAD[1:], *(list(run[1:]) for run in runs[:3])]),
        settings={"mass": "20.1 g"}, says="--set mass"),
    Habit("a caption that forgets its weight",
        _csv(_blocks(lambda i, m: [f"Weight {i}: {m} g" if i != 2 else "Weight 2"])),
        edit=("Weight 2", "Weight 2: 40.3 g"), says="mass"),
    Habit("means of times among the runs",
        _csv(lambda runs: [*rows(runs[:3]), ["", "", "", "9.99"], *(list(r) for r in runs[3:])]),
        edit=(",,,9.99", "#,,,9.99"), says="spin is blank"),
    # words for cells and headers
    Habit("about 398", _table(row=lambda run: run._replace(spin=f"~{run.spin}")), edit=("~", "")),
    Habit("units in the cells",
        _table(HEAD, lambda r: [f"{r.mass} g", f"{r.position} cm", f"{r.spin} rpm", f"{r.time} s", r.turns])),
    Habit("header: Turn", _column(4, "Turn")),
    Habit("header: # of turns", _column(4, "# of turns")),
    Habit("header: Fraction of revolution", _column(4, "Fraction of revolution")),
    Habit("header: Position on rod", _column(1, "Position on rod (cm)")),
    Habit("header: Distance from ball center", _column(1, "Distance from ball center (cm)")),
    Habit("header: Mass used", _column(0, "Mass used (g)")),
    Habit("header: Avg RPM", _column(2, "Avg RPM")),
    Habit("header: Tach", _column(2, "Tach (rpm)")),
    Habit("RPM before and after",
        _table([*HEAD[:2], "RPM before", "RPM after", *HEAD[3:]],
        lambda r: [*r[:2], int(r.spin) + 1, int(r.spin) - 1, *r[3:]])),
    Habit("time of ten rotations",
        _table([*HEAD[:2], "Time for 10 rotations of the ball (s)", *HEAD[3:]], _spin_of_ten)),
    Habit("spin_time and spin_turns",
        _table(["mass [g]", "position [cm]", "spin_time [s]", "spin_turns", "time [s]", "turns"],
        lambda r: [*_spin_of_ten(r)[:3], 10, *r[3:]])),
    # the origin of a position
    Habit("from the surface, stated",
        lambda runs: "# position_from: surface\n# ball_diameter: 10.16 cm\n" + text_of([HEAD, *map(_surface, runs)])),
    Habit("from the surface, in the header", lambda runs: text_of([_FROM_SURFACE, *map(_surface, runs)]),
        settings=_BALL, says="ball_diameter"),
    Habit("from the tip, stated",
        lambda runs: "# position_from: tip\n# rod_length: 25.0 cm\n" + text_of([HEAD, *map(_tip, runs)])),
    Habit("from the tip, in the header",
        lambda runs: text_of([["Mass (g)", "Distance from tip (cm)", *HEAD[2:]], *map(_tip, runs)]),
        settings={"rod_length": "25.0 cm"}, says="rod_length"),
    # what cannot be known is asked
    Habit("no turns", _without_turns("Time (s)"), settings={"turns": "1/3"}, says="turns", turns=_SAME),
    Habit("no units", _column(2, "Spin"), edit=("Spin", "Spin [rpm]"), says="Spin [rpm]"),
    Habit("a weight in a title only",
        lambda runs: text_of([["Lab 4"], HEAD[1:], *(list(run[1:]) for run in runs[:3])]),
        settings={"mass": "20.1 g"}, says="--set mass"),
    Habit("a letter for a digit", lambda runs: text_of(rows(runs)).replace("604", "6O4", 1), edit=("6O4", "604"),
        says="604"),
    Habit("a dotted clock", lambda runs: text_of(rows(runs)).replace(runs[0].time, "0.0" + runs[0].time, 1),
        edit=(",0.0", ",0:0")),
    Habit("a forgotten spin", lambda runs: text_of(rows(runs)).replace("20.1,14.8,604", "20.1,14.8,"),
        edit=("20.1,14.8,,", "20.1,14.8,604,")),
]  # fmt: skip
