"""Hints are promises: each is carried out to the letter on a log that raises it, and
the truth must come out.

What a hint asks of the lab, another run or a new weighing, cannot be typed into a log:
those codes are listed by name."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from judging.test_wrong_units_and_counts import TRUTH, lab
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import Diagnostic, GyroError

GOOD = lab().text()
for statement in "motion: steady", "ball_mass: 4.3 kg", "ball_diameter: 10.16 cm":
    GOOD = GOOD.replace(f"# {statement}\n", "")
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
    return GOOD.replace(
        ROW, ",".join([*cells[:at], change(cells[at]), *cells[at + 1 :]])
    )


def table(head: str, *cells: Callable[[list[str]], str]) -> str:
    """Write the runs in other columns."""
    return (
        "\n".join(
            [LINES[0], head, *(",".join(one(row) for one in cells) for row in ROWS)]
        )
        + "\n"
    )


FIRST = [lambda row, i=i: row[i] for i in range(4)]
NO_TURNS = "mass [g],position [cm],spin [rpm],"


def period(row: list[str]) -> str:
    return f"{3 * float(row[3]):.2f}"


NEWTONS = [
    lambda row: f"{float(row[0]) * 9.803e-3:.5f}",
    *FIRST[1:],
    lambda row: row[4],
]

CASES: list[tuple[str, str]] = [
    ("G203", cell(2, lambda text: "6O4")),
    ("G203", cell(3, lambda text: "#DIV/0!")),
    ("G204", cell(4, lambda text: "03.Jan")),
    ("G205", table(HEAD.replace("mass [g]", "Weight (N)"), *NEWTONS)),
    ("G206", headed(HEAD.replace("spin [rpm]", "spin"))),
    ("G207", table(f"{NO_TURNS}T [s],turns", *FIRST[:3], period, lambda row: row[4])),
    ("G214", f"Task III\n{GOOD}"),
    (
        "G231",
        table(
            f"{NO_TURNS}t [s],T [s],turns",
            *FIRST[:3],
            period,
            FIRST[3],
            lambda row: row[4],
        ),
    ),
    ("G301", table(f"{NO_TURNS}Time for 1/3 rev (s)", *FIRST)),
    ("G301", table(f"{NO_TURNS}T Ω(120°) (s)", *FIRST)),
    ("G301", headed(HEAD.replace("spin [rpm]", "phi_dot (rpm)"))),
    ("G305", f"# u_tme: 0.2 s\n{GOOD}"),
    ("G404", GOOD.partition("\n")[2]),
    ("G407", GOOD.replace(",14.8,", ",15,")),
]
"""Code and log; the hint is that of the code's first diagnostic."""

OTHERWISE = {
    (
        "advice to look, to say what was done, to time again or to add runs: nothing "
        "that the log tells"
    ): "G402 G403 "
    "G410 G412 G413 G415 G416 G418 G419 G429 G431 G442 G444 G445 G446 G449 G450 "
    "G451 G452 G453 G454 G455 G456",
    "what was understood is said, and needs nothing": "G140 G141 G142 G143 G145 G146 "
    "G216 G217 G220 G225 G228 "
    "G236 G304 G310 G341 G427 G447",
    "another file is asked for, or only told which columns lie idle": "G106 G108 G221 G223",
    "readings/test_followed_hints.py": "G240 G401",
    "test_days.py": "G311 G312 G460",
    "readings/test_unrelated_columns.py": "G237",
    "readings/test_workbooks.py": "G110 G111",
    "test_measurements.py": "G406",
    "test_analysis.py": "G414 G433 G435",
    "test_guard.py": "G420 G421",
    "test_released_and_advice.py": "G425 G426",
    "test_slips.py": "G440 G441 G443",
    "test_misread_values.py": "G233 G235 G309 G408",
    "tests of their own below": "G101 G102 G308 G411 G432 G459",
}
"""Why a code is in neither table, or which test carries its hint out."""


def said_of(log: str | bytes, **options: Any) -> tuple[Any, list[Diagnostic]]:
    """Give I_zz, or None, and all that is said."""
    try:
        analysis = analyze_briefly(
            log.encode() if isinstance(log, str) else log, **options
        )
    except GyroError as error:
        return None, list(error.diagnostics)
    return analysis.inertia, list(analysis.diagnostics)


