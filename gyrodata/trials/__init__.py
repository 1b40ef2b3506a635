"""Trials of methods: simulated logs, coverage of intervals, speed against accuracy.

A true gyroscope goes in, and what the methods make of its logs comes out. Nothing here
is needed to analyse a log.

There are two simulators. `simulation` invents a lab and types its log, as a student
does. `coverage.draw` repeats the lab of a log that exists, with each of its own sources
of error, and types nothing.
"""
