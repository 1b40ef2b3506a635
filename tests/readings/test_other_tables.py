"""OpenDocument spreadsheets give the same answer as the same table in CSV."""

import io
import zipfile

import pytest

import gyrodata

HEAD = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]
RUNS = [
    ["20.1", "15.0", "212", "6.95", "1/3"],
    ["20.1", "15.0", "398", "13.05", "1/3"],
    ["40.3", "15.0", "398", "6.70", "1/3"],
    ["60.2", "15.0", "604", "20.12", "1"],
]
CSV = "\n".join(map(",".join, [HEAD, *RUNS])) + "\n"
SPACES = " ".join(
    f'xmlns:{name}="urn:oasis:names:tc:opendocument:xmlns:{name}:1.0"'
    for name in ("office", "table", "text")
)


def cell(text: str) -> str:
    """Write a cell: a number as the program that shows it with a decimal comma stores
    it.
    """
    number = text.replace(".", "").isdigit()
    value = (
        f' office:value-type="float" office:value="{float(text)!r}"' if number else ""
    )
    return (
        f"<table:table-cell{value}><text:p>{text.replace('.', ',') if number else text}"
        f"</text:p></table:table-cell>"
    )


def opendocument(rows: list[list[str]], above: str = "") -> bytes:
    end = '<table:table-cell table:number-columns-repeated="16380"/>'
    lines = "".join(
        f"<table:table-row>{''.join(map(cell, row))}{end}</table:table-row>"
        for row in rows
    )
    blank = (
        f'<table:table-row table:number-rows-repeated="1048000">{end}</table:table-row>'
    )
    sheet = f'<table:table table:name="Sheet1">{lines}{blank}</table:table>'
    content = (
        f'<?xml version="1.0"?>{above}<office:document-content '
        f"{SPACES}>{sheet}</office:document-content>"
    )
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
    return packed.getvalue()


@pytest.mark.slow
def test_other_table_gives_the_answer_of_the_csv() -> None:
    other, usual = gyrodata.analyze(opendocument([HEAD, *RUNS])), gyrodata.analyze(CSV)
    assert (other.inertia.value, other.inertia.u) == (
        usual.inertia.value,
        usual.inertia.u,
    )


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (
            opendocument([HEAD, *RUNS], "<!DOCTYPE x [<!ENTITY a 'aaa'>]>"),
            "cannot be read",
        ),
        (opendocument([]), "is empty"),
        (
            b"<!DOCTYPE html><html><p>no table</p></html>",
            "this is a web page, not a table",
        ),
    ],
)
def test_file_without_a_table_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(gyrodata.InputError, match=said):
        gyrodata.analyze(data)


@pytest.mark.slow
def test_wrong_cell_of_an_opendocument_sheet_is_named() -> None:
    rows = [HEAD, ["20.1", "15.0", "2I2", "6.95", "1/3"], *RUNS[1:]]
    with pytest.raises(gyrodata.LogError) as refused:
        gyrodata.analyze(opendocument(rows))
    found = next(one for one in refused.value.diagnostics if one.severity == "error")
    assert "2I2" in found.message
    assert found.hint == "did you mean 212?"