def assert_mended(
    log: str | bytes, code: str, options: dict[str, Any], widest: float = 4.0
) -> None:
    """See that a log is no longer told of, and that its answer is the truth."""
    inertia, said = said_of(log, **options)
    assert [d for d in said if d.code == code or d.severity == "error"] == []
    assert abs(inertia.value - TRUTH) < widest * inertia.u
    assert inertia.u < 0.03 * TRUTH


def carry_out(log: str, told: Diagnostic) -> tuple[str, dict[str, Any]]:
    """Do what the hint says first, as a student would who reads no further."""
    lines, hint = log.splitlines(), told.hint
    at, start = (told.line or 1) - 1, (told.column or 1) - 1
    wrong = lines[at][start : start + told.width]

    def put(text: str) -> str:
        lines[at] = lines[at][:start] + text + lines[at][start + told.width :]
        return "\n".join(lines) + "\n"

    if pairs := re.findall(r'--map (\w+)="([^"]+)"', hint.partition(" or --map")[0]):
        stated = re.search(r'--set (\w+)="?([^"?…]+)"?\?', hint)
        # A time that fits a whole period as well: the student did time one turn here,
        # as the other way says.
        other = re.search(r'or --map (precession_period)="([^"]+)"', hint)
        return log, {
            "mapping": dict([other.groups()] if other else pairs),
            "settings": dict([stated.groups()] if stated else []),
        }
    if line := re.search(r'did you mean "(# [^"]+)"', hint):
        return put(line[1]) if wrong.startswith("#") else log.replace(
            lines[at], line[1]
        ), {}
    if meant := re.search(r"did you mean ([^\s?]+)\?", hint):
        return put(meant[1]), {}
    if longer := re.search(r"such as ([\d.]+),", hint):
        return log.replace(f",{wrong},", f",{longer[1]},"), {}
    if header := re.search(r'write the header as "([^"]+)"', hint):
        return put(header[1]), {}
    if stated := re.search(r"(# \w+: [^,\n]+)", hint):
        return f"{stated[1]}\n{log}", {}
    assert re.search("put (a )?# before the line", hint), hint
    lines[at] = f"# {lines[at]}"
    return "\n".join(lines) + "\n", {}


@pytest.mark.parametrize(
    ("code", "log"), CASES, ids=[f"{code}-{k}" for k, (code, _) in enumerate(CASES)]
)
def test_a_hint_obeyed_to_the_letter_gives_the_truth(code: str, log: str) -> None:
    told = [d for d in said_of(log)[1] if d.code == code]
    # Without a word the reader understands it by itself.
    mended, options = carry_out(log, told[0]) if told else (log, {})
    assert_mended(mended, code, options, 4 if code != "G407" else 6)


def test_a_wider_time_ends_the_quarrel_of_the_runs() -> None:
    log = f"# u_time: 0.01 s\n# u_angle: 0 deg\n# u_spin: 0.01 %\n{GOOD}"
    before = gyrodata.analyze(log.encode())
    stated = named(
        next(d.hint for d in before.diagnostics if d.code == "G411"),
        r"(# u_time: [\d.]+ s)",
    )
    after = gyrodata.analyze(log.replace("# u_time: 0.01 s", stated).encode())
    assert "G411" not in [d.code for d in after.diagnostics]
    assert [doubt.kind for doubt in before.doubts] == ["scatter"]
    assert before.advice[0].startswith("find the cause first: ")
    assert after.doubts == ()
    assert abs(after.inertia.value - TRUTH) < 4 * (after.inertia.u or 0.0)


def test_the_uncertainty_that_is_named_is_the_one_to_state() -> None:
    assert (
        "u_time"
        in next(
            d for d in said_of(f"# u_time: 0.6 s\n{GOOD}")[1] if d.code == "G432"
        ).hint
    )
    assert_mended(f"# u_time: 0.1 s\n{GOOD}", "G432", {})


TABLE = [line.split(",") for line in LINES[1:]]
"""Header and runs as cells."""


def written(cells: list[list[str]], delimiter: str = ",") -> str:
    return "\n".join([LINES[0], *(delimiter.join(row) for row in cells)]) + "\n"


def changed(row: int, at: int, text: str) -> str:
    """Change one cell of the table, the header being row 0."""
    return written(
        [
            [text if (i, k) == (row, at) else old for k, old in enumerate(r)]
            for i, r in enumerate(TABLE)
        ]
    )


def named(hint: str, pattern: str) -> str:
    """Take what is to be typed out of the words of a hint."""
    found = re.search(pattern, hint)
    assert found, hint
    return found[1]


