"""The benchmark: cost against error, and maps of where methods fail.

`fits` compares programs on simulated labs of a known truth (`labs`), `motions` models
of the motion, `integrators` ways to compute it, and `maps` shows for two quantities
each where a method fails and what gyro does there. `report` runs all parts and writes
the page. Everything except times is the same for the same seed.
"""
