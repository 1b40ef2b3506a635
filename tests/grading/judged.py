"""Reports and logs of every kind, and all that is decided about each: the golden text of the marks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from grading.reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.grading import (
    Grade,
    Mark,
    Rubric,
    Submission,
    default_rubric_text,
    grade_submission,
    read_rubric,
    results_json,
    settle,
)

STATION = '[reference.all]\ninertia = "4.44e-3 kg m^2"\nu = "0.02e-3 kg m^2"'
FULL = default_rubric_text().replace('[reference]\nfrom = "class"', STATION)
BENCH = '[bench]\nfrom = "class"\n'

PLAIN = f"""schema = 1
points = 10
accept = ["with_constant", "mean_of_ratios", "through_origin"]
no_report = "zero"
criterion = [
  {{ id = "own", check = "own_data", points = 3, full = "percent <= 2", zero = "percent >= 6", slip = 1 }},
  {{ id = "reference", check = "reference", points = 3, full = "percent <= 5", zero = "percent >= 15" }},
  {{ id = "u", check = "uncertainty", points = 1, full = "stated >= 1", zero = "stated <= 0" }},
  {{ id = "plot", check = "files", points = 1, full = "files >= 2", zero = "files <= 0" }},
  {{ id = "spread", check = "constancy", points = 1, full = "spread <= 0.02", zero = "spread >= 0.2" }},
  {{ id = "talk", check = "manual", points = 1 }},
]
{STATION}
"""
"""A rubric with the other variable of each kind."""


class Scene(Struct, frozen=True):
    """One submission, and the rubric that it is judged by."""

    name: str
    log: str
    rubric: str = FULL
    members: tuple[str, ...] = ()


ROWS = sheet(np.random.default_rng(3), turns="mixed")
VALUE, U = RIGHT.inertia(ROWS, "through_origin")

TEXTS = (
    *(f"{factor * VALUE:.5e} ± 3.5e-5 kg m^2" for factor in (0.7, 0.95, 0.98, 1.02, 1.05, 1.08, 1.3, 1.9, -1.3)),
    *(f"{factor * VALUE:.3e} kg m^2" for factor in (1.0, 1.03, 2.4, 2.6)),
    *(f"{VALUE:.4e} ± {times}e-5 kg m^2" for times in (0.2, 0.5, 0.7, 1.3, 1.5, 2, 2.7, 9.1, 17, 19, 30, 60)),
    "1e-6 kg m^2 ± 1 %", "0.99e-6 kg m^2 ± 1 %", "100 kg m^2 ± 1 %", "101 kg m^2 ± 1 %", "-100 kg m^2 ± 1 %",
    "0 kg m^2", "0.000 ± 0.001 kg m^2", "about four", "4.4e-3 ± 0.1e-3 furlongs", "4.4e-3 ± 0.1e-3",
    "44400 ± 200 g cm^2", "44370 ± 200 g cm^2", "44374 ± 200 g cm^2", "44000 ± 200 g cm^2", "44400 ± 240 g cm^2",
    "44400 ± 2 g cm^2", "44400 ± 234 g cm^2", "4.44e-3 ± 0.10e-3 (k=2) kg m^2", "4.44e-3 ± 0.102e-3 (k=2) kg m^2",
    "4.444e-3 ± 0.102e-3 (k=2) kg m^2", "4.4444e-3 ± 0.1023e-3 (k=2) kg m^2", "4.4e-3 ± 0.19e-3 (k=2) kg m^2",
    "4.4442e-3 ± 0.9 % kg m^2", "4.44423e-3 kg m^2", "4.444231e-3 kg m^2", "4.4442311e-3 kg m^2",
    "4e-3 ± 0.02e-3 kg m^2", "1.500e-2 kg m^2 ± 10 %", "1.5000e-2 kg m^2 ± 10 %",
    "0.00444(5) kg m^2", "4.44e-3 +- 0.05e-3", "44e3 ± 2000 g cm^2", "44000 ± 2e3 g cm^2",
    "44400 ± 2e3 g cm^2", "44e3 ± 2100 g cm^2", "4.4e4 ± 200 g cm^2", "4.44e-3 ± 0.10e-3 (k=1.6) kg m^2",
    "4.44e-3 ± 0 kg m^2", "44000 g cm^2", "44400.00 g cm^2", "-4.388e-3 kg m^2",
    "0.000000 kg m^2", "0.0 kg m^2",
)  # fmt: skip
"""What stands behind reported_inertia in the log of the first scene."""


def log(*head: str, rows: Sheet = ROWS, reported: str | None = None) -> str:
    """A log whose report is that of its own runs, if it is not given."""
    line = reported_line(*RIGHT.inertia(rows, "through_origin")) if reported is None else reported
    return rows.log(*head, line)


def drawn(seed: int, **changes: Any) -> Sheet:
    return sheet(np.random.default_rng(seed), **changes)


def times(*factors: float) -> Sheet:
    """The rows with their times made longer, one factor after the other."""
    return replace(ROWS, time=ROWS.time * np.resize(factors, len(ROWS.time)))


def with_rows(text: str, *rows: str) -> str:
    return text + "".join(f"{row}\n" for row in rows)


def scenes() -> Iterator[Scene]:
    """All scenes; the first is a good report."""
    yield Scene("good", log())
    for text in TEXTS:
        yield Scene(text, log(reported=f"# reported_inertia: {text}"))
    for text in ("about four", *TEXTS[:6], *TEXTS[9:13], "0 kg m^2"):
        yield Scene(f"{text}, plain", log(reported=f"# reported_inertia: {text}"), PLAIN, ("a.csv", "P.PDF"))
    for fit in ("with_constant", "mean_of_ratios"):
        yield Scene(f"by {fit}", log(reported=reported_line(*RIGHT.inertia(ROWS, fit))))
    for kind, formula in SLIPS.items():
        yield Scene(kind, log(reported=reported_line(*formula.inertia(ROWS, "through_origin"))))
    for kind in ("g_as_kg", "two_pi_missing", "turns_forgotten"):
        line = reported_line(*SLIPS[kind].inertia(ROWS, "mean_of_ratios"))
        yield Scene(f"{kind}, plain", log(reported=line), PLAIN, ("a.csv", "b.png", "c.jpeg"))
        yield Scene(f"{kind}, not asked for", log(reported=line), without(PLAIN, "own", 7))
    for answer in (1 / VALUE, 1.01 / VALUE, 1.04 / VALUE):
        yield Scene(f"upside down, {answer:.1f}", log(reported=f"# reported_inertia: {answer:.4g} ± 1.8 kg m^2"))
    yield Scene("nothing reported", ROWS.log())
    yield Scene("nothing reported, plain", ROWS.log(), PLAIN, ("a.csv", "b.tiff", "b.PNG", "c.txt"))
    mean, its_u = RIGHT.inertia(ROWS, "mean_of_ratios")
    one_fit = FULL.replace('["through_origin", "with_constant", "mean_of_ratios", "recommended"]', '["mean_of_ratios"]')
    for share in (0.88, 0.92, 1.0, 1.08, 1.12):
        line = f"# reported_inertia: {mean:.5e} ± {3 * share * its_u:.4e} kg m^2"
        yield Scene(f"u of a single run, {share}", log(reported=line), one_fit)
    ours = one_fit.replace('["mean_of_ratios"]', '["recommended"]')
    for factor in (1000.0, 60 / (2 * np.pi), 1 / 9.803, 1.2):
        line = reported_line(factor * 4.4373e-3, factor * 5.1e-5)
        yield Scene(f"{factor:.4g} times the recommended fit", log(reported=line), ours)
    loaded = with_rows(log(reported=f"# reported_inertia: {mean:.5e} ± {3 * its_u:.4e} kg m^2"), "0,,400,163.1,1/3")
    yield Scene("u of a single run, one without a weight", with_rows(loaded, "0,,600,241.2,1/3"), one_fit)
    unknown = [f"# u_tme{at}: 0.2 s" for at in range(5)]
    for count in (1, 3, 4, 5):
        yield Scene(f"{count} unknown keys", log(*unknown[:count]))
    yield Scene("two weights", log(rows=drawn(3, weights=(0.02, 0.05))))
    yield Scene("two weights, near spins", log(rows=drawn(3, weights=(0.02, 0.05), rpm=(300.0, 310.0))))
    yield Scene("one spin", log(rows=drawn(3, rpm=(400.0,)), reported=""))
    yield Scene(
        "one torque", log(rows=drawn(5, weights=(0.04,)), reported="# reported_inertia: 4.5e-3 ± 0.1e-3 kg m^2")
    )
    all_of_it = 'asks = ["weights", "runs", "spins", "unloaded", "times", "falling_spin", "odd_runs"]'
    strict = FULL.replace('asks = ["weights", "runs", "spins"]', all_of_it)
    yield Scene("asked for all", log(rows=drawn(3, weights=(0.02, 0.05, 0.2), turns=1 / 3)), strict)
    for factors in ((1.0, 1.03, 0.97), (1.0, 1.06, 0.95), (1.0, 1.12, 0.9), (1.0, 2.0, 1.0), (1.0, 9.0, 1.0)):
        rows = times(*factors)
        yield Scene(f"times {factors}", log(rows=rows))
        yield Scene(f"times {factors}, 0.4 s stated", log("# u_time: 0.4 s", rows=rows))
        yield Scene(f"times {factors}, plain", log(rows=rows), PLAIN)
    for line in ('u_time = "0.3 s"', 'u_spin = "3 %"', 'u_mass = "1 g"', 'u_time_bias = "0.3 s"'):
        yield Scene(f"bench: {line}", log(rows=times(1.0, 1.06, 0.95)), FULL.replace(BENCH, f"[bench]\n{line}\n"))
    same = [np.repeat(one[::3], 3) for one in (ROWS.mass, ROWS.position, ROWS.spin, ROWS.time, ROWS.turns)]
    yield Scene("every run three times", log(rows=Sheet(*same)))
    other_side = with_rows(log(), *(f"30.00,-15.00,{spin},{0.63 * spin / 30:.2f},1" for spin in (210, 405, 598)))
    yield Scene("both sides", other_side)
    yield Scene("a run without a weight", with_rows(log("# Station:  Bench  B "), "0,,400,163.1,1/3"))
    yield Scene("two runs without a weight", with_rows(log(), "0,,400,163.1,1/3", "0,,600,241.2,1/3"))
    miscounted = ROWS.turns.copy()
    miscounted[4] *= 2
    yield Scene("a miscounted run", log(rows=replace(ROWS, turns=miscounted)))
    yield Scene("nothing known of I_zz", log(rows=times(*np.random.default_rng(1).uniform(0.55, 1.6, 9))))
    for exact in ("# u_time: 0.01 s", "# u_time: 9 s"):
        yield Scene(
            exact, log(exact, "# u_time_bias: 0 s", "# u_spin: 0.01 %", "# balanced: yes", rows=drawn(3, noise=0.0))
        )
    both = sheet(np.random.default_rng(7), turns=1 / 3, imbalance=0.001)
    for digits in (1, 2):
        line = reported_line(*SLIPS["missing_g"].inertia(both, "with_constant"), digits)
        yield Scene(f"no g or rpm, {digits}", log(rows=both, reported=line))
    yield Scene("unknown slip", log(reported=reported_line(*Formula(answer=1.3).inertia(ROWS, "through_origin"))))
    titles = "mass [g],position [cm],spin [rpm],time [s],turns\n"
    broken = {
        "no table": "hello\n", "no bytes": "", "no rows": titles, "no number": f"{titles}20,15,400,x,1\n",
        "two faults": f"{titles}20,15,400,x,1\n20,15,y,13,1\n", "no weight": f"{titles}0,15,400,13.1,1\n" * 2,
        "one run": f"{titles}20,15,400,13.1,1/3\n", "no spin": "mass [g],position [cm],time [s],turns\n20,15,13,1\n",
        "a spin of 0": f"{titles}20,15,0,13,1\n20,15,400,13,1\n", "no number by far": f"{titles}1e300,15,1e-300,13,1\n",
    }  # fmt: skip
    for name, text in broken.items():
        yield Scene(name, text)


def without(rubric: str, id_: str, points: int) -> str:
    """A rubric without one criterion, worth less."""
    lines = [line for line in rubric.splitlines() if f'id = "{id_}"' not in line]
    return "\n".join(lines).replace("points = 10", f"points = {points}", 1)


def judge(scene: Scene, rubric: Rubric, folder: Path, alone: bool = True) -> Grade:
    (folder / "lab.csv").write_text(scene.log, encoding="utf-8")
    one = Submission("s1", "Ann", {}, folder, scene.members, log_name="lab.csv")
    grade = grade_submission(one, rubric)
    return settle([grade], rubric)[0][0] if alone else grade


def number(value: float | str | None) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def pairs(known: Any) -> str:
    return ", ".join(f"{key} {number(value)}" for key, value in known.items())


def told(grade: Grade, before: tuple[Mark, ...]) -> Iterator[str]:
    """Tell all of a grade, of its marks those that were not there before."""
    yield f"{grade.status} {grade.points}, why {grade.why}, station {grade.station}, {pairs(grade.reported)}"
    yield f"matched {grade.matched}, d {number(grade.d)}, z {number(grade.zeta)}, ratio {number(grade.ratio)}"
    yield f"I_zz {number(grade.inertia)} ± {number(grade.inertia_u)}, bench {grade.bench}"
    yield "scatters " + ", ".join(f"{number(chi2)} of {dof}" for chi2, dof in grade.scatters)
    yield from (f"look {look}" for look in grade.look)
    yield from (f"own {name}: {pairs(own)}" for name, own in grade.own.items())
    for slip in grade.slips:
        numbers = f"{number(slip.factor)} by {slip.fit} ± {number(slip.u)}, {number(slip.distance)} u away"
        yield f"slip {slip.kind} {numbers}: {slip.words} | {slip.check}"
    for mark in grade.marks:
        if mark not in before:
            yield f"{mark.criterion} {number(mark.points)} of {mark.out_of:g}: {mark.reason} | {pairs(mark.detail)}"
            if mark.rule not in ["", *(one.rule for one in before)]:
                yield f"  {mark.rule}"


def judged(folder: Path, first: int = 0, step: int = 1) -> Iterator[str]:
    """Judge every so manieth scene; of each is told what is another than in the first of all."""
    rubrics: dict[str, Rubric] = {}
    every = list(scenes())
    base: tuple[Mark, ...] = ()
    seen: set[str] = set()
    for scene in every[:1] + every[first::step][not first :]:
        rubric = rubrics.setdefault(scene.rubric, read_rubric(scene.rubric.encode()))
        grade = judge(scene, rubric, folder)
        lines = [line for line in told(grade, base) if line not in seen]
        if base or not first:
            yield "".join(f"{line}\n" for line in (f"== {scene.name}", *lines))
        seen = seen or {line for line in lines if line.startswith(("own ", "I_zz ", "scatters ", "  "))}
        base = base or grade.marks


def classes(folder: Path) -> Iterator[str]:
    """Settle classes in which the class itself is the reference, and tells how far the readings scatter."""
    rubric = read_rubric(default_rubric_text().encode())
    stations = {"rough": (9, 0.3), "Usual Bench": (8, 0.11), "few": (5, 0.5), "": (4, 0.4)}
    grades = []
    for at, (station, (count, noise)) in enumerate(stations.items()):
        for seed in range(count):
            rows = drawn(100 * at + seed, turns="mixed")
            hand = np.random.default_rng([at, seed]).normal(0, noise, len(rows.time))
            scene = Scene(
                "",
                log(f"# station: {station}", rows=replace(rows, time=np.round((1 + 0.003 * at) * rows.time + hand, 2))),
            )
            grades.append(replace(judge(scene, rubric, folder, False), student=f"{station} {seed}"))
    for name, some in {"all": grades, "seven": grades[:7], "eight": grades[9:17], "four": grades[-4:]}.items():
        settled, references, scatters = settle(some, rubric)
        lines = [f"{key}: {number(one.inertia)} ± {number(one.u)}, {one.words}" for key, one in references.items()]
        lines += [f"{key}: {number(one.factor)}, {one.words}" for key, one in scatters.items()]
        for one in settled:
            lines.append(f"{one.student} {one.points} z {number(one.zeta)}")
            lines += [f"  {mark.points} {mark.reason} | {pairs(mark.detail)}" for mark in (one.marks[3], one.marks[6])]
        yield "".join(f"{line}\n" for line in (f"== class: {name}", *lines))


BACK = (
    "good", "nothing reported", "rpm_as_rad_s", "two_pi_missing, plain", "nothing reported, plain", "3 unknown keys",
    "times (1.0, 2.0, 1.0)", "times (1.0, 2.0, 1.0), plain", "no number", "two faults", "two weights",
    "44400 ± 234 g cm^2", "a miscounted run", "4e-3 ± 0.02e-3 kg m^2", "unknown slip", "both sides",
)  # fmt: skip
"""Scenes of which is told what Gradescope shows."""


def handed_back(folder: Path) -> Iterator[str]:
    """What Gradescope is told, in time and late."""
    for scene in scenes():
        if scene.name in BACK:
            grade = judge(scene, read_rubric(scene.rubric.encode()), folder)
            late = replace(grade, late_deduction=1.5, late_reason="2 h late")
            text = results_json(grade) + results_json(late).split('"tests"')[0]
            yield f"== {scene.name}\n{re.sub('[0-9a-f]{64}', 'DIGEST', text)}\n"
