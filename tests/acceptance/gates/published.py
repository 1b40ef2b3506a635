"""Gate 5: `gyrodata.fit_line` gives the published answers, to all the digits that are
published; and the shares of labs on a page are those of ``gyro selfcheck``.

NIST StRD (Norris, NoInt1, NoInt2), York and Pearson (York et al. 2004, and the same
line with 16 digits), and the examples of ISO/TS 28037 with equal and unequal weights
and with errors in x and y."""

from __future__ import annotations

import json
import re
import tomllib
from functools import cache

from places import PACKAGE, SAMPLES
from typer.testing import CliRunner

import gyrodata
from gates.stored import HERE, Found
from gyrodata.cli import app

FITS = ("recommended", "through_origin", "with_constant")
SHARES = (
    r"(\d+) labs, the 95 % interval of the recommended fit contains the true value in "
    r"([\d.]+) %; ± 2u of the line without an intercept in ([\d.]+) %, and of the line "
    r"with an intercept in ([\d.]+) %"
)


def shares_of_the_page() -> list[float]:
    """Return the number of simulated labs, and how often [%] each fit contains the truth."""
    page = (PACKAGE / "docs" / "statistics.md").read_text(encoding="utf-8")
    (told,) = re.findall(SHARES, " ".join(page.split()))
    return [float(number) for number in told]


@cache
def shares_of_the_sample(labs: int) -> dict[str, float]:
    """Simulate labs like the sample; return how often [%] each fit contains the truth."""
    sample = str(SAMPLES / "air_gyroscope.csv")
    words = ["selfcheck", sample, "--labs", str(labs), "--format", "json"]
    found = json.loads(CliRunner().invoke(app, words).stdout)
    return {one["name"]: 100 * one["coverage_95"] for one in found["estimators"]}


def other_shares() -> list[str]:
    """List the shares on the page that are not those of so many labs."""
    labs, *told = shares_of_the_page()
    found = shares_of_the_sample(round(labs))
    return [
        f"{name} in the documentation: {share:.1f} % | {found[name]:.1f} %"
        for name, share in zip(FITS, told, strict=True)
        if f"{share:.1f}" != f"{found[name]:.1f}"
    ]


def gate(accept: bool = False, part: bool = False) -> Found:
    """Fit the published lines; and, but for a part, simulate the labs of the page."""
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
    if not part:
        wrong += other_shares()
        count += len(FITS)
    return Found(
        f"{count - len(wrong)} of {count} published numbers", "all", not wrong, wrong
    )
