"""Does the tool still behave the same, seen from outside? ``python tests/gates``
answers in a few minutes.
"""
