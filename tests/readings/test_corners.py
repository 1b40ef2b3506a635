"""Texts by the hundred and logs of every layout, each beside all that is read of it."""

import pytest
from corners import CORNERS, blocks, told

BLOCKS = dict(blocks(CORNERS.read_text(encoding="utf-8")))


@pytest.mark.parametrize("head", [head for head in BLOCKS if not head.startswith("measured")])
def test_what_is_read_is_what_stands_beside_it(head):
    body = BLOCKS[head]
    expected = "\n".join([f"== {head}", *body]).rstrip()
    assert "\n".join(told(head, body)).rstrip() == expected, "if it is meant: python tests/make_expected.py"


def test_no_block_has_the_name_of_another():
    assert len(BLOCKS) == CORNERS.read_text(encoding="utf-8").count("\n== ") + 1