def quoted(cells: list[list[str]]) -> str:
    """Write decimal commas in quotes, as a hint shows."""
    return written(
        [[f'"{cell}"' if "," in cell else cell for cell in row] for row in cells]
    )


def above(line: str, log: str = GOOD) -> str:
    return f"{line}\n{log}"


def then_good(words: str) -> Callable[[str], str]:
    """Do what the words say, if the hint contains them: type the log without its fault."""
    return lambda hint: GOOD if words in hint else ""


NO_G = GOOD.partition("\n")[2]
COMMAS = [TABLE[0], *([cell.replace(".", ",") for cell in row] for row in TABLE[1:])]
HERTZ = table(
    "mass [g],position [cm],spin [1/s],time [s],turns",
    *FIRST[:2],
    lambda row: f"{float(row[2]) / 60:.4f}",
    FIRST[3],
    lambda row: row[4],
)
LOWER = "".join(f"{','.join(row[1:])}\n" for row in (TABLE[0], *TABLE[7:]))
"""The last three runs in a table of their own, without the weight."""
BY_WEIGHT = "".join(
    f"mass {rows[0][0]} g\n"
    + "".join(f"{','.join(row[1:])}\n" for row in (TABLE[0], *rows))
    + "\n"
    for rows in (TABLE[1:4], TABLE[4:7])
)
"""The other runs in two tables, with the weight in a line above each."""
SURFACE_HEAD = ["mass [g]", "distance from ball surface [cm]", *TABLE[0][2:]]
DOUBTED = written([[*TABLE[0], "u_time"], *([*row, "little"] for row in TABLE[1:])])
PERIOD_HEAD = [*TABLE[0][:3], "precession period [s]", "turns"]


READER: list[tuple[str, str | bytes, Callable[[str], Any]]] = [
    ("G103", b"", then_good("with: gyro template")),
    ("G104", "%PDF-1.7 a report, not a log", then_good("CSV UTF-8")),
    ("G105", GOOD.encode() + b"\0", then_good("CSV UTF-8")),
    ("G107", gzip.compress(GOOD.encode())[:-30], then_good("the CSV itself")),
    (
        "G109",
        above("# ± by hand").encode("latin-1"),
        lambda hint: above("# ± by hand").encode(named(hint, r"as (\S+)")),
    ),
    (
        "G201",
        written([list(column) for column in zip(*TABLE, strict=True)]),
        then_good("Transpose turns a table"),
    ),
    (
        "G201",
        written(TABLE[1:]),
        lambda hint: written([named(hint, r"such as: (.*)").split(", "), *TABLE[1:]]),
    ),
    ("G202", written(TABLE[:1]), then_good("one row for each timed run")),
    (
        "G208",
        HERTZ,
        lambda hint: HERTZ.replace(
            "1/s", named(hint, r"write (\S+) .*for revolutions")
        ),
    ),
    (
        "G209",
        written(COMMAS),
        lambda hint: written(COMMAS, named(hint, r"columns with (\S)")),
    ),
    (
        "G209",
        written([TABLE[0], *([*row, "7"] for row in TABLE[1:])], ";"),
        lambda hint: (
            written([row[:5] for row in TABLE], ";")
            if "remove the cell that is too many" in hint
            else ""
        ),
    ),
    ("G210", written([[*row, row[1]] for row in TABLE]), then_good("remove the other")),
    (
        "G210",
        written([TABLE[0] * 2, *(TABLE[i] + TABLE[i + 1] for i in (1, 3, 5))]),
        then_good("below each other, with the names once"),
    ),
    (
        "G212",
        BY_WEIGHT + LOWER,
        lambda hint: (
            BY_WEIGHT + named(hint, r'such as "(mass )[\d.]+ g"') + "60.2 g\n" + LOWER
        ),
    ),
    (
        "G212",
        written(TABLE[:7])
        + "\n"
        + written([row[::-1] for row in (TABLE[0], *TABLE[7:])]),
        lambda hint: (
            written(TABLE[:7])
            + "\n"
            + written([named(hint, r"in this order: ([^;]*)").split(","), *TABLE[7:]])
        ),
    ),
    (
        "G215",
        written([*TABLE, ["60.2", "14.8", "212", "0", "1/3"]]),
        lambda hint: (
            written([*TABLE, ["60.2", "14.8", "212", "", "1/3"]])
            if "left blank" in hint
            else ""
        ),
    ),
    ("G219", changed(1, 0, ""), then_good("the value in each of these rows")),
    ("G222", written(TABLE, "_"), then_good("put a comma")),
    (
        "G224",
        written([[*row, *["0"] * 240] for row in TABLE]),
        then_good("columns of the lab"),
    ),
    (
        "G226",
        changed(9, 4, '"1/3'),
        lambda hint: changed(9, 4, '"1/3' + named(hint, r"close it with (\S),")),
    ),
    (
        "G227",
        DOUBTED,
        lambda hint: DOUBTED.replace("little", named(hint, r'value: "([^"]+)"')),
    ),
    (
        "G229",
        written(
            [
                [*TABLE[0], "note"],
                *([*row[:3], *row[3].split("."), row[4]] for row in TABLE[1:]),
            ]
        ),
        lambda hint: (
            quoted(
                [
                    TABLE[0],
                    *(
                        [*row[:3], row[3].replace(".", ","), row[4]]
                        for row in TABLE[1:]
                    ),
                ]
            )
            if '("13,06")' in hint
            else ""
        ),
    ),
    (
        "G230",
        written([PERIOD_HEAD, *TABLE[1:]]),
        lambda hint: (
            written([PERIOD_HEAD, *TABLE[1:]]),
            {"mapping": {"time": named(hint, r'--map time="([^"]+)"')}},
        ),
    ),
    (
        "G232",
        written(
            [[*TABLE[0][:3], "time [s]", " 1/3 turn"], *(row[:4] for row in TABLE[1:7])]
        ),
        lambda hint: written(
            [
                [*TABLE[0][:3], named(hint, r'as "([^"]+)"')],
                *(row[:4] for row in TABLE[1:7]),
            ]
        ),
    ),
    (
        "G302",
        changed(3, 4, ""),
        lambda hint: above(named(hint, r'"(# turns: )') + "1/3", changed(3, 4, "")),
    ),
    (
        "G303",
        written([[*TABLE[0], "angle [deg]"], *([*row, "90"] for row in TABLE[1:])]),
        then_good("delete one column"),
    ),
    (
        "G306",
        above("# g: fast", NO_G),
        lambda hint: above(
            named(explanations()["G306"].remedy, r'"(# g: [^"]+)"'), NO_G
        ),
    ),
    ("G307", f"# g: 9.81 m/s^2\n{GOOD}", then_good("keep one")),
    (
        "G340",
        written([SURFACE_HEAD, *TABLE[1:]]),
        lambda hint: above(
            named(hint, r'"(# position_from: centre)"'),
            written([SURFACE_HEAD, *TABLE[1:]]),
        ),
    ),
    (
        "G342",
        GOOD.replace("1/3", "0.33"),
        lambda hint: GOOD.replace("1/3", named(hint, r"write (\S+) where")),
    ),
]
"""Code, log, and what the words of the hint make of it."""


