"""A class: submissions in; grades, feedback and flags out.

A folder or zip of submissions and a rubric go in; a `ClassGrades` comes out, with the
points, their reasons, and flags. A submission that cannot be judged raises no error: it
is "not graded", without points. A flag never takes points.

Read `grade` for one student and `classroom` for a class.
"""
