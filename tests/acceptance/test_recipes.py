"""The recipes for newcomers in `.github/RECIPES.md`, carried out on a copy of the
package, which must then work.

One copy for all, and of each recipe the smallest real example, as a patch: text after a
file's name is put in where the lines with a blank before them stand, or at the end of
the file where there are none. No line is replaced, so that an example and a real change
of the same kind fit into one package. The recipe must name every file that this takes,
and at most five."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from places import DATA, ROOT

SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
TEXT = (ROOT / ".github" / "RECIPES.md").read_text(encoding="utf-8")
LARGE = dict(re.findall(r"(?ms)^## ([^\n]*)\n(.*?)^```diff\n", TEXT))
SMALL = dict(re.findall(r"(?ms)^\* \*\*(.*?)\*\*(.*?)(?=^\* |\Z)", TEXT))

RECIPES: dict[str, str] = tomllib.loads(
    (DATA / "recipes.toml").read_text(encoding="utf-8")
) | dict(re.findall(r"(?ms)^## ([^\n]*)\n.*?^```diff\n(.*?)^```$", TEXT))
"""The patch of each recipe, by its name."""

SCRIPT = """
import json, math, sys
from matplotlib.figure import Figure
import gyrodata

log = open(sys.argv[1], encoding="utf-8").read()
head, *rows = [line for line in log.splitlines() if line[0] != "#"]
lab = gyrodata.analyze(log.encode())
lines = [head + ",Verzug [s]", *(row + ",0.5" for row in rows)]
late = gyrodata.analyze("\\n".join(lines).encode())
short = head.split(",").index("turns")
without_short_runs = "\\n".join(
    line
    for line in log.splitlines()
    if line[0] == "#" or line in (head,) or line.split(",")[short] in ("1", "2", "3")
)
def of_fewer_runs(lab):
    document = lab.to_dict()["result"]
    left = [run for run in document["runs"] if run["left_out"]]
    reasons = sorted({run["reason"] for run in left})
    return [document["inertia"]["value"], len(document["runs"]), len(left), reasons]

english = "# motion: steady\\nmass [g],position [cm],spin [rpm],turns,time [s]\\n"
esperanto = "# motion: steady\\nmaso de pezilo [g];distanco de la centro [cm];"
esperanto += "rotacia rapido [rond/min];rondiroj;daŭro [s]\\n"
for mass in (20, 40, 60):
    for rpm in (200, 400, 600):
        time = round(0.0044 * rpm * math.pi / 30 * 2 * math.pi / (mass * 1e-3 * 9.80665 * 0.15), 2)
        english += f"{mass},15.0,{rpm},1,{time}\\n"
        esperanto += f"{mass};15,0;{rpm};1;{time}\\n".replace(".", ",")
braked = english.replace("motion: steady", "motion: braked")

def of_model(lab):
    document = lab.to_dict()["result"]
    rows = [effect["kept"] for effect in document["effects"] if effect["effect"] == "brake"]
    sources = [share["source"] for share in document["budget"]]
    return [document["model"], document["inertia"]["value"], rows, sources.count("brake")]

def days(factor):
    rows = english.splitlines()[2:]
    arm = round(15 / factor, 3)
    second = [row.replace(",15.0,", f",{arm},") for row in rows]
    head = "# motion: steady\\nday,mass [g],position [cm],spin [rpm],turns,time [s]\\n"
    lines = [*(f"Mon,{row}\\n" for row in rows), *(f"Tue,{row}\\n" for row in second)]
    return head + "".join(lines)

def of_days(log):
    lab = gyrodata.analyze(log.encode())
    return [[each.kind, each.remedy] for each in lab.explanations]

