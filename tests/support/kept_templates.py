"""Compile each template once, although every report and every class is written in an
environment of its own: an environment compiles a template when it first needs it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from types import CodeType
from unittest.mock import patch

import jinja2
from jinja2.bccache import Bucket


class KeptCode(jinja2.BytecodeCache):
    """The code of the templates that were compiled in this process.

    The environments of one name have the same settings.
    """

    def __init__(self) -> None:
        self.codes: dict[tuple[str, str], CodeType] = {}
        """By the name and the source."""

    def load_bytecode(self, bucket: Bucket) -> None:
        bucket.code = self.codes.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        assert bucket.code is not None
        self.codes[bucket.key, bucket.checksum] = bucket.code


KEPT = KeptCode()


@contextmanager
def templates_kept() -> Iterator[None]:
    """Give each new environment the templates that are compiled already."""
    made = partial(jinja2.Environment, bytecode_cache=KEPT)
    with patch.object(jinja2, "Environment", made):
        yield
