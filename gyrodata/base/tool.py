"""The record that names the program in each JSON document."""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from gyrodata.base.version import __version__


class Tool(Struct, frozen=True):
    """The tool and its version."""

    name: Literal["gyrodata"] = "gyrodata"
    version: str = __version__
