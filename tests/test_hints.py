"""Hints are promises: each is carried out to the letter on a log that raises it, and the truth must come out.

What a hint asks of the lab, another run or a new weighing, cannot be typed into a log: those codes are listed by name.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from test_slips import TRUTH, lab

import gyrodata
from gyrodata.diagnostics import CODES
from gyrodata.errors import Diagnostic, GyroError
from gyrodata.procedure import check_procedure
from gyrodata.readings import read_log

GOOD = lab().text().replace("# ball_mass: 4.3 kg\n# ball_diameter: 10.16 cm\n", "")
LINES = GOOD.splitlines()
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns"
ROW = LINES[4]
"""Third run: 20.1 g at 604 rpm."""
ROWS = [line.split(",") for line in LINES[2:]]


def headed(new: str) -> str:
    return GOOD.replace(HEAD, new)


def cell(at: int, change: Callable[[str], str]) -> str:
    """Change a cell of the third run."""
    cells = ROW.split(",")
    return GOOD.replace(ROW, ",".join([*cells[:at], change(cells[at]), *cells[at + 1 :]]))


def table(head: str, *cells: Callable[[list[str]], str]) -> str:
    """Write the runs in other columns."""
    return "\n".join([LINES[0], head, *(",".join(one(row) for one in cells) for row in ROWS)]) + "\n"


FIRST = [lambda row, i=i: row[i] for i in range(4)]
NO_TURNS = "mass [g],position [cm],spin [rpm],"


def period(row: list[str]) -> str:
    return f"{3 * float(row[3]):.2f}"


NEWTONS = [lambda row: f"{float(row[0]) * 9.803e-3:.5f}", *FIRST[1:], lambda row: row[4]]

CASES: list[tuple[str, str]] = [
    ("G203", cell(2, lambda text: "6O4")),
    ("G203", cell(3, lambda text: text.replace(".", ".."))),
    ("G203", cell(3, lambda text: f"0.{text}")),
    ("G203", cell(3, lambda text: "NaN")),
    ("G203", cell(3, lambda text: "#DIV/0!")),
    ("G204", cell(4, lambda text: "03.Jan")),
    ("G205", table(HEAD.replace("mass [g]", "Weight (N)"), *NEWTONS)),
    ("G206", headed(HEAD.replace("spin [rpm]", "spin"))),
    ("G207", table(f"{NO_TURNS}T [s]", *FIRST[:3], period)),
    ("G214", f"Task III\n{GOOD}"),
    ("G231", table(f"{NO_TURNS}t [s],T [s],turns", *FIRST[:3], period, FIRST[3], lambda row: row[4])),
    *(("G301", table(NO_TURNS + head, *FIRST)) for head in ("Time for 1/3 rev (s)", "t(1/3 rev) [s]", "⅓ of a turn (s)",
                                                            "T Ω(120°) (s)")),
    ("G301", headed(HEAD.replace("spin [rpm]", "phi_dot (rpm)"))),
    ("G301", headed("质量 (g),位置 (cm),转速 (rpm),时间 (s),圈")),
    ("G305", f"# u_tme: 0.2 s\n{GOOD}"),
    ("G404", GOOD.partition("\n")[2]),
    ("G407", GOOD.replace(",14.8,", ",15,")),
]  # fmt: skip
"""Code and log; the hint is that of the code's first diagnostic."""

IN_THE_LAB = {
    "G402", "G403", "G405", "G410", "G412", "G413", "G415", "G416", "G417", "G418", "G419", "G431", "G434", "G442",
    "G451", "G452", "G453", "G454", "G455", "G456", "G457",
}  # fmt: skip
"""Advice to look, to say what was done, to time again or to add runs: nothing that the log at hand tells."""

IN_OTHER_TESTS = {
    "G401": "tests/readings", "G406": "tests/test_measurements.py", "G411": "below", "G414": "tests/test_analysis.py",
    "G420": "tests/test_guard.py", "G421": "tests/test_guard.py", "G432": "below", "G433": "tests/test_analysis.py",
    "G435": "below", "G440": "tests/test_slips.py", "G441": "tests/test_slips.py", "G443": "tests/test_slips.py",
}  # fmt: skip
"""Where the other hints are carried out."""


def found_in(log: str, **options: Any) -> list[Diagnostic]:
    try:
        readings = read_log(log.encode(), **options)
        found = list(readings.diagnostics)
        if not any(d.severity == "error" for d in found):
            found += check_procedure(readings)
    except GyroError as error:
        found = list(error.diagnostics)
    return found


