"""The words of the languages in `vocabulary.toml`."""

from __future__ import annotations

from collections import Counter
from itertools import chain

import pytest

from gyrodata.quantities import vocabulary

SINGLE_WORDS = [
    "motion",
    "station",
    "caption",
    "beside_mass",
    "beside_position",
    "beside_spin",
    "beside_time",
    "beside_turns",
    "start",
    "end",
    "centre",
    "mean",
    "yes",
    "no",
    "noise",
    "theory",
    "scale",
    "unsure",
    "trial",
    "counter",
    "summary",
    "diameter",
    "disc",
    "not_the_weight",
    "no_weight",
    "and",
    "filler",
    "part",
    "rev",
    "min",
    "s",
]
"""The keys whose words have blanks between them; so have the numbers."""

KEYS = {*chain.from_iterable(vocabulary.LANGUAGES.values())}


@pytest.mark.parametrize("key", sorted(KEYS - {"turn"}))
def test_a_word_is_listed_once_under_its_key(key: str) -> None:
    has_single_words = key in SINGLE_WORDS or key in vocabulary.numbers()
    listed = vocabulary.single_words if has_single_words else vocabulary.phrases
    counts = Counter(word.lower() for word in listed(key))
    assert [word for word, count in counts.items() if count > 1] == []
