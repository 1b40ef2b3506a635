"""Recipes of the map for newcomers, carried out on a copy of the package, which must
then work.

One copy for all, and of each recipe the smallest real example, as a patch: text after a
file's name is put in where the lines with a blank or a minus before them stand, or at
the end of the file where there are none. The recipe must name every file that this
takes."""

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
TEXT = (ROOT / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
WRITTEN = dict(
    re.findall(r"^\* \*\*(.*?)\*\*(.*?)(?=^\* |^## )", TEXT, re.MULTILINE | re.DOTALL)
)

RECIPES: dict[str, str] = tomllib.loads(
    (DATA / "recipes.toml").read_text(encoding="utf-8")
)
"""By its name in the map."""

SCRIPT = """
import json, sys
from matplotlib.figure import Figure
import gyrodata

log = open(sys.argv[1], encoding="utf-8").read()
head, *rows = [line for line in log.splitlines() if line[0] != "#"]
lab = gyrodata.analyze(log.encode())
lines = [head + ",Verzug [s]", *(row + ",0.5" for row in rows)]
late = gyrodata.analyze("\\n".join(lines).encode())
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
            old = "\n".join(line[1:] for line in body if line[0] != "+")
            new = "\n".join(line[1:] for line in body if line[0] != "-")
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


@pytest.mark.parametrize("recipe", WRITTEN)
def test_a_recipe_names_its_files_in_six_lines(recipe: str) -> None:
    told, rooms = WRITTEN[recipe], re.findall(r"`([\w/]+\.py)`", WRITTEN[recipe])
    assert len(told.strip().splitlines()) <= 6
    assert rooms
    assert [
        name
        for name in rooms
        if not any((ROOT / top / name).is_file() for top in ("gyrodata", ""))
    ] == []
    assert [
        name for name, _ in files_of(RECIPES.get(recipe, "")) if f"`{name}`" not in told
    ] == []


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
        "each spin was set.",
    )
    assert [word for word in words if word not in seen["report"]] == []
    home = copy / "class" / "Doe, Jane(jdoe)" / "Submission attachment(s)"
    home.mkdir(parents=True)
    shutil.copy(SAMPLE, home / "lab.csv")
    told = run(
        copy,
        "-m",
        "gyrodata",
        "grade",
        "class",
        "--lms",
        "sakai",
        "--format",
        "json",
        "--workers",
        "0",
    )
    assert [(student["student"], student["name"]) for student in told["students"]] == [
        ("jdoe", "Doe, Jane")
    ]
