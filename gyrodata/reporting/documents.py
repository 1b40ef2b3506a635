"""Results as JSON."""

from __future__ import annotations

import json
from typing import Any


def json_text(document: dict[str, Any], indent: int | None = 2) -> str:
    """Write a result as JSON, one line for ``indent=None``.

    Parameters
    ----------
    document : dict
        As `Analysis.to_dict` gives it.
    indent : int or None
        Blanks for each level.

    Returns
    -------
    str
        Ends with a line end. Not-a-number does not pass: it is a fault of the tool.
    """
    return json.dumps(document, indent=indent, allow_nan=False) + "\n"
