"""Read the text of a TOML file; the error of a text that is not TOML has its place."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, InputError


def read_toml(
    content: bytes, name: str, not_utf8: str, not_toml: str
) -> tuple[str, dict[str, Any]]:
    """Return the text of a file and its values.

    Raises
    ------
    InputError
        One of the messages `not_utf8` and `not_toml`.
    """
    # PowerShell writes a file that it makes with > in UTF-16.
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    encoding = "utf-16" if is_utf16 else "utf-8-sig"
    text = content.decode(encoding, "replace" if is_utf16 else "surrogateescape")
    text = text.replace("\r\n", "\n")
    bad = [at for at, sign in enumerate(text) if "\udc80" <= sign <= "\udcff"]
    if bad:
        line = text.count("\n", 0, bad[0]) + 1
        raise error_at(Diagnostic.named(not_utf8), name, text, line)
    try:
        return text, tomllib.loads(text)
    # A number of more than 4300 digits is a ValueError.
    except (ValueError, RecursionError) as error:
        why, _, place = str(error).partition(" (at ")
        numbers = [int(number) for number in re.findall(r"\d+", place)]
        last = text.count("\n") + 1
        line_and_column = numbers or [last]
        fault = Diagnostic.named(not_toml, why=why)
        raise error_at(fault, name, text, *line_and_column) from None


def error_at(
    fault: Diagnostic, name: str, text: str, line: int, column: int = 1, width: int = 1
) -> InputError:
    """Make the error of a fault at a place of a file, which it shows."""
    excerpt = text.split("\n")[line - 1]
    place = {"line": line, "column": column, "excerpt": excerpt, "width": width}
    return InputError([replace(fault, file=name, **place)])
