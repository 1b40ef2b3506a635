"""A small part of each gate, in each run of the suite; ``python
tests/acceptance/gates`` has all of it.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
from places import ACCEPTANCE, ROOT

from gates.__main__ import GATES
from gates.stored import agree, compare

OTHERS = ("ratios", "coverage", "relations", "fuzz", "class")
"""Gates whose parts have tests of their own: `test_coverage.py`, `test_relations.py`,
`test_fuzz.py`, and the stored class of `test_grade_cli.py`."""


@pytest.mark.parametrize("name", [name for name in GATES if name not in OTHERS])
def test_a_gate_finds_no_difference(name: str) -> None:
    found = GATES[name](part=True)
    assert found.ok, "\n".join(
        [
            found.measured,
            *found.differences[:20],
            f"python tests/acceptance/gates --only {name}",
        ]
    )


def test_texts_agree_if_words_and_seven_digits_do() -> None:
    assert agree("a,0.0044556562,5.1e-05", "a,0.0044556563,5.1e-05")
    assert not agree("a,0.0044556562,5.1e-05", "a,0.0044566562,5.1e-05")
    assert not agree("answer,,1", "warned,,1")
    (changed,) = compare(
        "logs.csv", {"half way": "refused,G999,,"}, accept=False, part=True
    )
    assert changed.startswith("half way: ")
    assert changed.endswith(" | refused,G999,,")


def test_fuzz_command_tries_logs() -> None:
    line = [sys.executable, str(ACCEPTANCE / "fuzz"), "--count", "1", "--seed", "1"]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, "1 analysis answered" in done.stdout) == (0, True), (
        done.stdout + done.stderr
    )