def carry_out(log: str, told: Diagnostic) -> tuple[str, dict[str, Any]]:
    """Do what the hint says first, as a student would who reads no further."""
    lines, hint = log.splitlines(), told.hint
    at, start = (told.line or 1) - 1, (told.column or 1) - 1
    wrong = lines[at][start : start + told.width]

    def put(text: str) -> str:
        lines[at] = lines[at][:start] + text + lines[at][start + told.width :]
        return "\n".join(lines) + "\n"

    if copied := re.search(r"the header line to copy:\n(.*)\n", hint):
        return log.replace(next(line for line in lines if line[0] != "#"), copied[1]), {}
    if pairs := re.findall(r'--map (\w+)="([^"]+)"', hint.partition(" or --map")[0]):
        stated = re.search(r'--set (\w+)="?([^"?…]+)"?\?', hint)
        # A time that fits a whole period as well: the student did time one turn here, as the other way says.
        other = re.search(r'or --map (precession_period)="([^"]+)"', hint)
        return log, {
            "mapping": dict([other.groups()] if other else pairs),
            "settings": dict([stated.groups()] if stated else []),
        }
    if line := re.search(r'did you mean "(# [^"]+)"', hint):
        return put(line[1]) if wrong.startswith("#") else log.replace(lines[at], line[1]), {}
    if meant := re.search(r"did you mean ([^\s?]+)\?|write it as ([\d:.]+\d)", hint):
        return put(meant[1] or meant[2]), {}
    if longer := re.search(r"such as ([\d.]+),", hint):
        return log.replace(f",{wrong},", f",{longer[1]},"), {}
    if header := re.search(r'write the header as "([^"]+)"', hint):
        return put(header[1]), {}
    if stated := re.search(r"(# \w+: [^,\n]+)", hint):
        return f"{stated[1]}\n{log}", {}
    assert re.search("put (a )?# before the line", hint), hint
    lines[at] = f"# {lines[at]}"
    return "\n".join(lines) + "\n", {}


@pytest.mark.parametrize(("code", "log"), CASES, ids=[f"{code}-{k}" for k, (code, _) in enumerate(CASES)])
def test_a_hint_obeyed_to_the_letter_gives_the_truth(code: str, log: str) -> None:
    told = [d for d in found_in(log) if d.code == code]
    if not told:
        # The reader understands it by itself.
        mended, options = log, {}
    else:
        mended, options = carry_out(log, told[0])
    assert [d for d in found_in(mended, **options) if d.code == code or d.severity == "error"] == []
    found = gyrodata.analyze(mended.encode(), **options).inertia
    assert abs(found.value - TRUTH) < (4 if code != "G407" else 6) * (found.u or 0.0)
    assert (found.u or 0.0) < 0.03 * TRUTH


def test_a_wider_time_ends_the_quarrel_of_the_runs() -> None:
    log = f"# u_time: 0.01 s\n# u_angle: 0 deg\n# u_spin: 0.01 %\n{GOOD}"
    before = gyrodata.analyze(log.encode())
    told = next(d for d in before.diagnostics if d.code == "G411")
    stated = re.search(r"# u_time: [\d.]+ s", told.hint)
    assert stated
    after = gyrodata.analyze(log.replace("# u_time: 0.01 s", stated[0]).encode())
    assert "G411" not in [d.code for d in after.diagnostics]
    assert [doubt.kind for doubt in before.doubts] == ["scatter"]
    assert before.advice[0].startswith("find the cause first: ")
    assert after.doubts == ()
    assert abs(after.inertia.value - TRUTH) < 4 * (after.inertia.u or 0.0)


@pytest.mark.parametrize(("code", "stated"), [("G432", "0.6 s"), ("G435", "100 s")])
def test_the_uncertainty_that_is_named_is_the_one_to_state(code: str, stated: str) -> None:
    try:
        found = gyrodata.analyze(f"# u_time: {stated}\n{GOOD}".encode()).diagnostics
    except GyroError as error:
        found = error.diagnostics
    assert "u_time" in next(d for d in found if d.code == code).hint
    after = gyrodata.analyze(f"# u_time: 0.1 s\n{GOOD}".encode())
    assert code not in [d.code for d in after.diagnostics]
    assert abs(after.inertia.value - TRUTH) < 4 * (after.inertia.u or 0.0)


def test_every_hint_of_what_the_runs_say_is_carried_out_or_asks_for_the_lab() -> None:
    carried = {code for code, _ in CASES} | IN_THE_LAB | set(IN_OTHER_TESTS)
    assert carried <= set(CODES)
    assert {code for code in CODES if code.startswith("G4")} <= carried
