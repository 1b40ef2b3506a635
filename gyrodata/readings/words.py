"""Words in all languages: squeezed to compare them, and the lists of small words."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection

from gyrodata.quantities import units, vocabulary

FIRST_SIGN = "\u2e80"
"""Letters from this one on are signs of Chinese, Japanese or Korean, which are words.
"""
MAX_HEADER = 200
"""Characters of the longest header that is read."""
TOKENS = re.compile(r"[\s_,;()\[\]\-]+")
_MARKS = units.Letters(
    {**str.maketrans("łϕı", "lφi", "_-.:'’<>|^$*~`\\{}"), ord("ß"): "ss"},
    categories=("Mn",),
)


def squeeze(text: str) -> str:
    """Return the letters of a name, without accents, blanks, ``_``, ``-`` and dots.

    Upper and lower case are kept.
    """
    letters = text
    if not text.isascii():
        # A dot above means a rate ("φ̇"); other accents depend on the keyboard.
        letters = unicodedata.normalize("NFD", units.fold_letters(text)).replace(
            "\u0307", "dot"
        )
    return "".join(letters.translate(_MARKS).split())


def squeezed_words(text: str) -> set[str]:
    """Return the words of a text, squeezed and in small letters."""
    return {squeeze(word).lower() for word in re.split(r"[\W_]+", text)}


def contains_word(text: str, words: Collection[str]) -> bool:
    """Return whether a text contains one of some squeezed words in small letters."""
    return any(squeeze(word).lower() in words for word in TOKENS.split(text))


class Phrases:
    """The phrases of all languages under one key.

    A regular expression of all phrases is long, and a text contains few of their words:
    only the phrases whose first word is in the text are tried.
    """

    def __init__(self, key: str) -> None:
        self.pattern = vocabulary.pattern(key)
        self._by_first_word: dict[str, list[str]] = {}
        self._single_words: dict[str, str] = {}
        for phrase in vocabulary.phrases(key):
            first = _first_letters(phrase.lower().split()[0])
            self._by_first_word.setdefault(first, []).append(phrase)
            if " " not in phrase:
                # A single word may stand inside of a longer one.
                self._single_words[phrase.lower().removesuffix(".")] = phrase

    def is_in(self, text: str) -> bool:
        """Return whether a text contains one of the phrases."""
        small = text.lower()
        likely = {
            phrase for word, phrase in self._single_words.items() if word in small
        }
        for word in _LETTERS.findall(small):
            likely.update(self._by_first_word.get(word, ()))
        if not likely:
            return False
        return re.search(vocabulary.pattern_of(sorted(likely)), text) is not None


def _first_letters(word: str) -> str:
    """Return the beginning of a word, without signs such as those in "don't"."""
    letters = _LETTERS.search(word)
    return letters[0] if letters else word


_LETTERS = re.compile(r"\w+")


def squeezed_names(names: str) -> list[str]:
    """Squeeze names between commas, in small letters.

    The names are squeezed together, because one by one would take 20 ms at each start.
    """
    return squeeze(names).lower().split(",")


def _words(key: str) -> set[str]:
    return set(squeezed_names(",".join(vocabulary.words(key).split())))


START_WORDS, END_WORDS, NOISE_WORDS, UNSURE_WORDS = map(
    _words, ("start", "end", "noise", "unsure")
)
THEORY_WORDS, TRIAL_WORDS, CENTRE_WORDS = map(_words, ("theory", "trial", "centre"))
MEAN_WORDS, SCALE_WORDS, COUNTER_WORDS = map(_words, ("mean", "scale", "counter"))
"""Words for calculated values, repeats of one setting, the centre of the ball, means,
and scales of instruments; and words for a turn that may also number the runs."""
SUMMARY_WORDS = MEAN_WORDS | _words("summary")
"""Words for what is below a table and is not a run."""
NOT_THE_WEIGHT = _words("not_the_weight")
"""Words next to a quantity that is not an added weight, its position, or a spin."""
MOTION_WORDS = _words("motion")
"""Words for a rotation, whose unit says whether it is an angle, turns or a rate."""
SPINNING = Phrases("spinning")
PRECESSION = rf"(?:{vocabulary.pattern('precession')}[^\W\d_]*\.?)"

SMALL_WORDS = START_WORDS | END_WORDS | NOISE_WORDS
