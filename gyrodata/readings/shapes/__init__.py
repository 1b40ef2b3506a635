"""Tables in other forms than one header row with one row for each run.

Each module of this folder reads one form. Most logs need none of them.
"""