count = b"mass [g],position [cm],spin [rpm],time [s],turns\\n0.01,15,400,13,1\\n".replace
print(json.dumps({
    "unit": gyrodata.read_log(count(b"[g]", b"[slug]")).columns["mass"].values,
    "late": [one.time - run.time for one, run in zip(late.run_table, lab.run_table, strict=True)],
    "raised": [
        d.severity
        for d in gyrodata.read_log(count(b"13,1", b"780,60")).diagnostics
        if d.code == "G299"
    ],
    "budget": {share.source: share.share for share in lab.budget},
    "spin_high": [
        one.inertia.value / lab.inertia.value
        for one in lab.sensitivity
        if one.name == "spin_high"
    ],
    "doubts": [doubt.words for doubt in lab.doubts],
    "bars": sum(bar.get_height() for bar in lab.plot("spins", Figure().add_subplot()).patches),
    "report": lab._repr_markdown_(),
    "fewer": of_fewer_runs(gyrodata.analyze(log.encode(), min_turns=0.9)),
    "page": gyrodata.analyze(log.encode(), min_turns=0.9)._repr_markdown_(),
    "rows": of_fewer_runs(gyrodata.analyze(without_short_runs.encode())),
    "esperanto": gyrodata.analyze(esperanto.encode()).inertia.value,
    "english": gyrodata.analyze(english.encode()).inertia.value,
    "braked": of_model(gyrodata.analyze(braked.encode())),
    "asked": of_model(gyrodata.analyze(english.encode(), model="braked")),
    "level": of_model(gyrodata.analyze(english.encode())),
    "inches": of_days(days(2.54)),
    "smaller": of_days(days(2.45)),
    "same days": of_days(days(1)),
}))
"""


def files_of(patch: str) -> list[tuple[str, list[str]]]:
    """Name each file of a patch, with its lines."""
    parts = [
        part.splitlines() for part in patch.strip().removeprefix("@ ").split("\n@ ")
    ]
    return [(lines[0], lines[1:]) for lines in parts if lines]


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the package, and carry every recipe out on it."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(
        ROOT / "gyrodata",
        folder / "gyrodata",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    for patch in RECIPES.values():
        for name, body in files_of(patch):
            path = folder / "gyrodata" / name
            text = path.read_text(encoding="utf-8")
            old = "\n".join(line[1:] for line in body if line[0] == " ")
            new = "\n".join(line[1:] for line in body)
            assert old in text, f"{name} has no {old!r} any more"
            path.write_text(
                text.replace(old, new, 1) if old else text + new + "\n",
                encoding="utf-8",
            )
    return folder


def run(copy: Path, *words: str | Path) -> Any:
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    done = subprocess.run(
        [sys.executable, *words],
        cwd=copy,
        env=environment,
        capture_output=True,
        encoding="utf-8",
    )
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def names_in(text: str) -> list[str]:
    """List the files that a text names."""
    return re.findall(r"`([\w/]+\.(?:\w+\.)?(?:py|toml|txt|md|jinja))`", text)


@pytest.mark.parametrize("recipe", LARGE)
def test_a_recipe_opens_at_most_five_files_of_the_package(recipe: str) -> None:
    words = LARGE[recipe]
    opened = names_in(words[words.index("Open") :].partition(". ")[0])
    assert "docs/changelog.md" in opened
    assert len(set(opened)) <= 5
    assert {name for name, _ in files_of(RECIPES[recipe])} <= set(opened)
    assert len(words.strip().splitlines()) <= 10
    assert "Tests: " in words


@pytest.mark.parametrize("recipe", RECIPES)
def test_an_example_only_adds_lines(recipe: str) -> None:
    lines = [line for _, body in files_of(RECIPES[recipe]) for line in body]
    assert {line[0] for line in lines} <= {" ", "+"}


@pytest.mark.parametrize("recipe", SMALL)
def test_a_smaller_recipe_names_its_files_in_four_lines(recipe: str) -> None:
    words = SMALL[recipe]
    opened = set(names_in(words))
    assert 0 < len(opened) <= 5
    assert {name for name, _ in files_of(RECIPES.get(recipe, ""))} <= opened
    assert len(words.strip().splitlines()) <= 4
    assert "open" in words


def test_files_and_tests_of_recipes_exist() -> None:
    names = {*names_in(TEXT), *re.findall(r"`(tests/[\w/]+)`", TEXT)}
    assert [
        name
        for name in sorted(names)
        if not any((ROOT / top / name).exists() for top in ("gyrodata", ""))
    ] == ["messages.toml"]


def test_recipes_carried_out_work(copy: Path) -> None:
    seen = run(copy, "-c", SCRIPT, SAMPLE)
    assert seen["unit"] == [pytest.approx(0.14593902937)]
    assert seen["late"] == pytest.approx([0.5] * len(seen["late"]))
    assert seen["raised"] == ["warning"]
    assert seen["budget"]["lift"] > 0.01
    assert seen["spin_high"] == [pytest.approx(1 / 1.01, rel=1e-4)]
    assert seen["doubts"] == ["a spin is over 600 rpm"]
    assert seen["bars"] == 10
    words = (
        "lift of the air",
        "every spin 1 % higher",
        "a spin is over 600 rpm",
        "(spins.png)",
        "Bars: number of runs.",
    )
    assert [word for word in words if word not in seen["report"]] == []
    value, count, left, reasons = seen["fewer"]
    assert seen["rows"] == [pytest.approx(value, rel=1e-9), count - left, 0, []]
    assert reasons == ["it has fewer than 0.9 turns"]
    report = ("analyze", SAMPLE, "--min-turns", "0.9", "--out", "report")
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    done = subprocess.run(
        [sys.executable, "-m", "gyrodata", *report],
        cwd=copy,
        env=environment,
        capture_output=True,
        encoding="utf-8",
    )
    page = (copy / "report" / "report.html").read_text(encoding="utf-8")
    rows = (copy / "report" / "runs.csv").read_text(encoding="utf-8").splitlines()
    assert done.stdout.count("Not in the fit: run ") == left
    assert page.count("it has fewer than 0.9") == left
    assert page.count('">205</data>') == 1
    assert page.count('<tr class="flagged">') == left
    assert "all runs are in the fit" not in page
    assert "option min turns: " in seen["page"]
    assert len(rows) == 1 + count
    assert seen["esperanto"] == pytest.approx(seen["english"], rel=1e-9)
    name, value, rows, count = seen["braked"]
    assert (name, rows, count) == ("braked", [True], 1)
    assert value == pytest.approx(0.98 * seen["english"], rel=1e-3)
    assert seen["asked"] == ["braked", pytest.approx(value), [True], 1]
    assert seen["level"] == ["horizontal", pytest.approx(seen["english"]), [], 0]
    assert seen["inches"] == [["inches", 'multiply each position of "Tue" by 2.54']]
    assert "inches" not in [kind for kind, _ in seen["smaller"]]
    assert seen["same days"] == []
    for student in ("Doe_Jane_jdoe_1234567", "Roe_Ann_aroe_7654321"):
        home = copy / "class" / student
        home.mkdir(parents=True)
        shutil.copy(SAMPLE, home / "lab.csv")
        (home / "time.txt").write_text("2026-03-09", encoding="utf-8")
        (home / "feedback.txt").write_text("I_zz = 9 kg m^2", encoding="utf-8")
    told = run(
        copy,
        "-m",
        "gyrodata",
        "grade",
        "class",
        "--format",
        "json",
        "--workers",
        "0",
    )
    assert told["input"]["lms"] == "campus"
    assert [(student["student"], student["name"]) for student in told["students"]] == [
        ("aroe", "Roe_Ann"),
        ("jdoe", "Doe_Jane"),
    ]
