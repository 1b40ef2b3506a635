"""Files that are no table are refused with their name, and with what to do."""

import io
import json
import zipfile

import pytest

import gyrodata


def opendocument() -> bytes:
    """Write the beginning of a spreadsheet of LibreOffice."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", "<table/>")
    return packed.getvalue()


NOTEBOOK = {"cells": [{"cell_type": "code", "source": ["m = [20.1, 40.3]"]}]}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (opendocument(), "this is an OpenDocument file, such as .ods, not a table"),
        (b"<!DOCTYPE html><html><p>no table</p></html>", "this is a web page"),
        (b"import numpy as np\nm = np.array([20.1, 40.3])\n", "this is a program"),
        (b"m <- c(20.1, 40.3)\n", "this is a program"),
        (json.dumps(NOTEBOOK).encode(), "this is JSON, but not a table"),
    ],
)
def test_file_without_a_table_is_refused(data: bytes, words: str) -> None:
    with pytest.raises(gyrodata.InputError, match=words) as refused:
        gyrodata.analyze(data)
    assert "save the table as CSV" in str(refused.value)
