"""A class: submissions in; grades, feedback and flags out.

Read `grade` for one student and `classroom` for a class.
"""
