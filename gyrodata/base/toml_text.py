"""Read the text of a TOML file; the error of a text that is not TOML has its place."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from typing import Any

from msgspec.structs import replace

from gyrodata.base.errors import Diagnostic, InputError


def read_toml(
    content: bytes, name: str, utf8_message: str, toml_message: str
) -> tuple[str, dict[str, Any]]:
    """Return the text of a file and its values.

    Parameters
    ----------
    content : bytes
        The file.
    name : str
        Its name, for the error.
    utf8_message, toml_message : str
        Names of the messages for a file that is not UTF-8, or not TOML.

    Raises
    ------
    InputError
        With one of these messages, at its place in the file.
    """
    # PowerShell writes a file that it makes with > in UTF-16.
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    encoding = "utf-16" if is_utf16 else "utf-8-sig"
    text = content.decode(encoding, "replace" if is_utf16 else "surrogateescape")
    text = text.replace("\r\n", "\n")
    bad = [at for at, sign in enumerate(text) if "\udc80" <= sign <= "\udcff"]
    if bad:
        line = text.count("\n", 0, bad[0]) + 1
        raise error_at(Diagnostic.named(utf8_message), name, text, [line])
    try:
        return text, tomllib.loads(text)
    # A number of more than 4300 digits is a ValueError.
    except (ValueError, RecursionError) as error:
        why, _, place = str(error).partition(" (at ")
        line_and_column = list(map(int, re.findall(r"\d+", place)))
        last = text.count("\n") + 1
        fault = Diagnostic.named(toml_message, why=why)
        raise error_at(fault, name, text, line_and_column or [last]) from None


def error_at(
    fault: Diagnostic, name: str, text: str, place: Sequence[int]
) -> InputError:
    """Make the error of a fault in a file, which shows the line.

    The place is the line, and perhaps the column and the width of what is wrong.
    """
    line, column, width, *_ = *place, 1, 1
    excerpt = text.split("\n")[line - 1]
    marked = {"line": line, "column": column, "excerpt": excerpt, "width": width}
    return InputError([replace(fault, file=name, **marked)])
