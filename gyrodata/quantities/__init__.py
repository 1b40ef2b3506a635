"""Quantities: kinds and units, numbers with ± as people write them, and words for them.

A text goes in, and an SI number with its last digit, uncertainty and kind comes out.
Nothing here knows a table or a run.
"""
