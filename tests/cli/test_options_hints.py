"""What the options --set, --map, --config and those of the template are refused for,
mended as the hint says.

Each hint is carried out to the letter on a log of a known truth, which must come out.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from judging.test_wrong_units_and_counts import TRUTH, lab
from simulated_labs import analyze_briefly
from typer.testing import CliRunner

import gyrodata
from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import Diagnostic, GyroError
from gyrodata.cli import app

G, HEAD = "# g: 9.803 m/s^2\n", "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROWS = [line.split(",") for line in lab().text().splitlines()[-9:]]


def log(
    head: str = HEAD, cells: str = "01234", top: str = G, rows: list[list[str]] = ROWS
) -> str:
    """Write the runs with some of their columns."""
    return (
        top
        + head
        + "".join(",".join(row[int(at)] for at in cells) + "\n" for row in rows)
    )


LOG, WITHOUT_G = log(), log(top="")
WITHOUT_TURNS = log("mass [g],position [cm],spin [rpm],time [s]\n", "0123")
ONE_SPIN = log(
    "mass [g],position [cm],time [s],turns\n",
    "0134",
    rows=[row for row in ROWS if row[2] == "398"],
)
ONE_PLACE = log("mass [g],spin [rpm],time [s],turns\n", "0234")
CLOCK = log(HEAD.replace("time [s]", "clock [s]"))

CARRIED_OUT = {"G501", "G502", "G503", "G504", "G505"}


def refused(source: str, code: str, **options: Any) -> Diagnostic:
    with pytest.raises(GyroError) as caught:
        gyrodata.analyze(source.encode(), **options)
    return next(one for one in caught.value.diagnostics if one.code == code)


def assert_right(source: str, **options: Any) -> None:
    """Compare the answer with the truth; a refusal raises."""
    found = analyze_briefly(source.encode(), **options).inertia
    assert abs(found.value - TRUTH) < 4 * (found.u or 0.0)
    assert (found.u or 0.0) < 0.05 * TRUTH


def typed_as(hint: str, text: str, meant: str = "") -> str:
    """Type a value as the hint says; `meant` is the number where the text has none."""
    if copied := re.search(r'(?:like|such as|write) "([^"]+)"', hint):
        return copied[1]
    if whole := re.match(r"write ([\d.]+) or ", hint):
        return re.sub(r"^[\d.,]+", whole[1], text)
    number, _, rest = (text if re.match(r"[\d.]", text) else meant).partition(" ")
    if hint == "write the number alone":
        return number
    unit = re.search(
        r"(?:one behind it|its unit|write one of): ([^,]+)", hint
    ) or re.match(r"write (\S+) ", hint)
    assert unit, hint
    return f"{number} {unit[1]} {rest if ' ' in rest else ''}".strip()


NAMES: list[tuple[str, str, str, dict[str, str], str, dict[str, str]]] = [
    (
        WITHOUT_TURNS,
        "G501",
        "settings",
        {"trns": "1/3"},
        "did you mean turns",
        {"turns": "1/3"},
    ),
    (
        WITHOUT_G,
        "G501",
        "settings",
        {"gg": "9.803 m/s^2"},
        "did you mean g",
        {"g": "9.803 m/s^2"},
    ),
    (
        CLOCK,
        "G502",
        "mapping",
        {"time": "Zeitpunkt"},
        r'"clock \[s\]"',
        {"time": "clock [s]"},
    ),
    (
        CLOCK,
        "G503",
        "mapping",
        {"tme": "clock [s]"},
        "did you mean time",
        {"time": "clock [s]"},
    ),
    (
        CLOCK,
        "G503",
        "mapping",
        {"time": "clock [s]", "spin": "clock [s]"},
        "leave --map spin=… out",
        {"time": "clock [s]"},
    ),
]


@pytest.mark.parametrize(
    ("source", "code", "option", "given", "proposed", "mended"), NAMES
)
def test_name_that_is_proposed_or_listed_gives_the_truth(
    source: str,
    code: str,
    option: str,
    given: dict[str, str],
    proposed: str,
    mended: dict[str, str],
) -> None:
    assert re.search(proposed, refused(source, code, **{option: given}).hint)
    assert_right(source, **{option: mended})


VALUES = [
    (WITHOUT_G, "g", "fast", "9.803", "9.803 m/s^2"),
    (WITHOUT_TURNS, "turns", "many", "1/3", "1/3"),
    (ONE_SPIN, "spin", "6.63 1/s", "", "6.63 rev/s"),
    (ONE_PLACE, "position", "14.8", "", "14.8 mm"),
    (LOG, "u_time", "little", "0.1", "0.1 s"),
    (LOG, "u_turns", "1 deg", "", "1"),
    (LOG, "balance_drift", "3 deg in 10 s", "", "5 deg in 60 s at 400 rpm"),
    (LOG, "motion", "free", "", "released"),
    (LOG, "rod_mass", "1,300 g", "", "1300 g"),
]
"""Log, key, value, the number meant where the value has none, and what the hint makes
of it."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "key", "text", "meant", "mended"),
    VALUES,
    ids=[f"{v[1]}={v[2]}" for v in VALUES],
)
def test_a_value_is_typed_as_the_hint_says(
    source: str, key: str, text: str, meant: str, mended: str
) -> None:
    hint = refused(source, "G504", settings={key: text}).hint
    assert typed_as(hint, text, meant) == mended
    if key == "position":
        # Which of the units is left to whoever held the ruler.
        assert " cm," in hint
        mended = "14.8 cm"
    if key in ("u_turns", "balance_drift", "motion"):
        gyrodata.analyze(LOG.encode(), settings={key: mended})
    else:
        assert_right(source, settings={key: mended})


