"""Answers just inside and outside of what earns points, and in forms that are easily
misread: each gets the points of the rubric, or a person is asked.
"""

from __future__ import annotations

from typing import Any

import pytest
from classes.class_cells import grade
from classes.drawn import USUAL, draw
from msgspec.structs import replace

STUDENT = draw(3, 21, replace(USUAL, hand=0.08))
VALUE = STUDENT.answer()[0]
STEPS = (0.4, 0.5, 0.55, 0.65, 0.7, 0.95, 1.05, 1.5, 1.95, 2.05, 2.5, 2.9, 2.95, 3.05)
"""Distances from the nearest fit of the own runs, in u."""
THOUSANDTHS = 1e3 * VALUE
FORMS = {
    f"{THOUSANDTHS:.1f}e-3 ± 0.1e-3 kg m^2": (round(THOUSANDTHS, 1) * 1e-3, 1e-4),
    f"{THOUSANDTHS:.1f}e-3 kg m^2": (round(THOUSANDTHS, 1) * 1e-3, None),
    f"{THOUSANDTHS:.2f}(6)e-3 kg m^2": (round(THOUSANDTHS, 2) * 1e-3, 6e-5),
    f"{THOUSANDTHS:.3f}(60)e-3 kg m^2": (round(THOUSANDTHS, 3) * 1e-3, 6e-5),
    f"({THOUSANDTHS:.2f} ± 0.12)e-3 kg m^2 (k = 2)": (
        round(THOUSANDTHS, 2) * 1e-3,
        6e-5,
    ),
    f"{VALUE:.5f} kg m^2 ± 600 g cm^2": (round(VALUE, 5), 6e-5),
    f"{VALUE:.5f} kg m^2 ± 20 %": (round(VALUE, 5), 0.2 * round(VALUE, 5)),
    f"{VALUE:.5f} ± 0.00006": (round(VALUE, 5), 6e-5),
    f"{VALUE * 1e4:.1f} ± 0.6 kg cm^2": (round(VALUE * 1e4, 1) * 1e-4, 6e-5),
    f"{VALUE * 1e3:.2f} ± 0.06 g m^2": (round(VALUE * 1e3, 2) * 1e-3, 6e-5),
    f"{VALUE:.5f} ± 0.00006 N m s^2": (round(VALUE, 5), 6e-5),
    f"{THOUSANDTHS:.2f}".replace(".", ",") + "e-3 ± 0,06e-3 kg m^2": (
        round(THOUSANDTHS, 2) * 1e-3,
        6e-5,
    ),
    f"-{THOUSANDTHS:.2f}e-3 ± 0.06e-3 kg m^2": (-round(THOUSANDTHS, 2) * 1e-3, 6e-5),
    f"{THOUSANDTHS:.2f}e-2 ± 0.06e-2 kg m^2": (round(THOUSANDTHS, 2) * 1e-2, 6e-4),
}


def answered(*texts: str) -> list[dict[str, Any]]:
    files = {
        f"s{i:03d}/lab.csv": STUDENT.log(f"# reported_inertia: {text}")
        for i, text in enumerate(texts)
    }
    return list(grade(files, "--lms", "folder")["students"].values())


def mark(student: dict[str, Any], check: str) -> dict[str, Any]:
    (found,) = [each for each in student["marks"] if each["check"] == check]
    return dict(found)


@pytest.mark.slow
def test_points_follow_from_the_distance() -> None:
    (right,) = answered(f"{VALUE:.7f} ± 0.0000600 kg m^2")
    fits = [fit["value"] for fit in right["own"].values()]
    (far,) = answered(f"{1.1 * max(fits):.7f} ± 0.0000600 kg m^2")
    unit = 0.1 / far["d"]
    steps = [(step, side) for step in STEPS for side in (-1, 1)]
    values = [
        (max(fits) if side > 0 else min(fits)) * (1 + side * step * unit)
        for step, side in steps
    ]
    texts = [f"{value:.7f} ± 0.0000600 kg m^2" for value in values]
    for (step, _), student in zip(steps, answered(*texts), strict=True):
        points = 6 * min(1.0, max(0.0, (3 - step) / 2.4))
        assert mark(student, "own_data")["points"] == pytest.approx(points, abs=0.03)
        assert bool(student["look"]) == (step > 3)


@pytest.mark.slow
def test_forms_that_are_easily_misread() -> None:
    for text, student in zip(FORMS, answered(*FORMS), strict=True):
        value, u = FORMS[text]
        assert student["reported"]["value"] == pytest.approx(value, rel=1e-9), text
        assert student["reported"]["u"] == (u and pytest.approx(u, rel=1e-9)), text
        is_right = abs(value / VALUE - 1) < 0.02
        full = 6 if is_right else 3
        assert mark(student, "own_data")["points"] == full, text
        assert [slip["kind"] for slip in student["slips"]] == [] or not is_right


@pytest.mark.slow
def test_digits_of_answers() -> None:
    wrong = {
        f"{VALUE:.5f} ± 0.00006": 1,
        f"{THOUSANDTHS:.3f}e-3 ± 0.0613e-3 kg m^2": 0,
        f"{THOUSANDTHS:.2f}e-3 ± 9e-3 kg m^2": 1,
        f"{THOUSANDTHS:.1f}e-3 ± 0.006e-3 kg m^2": 1,
        f"{VALUE:.9f} kg m^2": 1,
        f"{THOUSANDTHS:.2f}e-3 ± 0.06e-3 kg m^2": 2,
        f"{THOUSANDTHS:.1f}e-3 kg m^2": 2,
    }
    for (text, points), student in zip(wrong.items(), answered(*wrong), strict=True):
        assert mark(student, "units")["points"] == points, text
