"""Gate 5: `gyrodata.fit_line` gives the published answers, to all the digits that are published.

NIST StRD (Norris, NoInt1, NoInt2), York and Pearson (York et al. 2004, and the same line with 16 digits), and the
examples of ISO/TS 28037 with equal and unequal weights and with errors in x and y.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import gyrodata
from gates.stored import Found

NORRIS_X = """0.2 337.4 118.2 884.6 10.1 226.5 666.3 996.3 448.6 777.0 558.2 0.4 0.6 775.5 666.9 338.0 447.5 11.6
    556.0 228.1 995.8 887.6 120.2 0.3 0.3 556.8 339.1 887.2 999.0 779.0 11.1 118.3 229.2 669.1 448.9 0.5"""
NORRIS_Y = """0.1 338.8 118.1 888.0 9.2 228.1 668.5 998.5 449.1 778.9 559.2 0.3 0.1 778.1 668.8 339.3 448.9 10.8
    557.7 228.3 998.0 888.8 119.6 0.3 0.6 557.6 339.3 888.0 998.5 778.9 10.2 117.6 228.9 668.4 449.2 0.2"""
YORK_X, YORK_Y = (np.array(text.split(), dtype=float) for text in (
    "0.0 0.9 1.8 2.6 3.3 4.4 5.2 6.1 6.5 7.4", "5.9 5.4 4.4 4.6 3.5 3.7 2.8 2.8 2.4 1.5"))  # fmt: skip
YORK_WX, YORK_WY = np.array([1e3, 1e3, 500, 800, 200, 80, 60, 20, 1.8, 1]), [1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500]

CASES: dict[str, tuple[dict[str, Any], str]] = {
    "NIST Norris": ({"x": np.array(NORRIS_X.split(), dtype=float), "y": np.array(NORRIS_Y.split(), dtype=float)},
        "1.00211681802045 0.429796848199937e-03 -0.262323073774029 0.232818234301152 26.6173985294224"),
    "NIST NoInt1": ({"x": np.arange(60.0, 71), "y": np.arange(130.0, 141), "intercept": False},
        "2.07438016528926 0.165289256198347e-01"),
    "NIST NoInt2": ({"x": [4, 5, 6], "y": [3, 4, 4], "intercept": False}, "0.727272727272727 0.420827318078432e-01"),
    "York and Pearson": ({"x": YORK_X, "y": YORK_Y, "cov_x": 1 / YORK_WX, "cov_y": 1 / np.array(YORK_WY)},
        "-0.4805334074462020 0.05798500900077444 5.479910224032854 - 11.8663531941"),
    "ISO/TS 28037, equal weights": (
        {"x": np.arange(1.0, 7), "y": [3.3, 5.6, 7.1, 9.3, 10.7, 12.1], "cov_y": 0.25},
        "1.757 0.120 1.867 0.465 1.665"),
    "ISO/TS 28037, unequal weights": (
        {"x": np.arange(1.0, 7), "y": [3.2, 4.3, 7.6, 8.6, 11.7, 12.8], "cov_y": np.repeat([0.25, 1], 3)},
        "2.057 0.178 0.885 0.530 4.131"),
    "ISO/TS 28037, errors in x and y": (
        {"x": [1.2, 1.9, 2.9, 4.0, 4.7, 5.9], "y": [3.4, 4.4, 7.2, 8.5, 10.8, 13.5], "cov_x": np.full(6, 0.04),
         "cov_y": np.repeat([0.04, 0.16], 3)}, "2.1597 0.1355 0.5788 0.4764 2.743"),
}  # fmt: skip
"""What is fitted; slope, u, intercept, u and chi-square as published."""


def gate(accept: bool = False, part: bool = False) -> Found:
    """Fit the published lines."""
    wrong, count = [], 0
    for name, (data, published) in CASES.items():
        line = gyrodata.fit_line(**data)
        fields = ("slope", "u_slope", "intercept", "u_intercept", "chi2")
        for field, text in zip(fields, published.split(), strict=False):
            if text != "-":
                number, _, power = text.partition("e")
                # Half of the last digit, and what a double read from decimals may be off.
                last = 0.5 * 10.0 ** (int(power or 0) - len(number.partition(".")[2]))
                count += 1
                if abs(getattr(line, field) - float(text)) > max(last, 2e-14 * abs(float(text))):
                    wrong.append(f"{name}, {field}: {text} | {getattr(line, field)!r}")
    return Found(f"{count - len(wrong)} of {count} published numbers", "all", not wrong, wrong)
