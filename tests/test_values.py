"""Numbers as text: rounded to two digits of the uncertainty, in a unit that reads well."""

from __future__ import annotations

import re
from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata.reporting.values import inertia_text, number_text

UP = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
SIZES = st.floats(1e-9, 1e9)
SIGNED = st.builds(lambda size, sign: sign * size, SIZES, st.sampled_from([-1.0, 1.0])) | st.just(0.0)
RATIOS = st.floats(1e-7, 1e3)


def plain_parts(text: str) -> tuple[Decimal, Decimal, Decimal]:
    """Value, u and the worth of their last digit, of "(1.235 ± 0.012) × 10⁵"."""
    found = re.fullmatch(r"\(?(-?[\d.]+) ± ([\d.]+)\)?(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    assert found, text
    power = Decimal(10) ** int((found[3] or "0").translate(UP))
    value, u = Decimal(found[1]), Decimal(found[2])
    assert value.as_tuple().exponent == u.as_tuple().exponent, "both end at the same place"
    last = Decimal(10) ** int(u.as_tuple().exponent)
    return value * power, u * power, last * power


def significant(u: Decimal) -> int:
    return len(u.normalize().as_tuple().digits)


@given(SIGNED, RATIOS, SIZES)
@settings(derandomize=True, deadline=None, max_examples=300)
def test_a_number_is_rounded_to_two_digits_of_u(value: float, ratio: float, size: float) -> None:
    u = ratio * (abs(value) or size)
    text = number_text(value, u)
    shown, shown_u, last = plain_parts(text)
    half, slack = last / 2, 1 + Decimal("1e-9")
    assert significant(shown_u) <= 2
    assert 10 * last <= shown_u < 100 * last or shown_u == 100 * last, "u has two digits"
    assert abs(shown_u - Decimal(u)) <= half * slack
    assert abs(shown - Decimal(value)) <= half * slack + abs(Decimal(value)) * Decimal("1e-14")
    assert not text.startswith(("-0 ", "(-0 ")), text
    if shown == 0:
        assert "-" not in text.partition("±")[0]


@pytest.mark.parametrize(
    ("value", "u", "plain", "short"),
    [
        (4.44e-3, 0.06e-3, "(4.440 ± 0.060) × 10⁻³ kg·m²", "4.440(60)e-3 kg·m²"),
        (4.4412e-3, 0.0234e-3, "(4.441 ± 0.023) × 10⁻³ kg·m²", "4.441(23)e-3 kg·m²"),
        (1.5, 0.12, "1.50 ± 0.12 kg·m²", "1.50(12) kg·m²"),
        (4.4e-3, 7e-3, "(4.4 ± 7.0) × 10⁻³ kg·m²", "4.4(7.0)e-3 kg·m²"),
        (4.4e-3, None, "4.4 × 10⁻³ kg·m²", "4.4e-3 kg·m²"),
    ],
)
def test_moments_of_inertia_as_they_are_read(value: float, u: float | None, plain: str, short: str) -> None:
    assert inertia_text(value, u) == plain
    assert inertia_text(value, u, "short") == short


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (-1e-9, 0.3, "0.00 ± 0.30"),
        (-4.0, 120.0, "(0.0 ± 1.2) × 10²"),
        (-0.0012, 0.0003, "-0.00120 ± 0.00030"),
        (123456.0, 1200.0, "(1.235 ± 0.012) × 10⁵"),
        (9.9996, 0.0996, "10.00 ± 0.10"),
    ],
)
def test_rounding_at_the_edges(value: float, u: float, text: str) -> None:
    assert number_text(value, u) == text
