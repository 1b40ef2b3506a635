"""Does the tool still behave the same, seen from outside? ``python
tests/acceptance/gates`` answers in a few minutes.
"""
