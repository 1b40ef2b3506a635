"""Grades in the forms that gradebooks take: a plain CSV, Canvas, Moodle, Gradescope."""
