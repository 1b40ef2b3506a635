"""Logs as a hostile and as a tired user would write them: read, or refused in words and
in a short time.
"""

import gzip
import io
import time
import zipfile

import openpyxl
import pytest

from gyrodata.base.errors import InputError
from gyrodata.readings import read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,406,13.06,1/3\n"
LOG = HEAD + ROW


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


def refusal(source, **options):
    """Give what a log is refused for, or None."""
    try:
        read_log(source, **options)
    except InputError as error:
        return error.diagnostics[-1]
    return None


@pytest.mark.slow
@pytest.mark.parametrize("header", ["a b " * 2400, "± 1 " * 2400, "x y/ z (" * 1200])
def test_long_header_takes_no_time(header):
    start = time.process_time()
    read_log(",".join([header] * 10) + "\n" + ",".join("1" * 10) + "\n")
    assert time.process_time() - start < 5


@pytest.mark.slow
def test_stray_cell_in_the_far_corner_of_a_workbook_is_left_out():
    book = openpyxl.Workbook()
    book.active.append(HEAD.strip().split(","))
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active["XFD10000"] = 1
    book.save(stream := io.BytesIO())
    assert read_log(stream.getvalue()).ok


@pytest.mark.parametrize("given", ["turns=0", "mass=-1 g", "g=1e300 m/s^2"])
def test_constant_that_cannot_be_is_refused(given):
    key, _, text = given.partition("=")
    assert refusal(LOG, settings={key: text}).code == "G504"
    assert codes(read_log(f"# {key}: {text}\n" + LOG)) == ["G306"]


def packed(**members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in members.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return stream.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: gzip.compress(b"\n" * 50_000_000), "G106", ""),
        (
            lambda: HEAD.strip() + ",c" * 196 + "\n" + ROW,
            "G224",
            "201 columns; at most 200 are read",
        ),
        (
            lambda: f"{HEAD.strip()},{'n' * 10_001}\n{ROW}",
            "G225",
            "a cell of more than 10 000 characters",
        ),
        (
            lambda: f'{HEAD.strip()},note\n{ROW.strip()},"{"n" * 9_000}\n{ROW}',
            "G226",
            "",
        ),
        # What is no text.
        (lambda: b"\x00" + LOG.encode(), "G105", "byte 1 is a NUL"),
        (lambda: LOG.encode("utf-16-le"), "G105", "if it is UTF-16"),
        (lambda: b"\x89PNG\x00", "G104", "a picture"),
        (lambda: b" \n\t\n", "G103", ""),
        (lambda: gzip.compress(LOG.encode()) + gzip.compress(ROW.encode()), None, ""),
        (lambda: gzip.compress(LOG.encode()) + b"junk", "G107", ""),
        # What is packed is looked at before it is unpacked.
        (lambda: packed(a="x"), "G104", "this is an archive"),
        (lambda: packed(content_xml="x"), "G104", "this is an archive"),
        (lambda: packed(xl__workbook_xml="x"), "G108", "the workbook cannot be read"),
        # Words that begin as pictures do.
        (lambda: f"BM;note\n{LOG.replace(',', ';')}".encode(), None, ""),
    ],
)
def test_file_that_is_no_log_is_refused_in_words(make, code, words):
    told = refusal(make())
    assert (told and told.code) == code
    assert not told or words in f"{told.message} {told.hint}"


@pytest.mark.slow
def test_a_log_over_ten_megabytes_is_refused():
    for size, code in ((10_000_000, None), (10_000_001, "G106")):
        data = LOG.encode() + b" " * (size - len(LOG))
        for source in (io.BytesIO(data), gzip.compress(data, 1)):
            told = refusal(source)
            assert (told and told.code) == code


@pytest.mark.slow
def test_faults_of_one_kind_are_counted_behind_the_hundredth():
    readings = read_log(HEAD + "".join(f"{i}O,15,400,7,1\n" for i in range(2000)))
    assert len(readings.diagnostics) == 101
    assert readings.diagnostics[-1].message == "1900 more of this kind are not shown"


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encoding_is_known_by_its_mark(encoding):
    readings = read_log(LOG.encode(encoding))
    assert (readings.diagnostics, len(readings.runs)) == ((), 1)


@pytest.mark.parametrize(
    ("words", "encoding"),
    [
        (
            (
                "Masse [g];Abstand [cm];Präzessionszeit [s];Umläufe;Drehzahl "
                "[1/min];Bemerkung: für zwei °"
            ),
            "cp1252",
        ),
        (
            "masse [g];bras [cm];durée [s];nombre de tours;fréquence de rotation [Hz];numéro",
            "cp1252",
        ),
        (
            "масса [г];плечо [см];время [с];обороты;частота вращения [Гц];примечание",
            "cp1251",
        ),
    ],
)
def test_code_page_is_known_by_its_words(words, encoding):
    readings = read_log(f"{words}\n20,1;14,8;6,95;1/3;212;x\n".encode(encoding))
    (told,) = [d.message for d in readings.diagnostics if d.code == "G109"]
    assert told == f"the file is not UTF-8; it was read as {encoding}"
    assert set(readings.columns) >= {"mass", "position", "spin", "time", "turns"}
    assert all(column.header in words for column in readings.columns.values())


def test_marks_that_no_editor_shows_are_left_out():
    text = HEAD.replace(",", ",\u200b") + ROW.replace("406", "\u202e406\u202c")
    readings = read_log(("\ufeff\ufeff" + text).encode())
    assert [reading.text for reading in readings.columns["spin"].readings] == ["406"]