CONFIGS = [
    ("G505", "[log]\ng = '9.803 m/s^2'\n", lambda _, text: text.replace("[log]\n", "")),
    ("G505", "g = ['9.803 m/s^2']\n", lambda hint, _: hint.partition(": ")[2]),
    (
        "G504",
        "g = 'fast'\n",
        lambda hint, _: f'g = "{typed_as(hint, "fast", "9.803")}"',
    ),
    ("G505", "g = 9.803 m/s^2\n", lambda hint, _: hint.partition(": ")[2]),
    (
        "G501",
        "gg = '9.803 m/s^2'\n",
        lambda hint, text: text.replace("gg", hint.split()[3].strip("?")),
    ),
]


@pytest.mark.parametrize(
    ("code", "text", "mend"),
    CONFIGS,
    ids=[text.split("\n")[0] for _, text, _ in CONFIGS],
)
def test_a_file_of_constants_is_mended(
    code: str, text: str, mend: Any, tmp_path: Path
) -> None:
    path = tmp_path / "station.toml"
    path.write_text(text)
    path.write_text(mend(refused(WITHOUT_G, code, config=path).hint, text))
    assert_right(WITHOUT_G, config=path)


@pytest.mark.parametrize(
    ("option", "number", "unit"), [("--spins", "200", ""), ("--position", "15", " s")]
)
def test_the_template_is_printed_then(option: str, number: str, unit: str) -> None:
    done = CliRunner().invoke(app, ["template", option, number + unit])
    assert (done.exit_code, done.stdout) == (2, "")
    hint = re.search(r": (\w+),", done.stderr.splitlines()[1])
    assert hint, done.stderr
    mended = CliRunner().invoke(app, ["template", option, number + hint[1]])
    assert mended.exit_code == 0


def test_semicolons_separate_the_values_of_an_option() -> None:
    with_commas, with_semicolons = (
        CliRunner().invoke(app, f"template --weights '{weights}'").stdout
        for weights in ("20g,40g", "20;40g")
    )
    assert "40.00,15.0" in with_commas
    assert with_semicolons == with_commas


def test_what_is_explained_is_right_too(tmp_path: Path) -> None:
    (typed,) = re.findall('--set g="([^"]+)"', explanations()["G504"].remedy)
    (line,) = re.findall("(g = .*)", explanations()["G505"].remedy)
    assert_right(WITHOUT_G, settings={"g": typed})
    (tmp_path / "station.toml").write_text(line)
    assert_right(WITHOUT_G, config=tmp_path / "station.toml")
    assert "--set turns=" in explanations()["G501"].remedy
    assert "--map time=" in explanations()["G503"].remedy
