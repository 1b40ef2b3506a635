"""The recipes of the map for newcomers, carried out on a copy of the package, which must then work.

One copy for all, and of each recipe the smallest real example, as a patch: text after a file's name is put in where the
lines with a blank or a minus before them stand, or at the end of the file where there are none. The recipe must name
every file that this takes.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
WRITTEN = dict(re.findall(r"^\* \*\*(.*?)\*\*(.*?)(?=^\* |^## )", TEXT, re.MULTILINE | re.DOTALL))

RECIPES = {
    "A unit": """
@ units.py
     ("mg", "milligram", "1e-6 kilogram", _M, "mg мг"),
+    ("slug", "slug", "14.593902937206364 kilogram", _M, "slug slugs"),
""",
    "A role": """
@ readings/roles.py
 TABLE: tuple[Role, ...] = (
+    Role("delay", "time", words="delay, Verzug", bound="not below zero", meaning="how late a start was"),
@ measurements/measured.py
     time, turns, timing = _timing(columns, count)
+    if "delay" in columns:
+        time = time + values_of(columns["delay"])
""",
    "A diagnostic": """
@ diagnostics.py
+TURNS_TOO_MANY = _warning("G299", "more than 50 turns", LOG + "20,15.0,406,2356,60\\n")
@ readings/meaning.py
 from gyrodata.diagnostics import (
+    TURNS_TOO_MANY,
@ readings/meaning.py
     _check_period(table, faults)
+    if "turns" in table.columns and max(turns or 0 for turns in table.columns["turns"].values) > 50:
+        faults.add(TURNS_TOO_MANY, "more than 50 turns in one run", "is that a count of seconds?")
""",
    "A source of error": """
@ measurements/sources.py
 SOURCES: Mapping[str, SourceKind] = {
+    "ruler_scale": SourceKind("position", Uncertainty(0.0, 0.0005), "0.05 %", "all runs (a ruler)", "a ruler checked"),
@ measurements/sources.py
     zero = _of_whole_log(readings, "position_zero")
+    sources.append(_of_whole_log(readings, "ruler_scale"))
@ readings/roles.py
 SHARED_UNCERTAINTIES = {
+    "u_ruler_scale": "length",
@ reporting/phrases.py
 SOURCE_NAMES = {
+    "ruler_scale": "the ruler's scale",
@ simulation/noise.py
     for key in (
+        "ruler_scale",
@ simulation/noise.py
 _ERRORS = (
+    _Error("u_ruler_scale", ("position",), "log"),
""",
    "An effect": """
@ physics.py
+
+
+def buoyancy_bias(density: ArrayLike) -> Any:
+    \"\"\"Relative bias of I_zz when the air's lift on weights of a density [kg/m^3] is left out.\"\"\"
+    return np.divide(1.2, density)
@ effects.py
 EFFECTS = (
+    EffectKind("buoyancy", "lift of the air", lambda case: (physics.buoyancy_bias(7800), False, "steel")),
""",
    "A criterion of a rubric": """
@ grading/criteria.py
+
+
+def _repeats(criterion: Criterion, evidence: Evidence) -> Mark:
+    single = float(sum(torque.runs < 2 for torque in evidence.analysis.torques))
+    return mark(criterion, criterion.curve.share(single), f"{single:g} weights once", {"single": single})
+
+
+_JUDGES["repeats"] = _repeats
@ grading/rubric.py
-Check = Literal["log",
+Check = Literal["repeats", "log",
@ grading/rubric.py
 KINDS: dict[str, Kind] = {
+    "repeats": Kind("Each weight is timed twice", ("single",), "single <= 1", "single >= 4"),
@ grading/rubric.py
 MEANINGS = {
+    "single": "the number of weights timed once",
""",
    "A platform of a class": """
@ grading/platforms.py
     for platform in (
+        Platform(
+            "sakai",
+            "Doe, Jane(jdoe)/Submission attachment(s)/lab.csv",
+            _shapes(
+                r"(?P<stem>(?P<name>[^/]+)\\((?P<username>[^()/]+)\\))/Submission attachment[^/]*/(?P<file>.+)"
+            ),
+        ),
@ cli/grade_command.py
-Platform = Literal["auto",
+Platform = Literal["auto", "sakai",
""",
    "A figure": """
@ plotting/figures.py
-FIGURES = ("period",
+FIGURES = ("spins", "period",
@ plotting/figures.py
-_DRAWERS: dict[str, Callable[[Scene, Medium], Sheet]] = {
+def _draw_spins(scene: Scene, medium: Medium) -> Sheet:
+    sheet, count = medium.sheet(), len(scene.spin)
+    panel = Panel(sheet, medium.boxes(20, 2)[0], (0, count + 1), (0, scene.spin.max()))
+    draw_axes(panel, "run", "spin ψ̇ [rpm]")
+    panel.line(np.arange(1, count + 1), scene.spin, INK)
+    return sheet
+
+
+_DRAWERS: dict[str, Callable[[Scene, Medium], Sheet]] = {
+    "spins": _draw_spins,
@ plotting/figure_data.py
-    words = {"period"
+    words = {"spins": lambda analysis, scene: "The spins as read.", "period"
@ reporting/questions.py
         Figure("period", "Period τ against spin ψ̇, with the fitted law of each torque."),
+        Figure("spins", "The spin of each run."),
@ grading/feedback.py
 CAPTIONS = {
+    "spins": "The spins as you read them",
""",
}
"""By its name in the map."""

SCRIPT = """
import json, sys
import gyrodata
from gyrodata import plotting, reporting, simulation
from gyrodata.diagnostics import CODES, LOG
from gyrodata.readings import read_log
from gyrodata.units import Uncertainty

sample = open(sys.argv[1], encoding="utf-8").read()
lines = [line for line in sample.splitlines() if line[0] != "#"]
delayed = "\\n".join([lines[0] + ",Verzug [s]", *(line + ",0.5" for line in lines[1:])])
raised = read_log(CODES["G299"].example.encode()).diagnostics
analysis = gyrodata.analyze(sample.encode())
doubtful = gyrodata.analyze(("# u_ruler_scale: 2 %\\n" + sample).encode())
looks = plotting.list_looks(analysis)
figures = plotting.render(analysis)
alt = {name: plotting.alt_text(analysis, name) for name in figures}
print(json.dumps({
    "unit": read_log(LOG.replace("[g]", "[slug]").encode() + b"0.01,15,400,13,1").columns["mass"].values,
    "times": list(gyrodata.analyze(delayed.encode()).measurements.time - analysis.measurements.time),
    "raised": [d.severity for d in raised if d.code == "G299"],
    "effects": {effect.effect: effect.bias for effect in analysis.effects},
    "budget": {share.source: share.share for share in doubtful.fit.budget},
    "advice": doubtful.advice,
    "simulated": "ruler_scale" in str(simulation.simulate(
        simulation.Truth(), simulation.Design(), {"u_ruler_scale": Uncertainty(0.0, 0.1)}, 1).log),
    "report": reporting.markdown_report(doubtful),
    "page": reporting.report_page(analysis, figures, "png", alt, looks),
    "figure": figures["spins"][:4].hex(),
}))
"""

RUBRIC = """
schema = 1
points = 2
[[criterion]]
id = "twice"
check = "repeats"
points = 2
"""


def files_of(patch: str) -> list[tuple[str, list[str]]]:
    """Name each file of a patch, with its lines."""
    return [(part.partition("\n")[0], part.splitlines()[1:]) for part in patch.strip().removeprefix("@ ").split("\n@ ")]


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the package, and carry every recipe out on it."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(ROOT / "gyrodata", folder / "gyrodata", ignore=shutil.ignore_patterns("__pycache__"))
    for patch in RECIPES.values():
        for name, body in files_of(patch):
            path, text = folder / "gyrodata" / name, (folder / "gyrodata" / name).read_text(encoding="utf-8")
            old = "\n".join(line[1:] for line in body if line[0] != "+")
            new = "\n".join(line[1:] for line in body if line[0] != "-")
            assert old in text, f"{name} has no {old!r} any more"
            path.write_text(text.replace(old, new, 1) if old else text + new + "\n", encoding="utf-8")
    return folder


def run(copy: Path, *words: str | Path) -> Any:
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    done = subprocess.run([sys.executable, *words], cwd=copy, env=environment, capture_output=True, encoding="utf-8")
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def seen(copy: Path) -> Any:
    return run(copy, "-c", SCRIPT, ROOT / "sample_data" / "air_gyroscope.csv")


@pytest.fixture(scope="module")
def graded(copy: Path) -> Any:
    """A class of one, as Sakai packs it, graded by the new criterion."""
    home = copy / "class" / "Doe, Jane(jdoe)" / "Submission attachment(s)"
    home.mkdir(parents=True)
    shutil.copy(ROOT / "sample_data" / "air_gyroscope.csv", home / "lab.csv")
    (copy / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    options = ("--rubric", "rubric.toml", "--lms", "sakai", "--format", "json", "--workers", "1")
    return run(copy, "-m", "gyrodata", "grade", "class", *options)


def test_every_recipe_is_carried_out_and_the_other_way_round() -> None:
    # The other two are held by the tests of the schema and of the page.
    assert set(WRITTEN) == {*RECIPES, "A key of the JSON", "A sentence or a number of the report"}


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_names_every_file_that_it_takes_and_is_short(recipe: str) -> None:
    told = WRITTEN[recipe]
    assert [name for name, _ in files_of(RECIPES[recipe]) if f"`{name}`" not in told] == []
    assert len(told.strip().splitlines()) <= 6


def test_a_unit(seen: Any) -> None:
    assert seen["unit"] == [pytest.approx(0.14593902937)]


def test_a_role(seen: Any) -> None:
    assert seen["times"] == pytest.approx([0.5] * len(seen["times"]))


def test_a_diagnostic(seen: Any) -> None:
    assert seen["raised"] == ["warning"]


def test_a_source_of_error(seen: Any) -> None:
    assert seen["budget"]["ruler_scale"] > 0.5
    assert "a ruler checked" in " ".join(seen["advice"])
    assert "the ruler's scale" in seen["report"]
    assert seen["simulated"]


def test_an_effect(seen: Any) -> None:
    assert seen["effects"]["buoyancy"] == pytest.approx(1.2 / 7800)
    assert "lift of the air" in seen["report"]


def test_a_figure(seen: Any) -> None:
    assert seen["figure"] == b"\x89PNG".hex()
    assert "The spins as read." in seen["page"]
    assert "The spin of each run." in seen["page"]


def test_a_criterion_of_a_rubric(graded: Any) -> None:
    (mark,) = graded["students"][0]["marks"]
    assert (mark["title"], mark["points"]) == ("Each weight is timed twice", 2)


def test_a_platform_of_a_class(graded: Any) -> None:
    (student,) = graded["students"]
    assert graded["input"]["lms"] == "sakai"
    assert (student["student"], student["name"]) == ("jdoe", "Doe, Jane")