@pytest.mark.parametrize(
    ("code", "log", "mend"),
    READER,
    ids=[f"{one[0]}-{k}" for k, one in enumerate(READER)],
)
def test_a_hint_of_the_reader_gives_the_truth(
    code: str, log: str | bytes, mend: Callable[[str], Any]
) -> None:
    made = mend(next(d.hint for d in said_of(log)[1] if d.code == code))
    mended, options = made if isinstance(made, tuple) else (made, {})
    assert_mended(mended, code, options)


def test_a_file_that_is_not_there_is_proposed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("lab.csv").write_text(GOOD, encoding="utf-8")
    for name, hint in (
        ("lab.cv", "did you mean lab.csv?"),
        (".", "if it is a folder, give the file in it, such as ./log.csv"),
    ):
        with pytest.raises(GyroError) as caught:
            gyrodata.analyze(name)
        assert caught.value.diagnostics[0].hint == hint


def test_the_answer_with_the_unit_that_is_asked_for() -> None:
    told = next(
        d for d in said_of(above("# reported_inertia: 4.4e-3"))[1] if d.code == "G308"
    )
    mended = above("# reported_inertia: " + named(told.hint, r"like (.*)"))
    assert_mended(mended, "G308", {})
    assert gyrodata.analyze(mended.encode()).readings.reported[
        "inertia"
    ].value == pytest.approx(4.4e-3)


def test_every_hint_of_a_log_is_carried_out_or_asks_for_the_lab() -> None:
    carried = {one[0] for one in (*CASES, *READER)} | set(
        " ".join(OTHERWISE.values()).split()
    )
    assert carried <= set(explanations())
    assert {code for code in explanations() if re.match("G[1-4]", code)} <= carried
