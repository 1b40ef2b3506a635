"""Whole classes of simulated students: what those lose who worked well, and what is
found of the rest.
"""
