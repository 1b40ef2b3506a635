"""Logs as a hostile and as a tired user would write them: read, or refused in words and in a short time."""

import gzip
import io
import sys
import time
import zipfile

import openpyxl
import pytest

from gyrodata import analyze
from gyrodata.errors import InputError
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


@pytest.mark.parametrize("header", ["a b " * 2400, "± 1 " * 2400, "x y/ z (" * 1200])
def test_long_header_takes_no_time(header):
    start = time.process_time()
    read_log(",".join([header] * 50) + "\n" + ",".join("1" * 50) + "\n")
    assert time.process_time() - start < 20


def test_many_remarks_take_no_time():
    start = time.process_time()
    assert read_log("".join(f"# key{i}: 2 g\n" for i in range(20_000)) + LOG).ok
    assert time.process_time() - start < 40


def test_stray_cell_in_the_far_corner_of_a_workbook_is_left_out():
    book = openpyxl.Workbook()
    book.active.append(HEAD.strip().split(","))
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active["XFD1048576"] = 1
    book.save(stream := io.BytesIO())
    start = time.process_time()
    assert read_log(stream.getvalue()).ok
    assert time.process_time() - start < 100


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1e-300,15,400,7,1", "too small for a mass"),
        ("20,1e300,400,7,1", "too large for a length"),
        ("20,15,1e9,7,1", "too large for a rotation rate"),
        ("20,15,400,1e300,1", "too large for a time"),
        ("20,15,400,7,1e-300", "too small for a number of turns"),
        # What was meant is proposed.
        ("20,15,400,7 min 30 s,1", "07:30"),
        ("20,15,400,12.5 (3),1", "12.5(3)"),
        ("20,15,400,1S.0,1", "15.0"),
    ],
)
def test_cell_that_no_lab_has_is_refused_in_words(row, words):
    readings = read_log(f"{HEAD}{row}\n")
    assert not readings.ok
    assert words in readings.diagnostics[0].message + readings.diagnostics[0].hint


@pytest.mark.parametrize("given", ["turns=0", "spin=0 rpm", "mass=-1 g", "g=1e300 m/s^2", "pitch=95 deg"])
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


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: gzip.compress(b"\n" * 50_000_000), "G106", ""),
        (lambda: HEAD.strip() + ",c" * 196 + "\n" + ROW, "G224", "201 columns; at most 200 are read"),
        (lambda: f"{HEAD.strip()},{'n' * 10_001}\n{ROW}", "G225", "a cell of 10001 characters; at most"),
        (lambda: f'{HEAD.strip()},note\n{ROW.strip()},"{"n" * 10_000}\n"\n{ROW}', "G226", ""),
        # What is no text.
        (lambda: b"\x00" + LOG.encode(), "G105", "byte 1 is a NUL"),
        *((lambda code=code: LOG.encode(code), "G105", "it looks like UTF-16") for code in ("utf-16-le", "utf-16-be")),
        (lambda: LOG.replace("20", "\x00").encode("utf-16"), "G105", "it holds NUL characters"),
        (lambda: b"RIFF" + b"x" * 59 + b"\x00", "G104", "a picture or a sound"),
        (lambda: b"BM\x00\x00", "G104", "a BMP picture"),
        (lambda: b"%!PS-Adobe", "G104", "a PostScript file"),
        (lambda: b"\n<?xml version", "G104", "a web page"),
        (lambda: b" \n\t\n", "G103", ""),
        (lambda: gzip.compress(LOG.encode() * 9)[:-9], "G107", ""),
        (lambda: gzip.compress(LOG.encode()) + gzip.compress(ROW.encode()), None, ""),
        (lambda: gzip.compress(LOG.encode()) + b"junk", "G107", ""),
        # What is packed is looked at before it is unpacked.
        (lambda: packed(a="x"), "G104", "this is a zip archive, not a table"),
        (lambda: packed(content_xml="x"), "G104", "this is an OpenDocument file, not a table"),
        (lambda: packed(a="x")[:20], "G104", "this is a damaged zip archive, not a table"),
        (lambda: packed(xl__workbook_xml="x"), "G108", "the workbook cannot be read"),
        # Words that begin as pictures do.
        *((lambda name=name: f"{name};note\n{LOG.replace(',', ';')}".encode(), None, "") for name in ("BM", "RIFF")),
    ],
)  # fmt: skip
def test_file_that_is_no_log_is_refused_in_words(make, code, words):
    told = refusal(make())
    assert (told and told.code) == code
    assert not told or words in f"{told.message} {told.hint}"


