"""Trials of methods: simulated logs, coverage of intervals, speed against accuracy.

A true gyroscope goes in, and what the methods make of its logs comes out. Nothing here
is needed to analyse a log.
"""
