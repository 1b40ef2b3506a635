"""Gate 5: `gyrodata.fit_line` gives the published answers, to all the digits that are
published.

NIST StRD (Norris, NoInt1, NoInt2), York and Pearson (York et al. 2004, and the same
line with 16 digits), and the examples of ISO/TS 28037 with equal and unequal weights
and with errors in x and y."""

from __future__ import annotations

import tomllib

import gyrodata
from gates.stored import HERE, Found


def gate(accept: bool = False, part: bool = False) -> Found:
    """Fit the published lines."""
    wrong, count = [], 0
    for name, data in tomllib.loads(
        (HERE / "published.toml").read_text(encoding="utf-8")
    ).items():
        published = data.pop("published")
        line = gyrodata.fit_line(**data)
        fields = ("slope", "u_slope", "intercept", "u_intercept", "chi2")
        for field, text in zip(fields, published.split(), strict=False):
            if text != "-":
                number, _, power = text.partition("e")
                # Half of the last digit, and what a double read from decimals may be
                # off.
                last = 0.5 * 10.0 ** (int(power or 0) - len(number.partition(".")[2]))
                count += 1
                if abs(getattr(line, field) - float(text)) > max(
                    last, 2e-14 * abs(float(text))
                ):
                    wrong.append(f"{name}, {field}: {text} | {getattr(line, field)!r}")
    return Found(
        f"{count - len(wrong)} of {count} published numbers", "all", not wrong, wrong
    )