def test_a_log_over_ten_megabytes_is_refused_in_every_way_in(tmp_path, monkeypatch):
    path = tmp_path / "log.csv"
    for size, code in ((10_000_000, None), (10_000_001, "G106")):
        data = LOG.encode() + b" " * (size - len(LOG))
        path.write_bytes(data)
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
        for source in (path, "-", io.BytesIO(data), gzip.compress(data, 1)):
            told = refusal(source)
            assert (told and told.code) == code


@pytest.mark.parametrize("data", [b"\n" * 5_000_000, b",\n" * 3_000_000, b"# a: b\n" * 100_000])
def test_large_nothing_is_refused_or_has_no_runs(data):
    assert refusal(data) or not read_log(data).ok


def test_faults_of_one_kind_are_counted_behind_the_hundredth():
    readings = read_log(HEAD + "2O,15,400,7,1\n" * 2000)
    assert len(readings.diagnostics) == 101
    assert readings.diagnostics[-1].message == "1900 more of this kind are not shown"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "latin-1", "cp1250"])
def test_encoding_is_known_by_its_mark(encoding):
    readings = read_log(LOG.encode(encoding))
    assert (readings.diagnostics, len(readings.runs)) == ((), 1)


@pytest.mark.parametrize(
    ("words", "encoding"),
    [
        ("Masse [g];Abstand [cm];Präzessionszeit [s];Umläufe;Drehzahl [1/min];Bemerkung: für zwei °", "cp1252"),
        ("masse [g];bras [cm];durée [s];nombre de tours;fréquence de rotation [Hz];numéro", "cp1252"),
        *(("масса [г];плечо [см];время [с];обороты;частота вращения [Гц];примечание", page)
          for page in ("cp1251", "koi8-r", "cp866")),
        ("masa [g];ramię [cm];czas [s];liczba obrotów;prędkość obrotowa [1/min];średnia", "cp1250"),
        ("mass [g];position ± 0.5 [cm];t [s];N;n [rpm];½ °C · µ", "cp1252"),
    ],
)  # fmt: skip
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


def test_row_of_ones_is_a_run_and_not_a_row_of_units():
    assert len(read_log(HEAD + "1,1,1,1,1\n1,1,1,2,1\n").runs) == 2


@pytest.mark.parametrize(
    ("steps", "sensor"),
    [([1] * 20, False), ([1] * 40, True), ([10] * 28 + [16] * 2, True), ([10] * 24 + [16] * 6, False)],
)
def test_record_of_a_sensor_is_many_even_steps(steps, sensor):
    times = [sum(steps[:i]) for i in range(len(steps) + 1)]
    log = "time [s];angle [deg];x\n" + "".join(f"{one};1;2\n" for one in times)
    assert ("G144" in codes(read_log(log))) is sensor
    assert "G144" not in codes(read_log(HEAD + "".join(f"20,15,400,{i},1\n" for i in range(1, 40))))


@pytest.mark.parametrize(("unit", "mass", "told"), [("g", "40.0", True), ("kg", "0.0200", False)])
def test_second_weight_that_disagrees_is_named(unit, mass, told):
    log = f"mass [g],m [{unit}],position [cm],spin [rpm],time [s],turns\n20.0,{mass},15.0,400,40.1,1\n"
    assert ("G401" in codes(analyze(log.encode()))) is told


def test_file_that_is_missing_is_proposed_by_a_name_like_it(tmp_path):
    for name in ("data1.csv", "data2.csv", "notes.txt"):
        (tmp_path / name).write_text("x")
    hints = {name: refusal(tmp_path / name).hint for name in ("data.csv", "note.txt", "elsewhere.dat", "gone/data.csv")}
    assert "data2.csv" in hints["data.csv"]
    assert hints["note.txt"] == "did you mean notes.txt?"
    assert hints["elsewhere.dat"] == ""
    assert hints["gone/data.csv"].startswith("there is no folder ")
