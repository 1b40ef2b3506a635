"""A class: submissions in; grades, feedback and flags out."""
