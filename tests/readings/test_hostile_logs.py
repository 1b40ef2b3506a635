"""Found by reading logs as a hostile and as a tired user would write them."""

import gzip
import io
import sys
import time
import zipfile

import pytest

from gyrodata.errors import InputError
from gyrodata.measurements import measure
from gyrodata.readings import read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,406,13.06,1/3\n"


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


@pytest.mark.parametrize("header", ["a b " * 2400, "a_" * 4900, "time " * 1990, "± 1 " * 2400, "x y/ z (" * 1200])
def test_a_long_header_costs_no_time(header):
    start = time.process_time()
    read_log(",".join([header] * 50) + "\n" + ",".join("1" * 50) + "\n")
    assert time.process_time() - start < 20


def test_a_row_of_ones_is_a_run_and_no_row_of_units():
    readings = read_log("mass [g],position [cm],spin [rpm],time [s],turns\n1,1,1,1,1\n1,1,1,2,1\n")
    assert len(readings.runs) == 2


def test_many_faults_of_one_kind_are_counted():
    readings = read_log(HEAD + "2O,15,400,7,1\n" * 2000)
    assert len(readings.diagnostics) == 101
    assert readings.diagnostics[-1].message.startswith("1900 more")
    assert not readings.ok


def test_many_remarks_cost_no_time():
    start = time.process_time()
    assert read_log("".join(f"# key{i}: 2 g\n" for i in range(20_000)) + HEAD + ROW).ok
    assert time.process_time() - start < 40


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1e-300,15,400,7,1", "too small for a mass"),
        ("20,1e300,400,7,1", "too large for a length"),
        ("20,15,1e9,7,1", "too large for a rotation rate"),
        ("20,15,400,1e300,1", "too large for a time"),
        ("20,15,400,7,1e-300", "too small for a number of turns"),
        ("20±1e300,15,400,7,1", "uncertainty that is far too large"),
    ],
)
def test_sizes_that_no_lab_has(row, said):
    readings = read_log(HEAD + row + "\n")
    assert not readings.ok
    assert said in readings.diagnostics[0].message


@pytest.mark.parametrize(
    "given", ["turns=0", "turns=-1", "spin=0 rpm", "mass=-1 g", "time=1e300 s", "g=1e300 m/s^2", "u_time=1e300 s",
              "u_spin=1e300 %", "pitch=95 deg", "balance_tilt=1e300 deg in 1e-300 s"]
)  # fmt: skip
def test_constants_that_cannot_be(given):
    key, _, text = given.partition("=")
    with pytest.raises(InputError) as caught:
        read_log(HEAD + ROW, settings={key: text})
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["G504"]
    line = read_log(f"# {key}: {text}\n" + HEAD + ROW)
    assert codes(line) == ["G306"]


@pytest.mark.parametrize(
    ("cell", "hint"),
    [("7 min 30 s", "07:30"), ("7'30", "07:30"), ("12.5 (3)", "12.5(3)"), ("2m30.5s", "02:30.5"), ("1S.0", "15.0")],
)
def test_what_was_meant(cell, hint):
    assert hint in read_log(HEAD + f"20,15,400,{cell},1\n").diagnostics[0].hint


def test_compressed_parts_one_behind_the_other():
    data = gzip.compress((HEAD + ROW).encode()) + gzip.compress(b"40,15,400,19,1\n")
    assert len(read_log(data).runs) == 2
    with pytest.raises(InputError, match="G107"):
        read_log(data + b"junk")
    with pytest.raises(InputError, match="G106"):
        read_log(gzip.compress(b"a," * 4_000_000) * 2)


def test_a_stray_cell_in_the_far_corner_of_a_workbook():
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active["XFD1048576"] = 1
    stream = io.BytesIO()
    book.save(stream)
    start = time.process_time()
    assert read_log(stream.getvalue()).ok
    assert time.process_time() - start < 100


def test_marks_that_no_editor_shows():
    text = HEAD.replace(",", ",\u200b") + ROW.replace("406", "\u202e406\u202c")
    readings = read_log(("\ufeff\ufeff" + text).encode())
    assert readings.ok
    assert [reading.text for reading in readings.columns["spin"].readings] == ["406"]
    assert readings.columns["spin"].place(0) == (2, 10)


def test_tables_in_a_configuration(tmp_path):
    path = tmp_path / "c.toml"
    for text, told in (
        ('[map]\ntime = "time [s]"', "--map"),
        ("g = [1]", 'write one value: g = "1"'),
        ("g = {a = 1}", "--map"),
        ("a.b.c = 1", "--map"),
    ):
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            read_log(HEAD + ROW, config=path)
        assert told in caught.value.diagnostics[0].hint


def test_a_second_weight_that_disagrees_is_told():
    readings = read_log("mass [g],m [g],position [cm],spin [rpm],time [s],turns\n20,40,15,400,7,1\n")
    assert "G401" in [diagnostic.code for diagnostic in measure(readings).diagnostics]
    same = read_log("mass [g],m [kg],position [cm],spin [rpm],time [s],turns\n20,0.02,15,400,7,1\n")
    assert "G401" not in [diagnostic.code for diagnostic in measure(same).diagnostics]


def test_a_link_to_nothing(tmp_path):
    link = tmp_path / "gone.csv"
    link.symlink_to(tmp_path / "elsewhere.csv")
    with pytest.raises(InputError) as caught:
        read_log(link)
    assert caught.value.diagnostics[0].hint == ""


LIMIT = 10_000_000


def test_the_limits_are_met_to_the_last_one():
    log = (HEAD + ROW).encode()
    assert read_log(log + b" " * (LIMIT - len(log))).ok
    assert refusal(log + b" " * (LIMIT - len(log) + 1)) == "G106"
    assert read_log(gzip.compress(log + b" " * (LIMIT - len(log)), 1)).ok
    assert refusal(gzip.compress(log + b" " * (LIMIT - len(log) + 1), 1)) == "G106"
    # A hundred thousand rows below a header are looked at: here they have no columns.
    assert [refusal(b"1\n" * count) for count in (100_001, 100_002)] == ["G222", "G223"]


def refusal(data):
    with pytest.raises(InputError) as caught:
        read_log(data)
    return caught.value.diagnostics[-1].code


@pytest.mark.parametrize("quote", ["", '"'])
def test_two_hundred_columns_and_ten_thousand_letters_are_read(quote):
    def said(cells, head=HEAD, row=ROW):
        return refused_at(f"{head.strip()}{cells}\n{row}")

    more = "".join(f",{quote}c{i}{quote}" for i in range(195))
    assert said(more) is None
    assert said(more + f",{quote}c{quote}") == ("G224", 1, 1, "201 columns; at most 200 are read")
    assert said(more + "," * 150) is None, "blank cells at the end are none"
    cells = f"{HEAD.strip()}{more}{',' * 500}\n{ROW}"
    assert (refused_at(cells) is None) == (not quote), "quoted cells are split one by one"
    letters = f",{quote}{'n' * 10_000}{quote}"
    assert said(letters) is None
    long = "a cell of 10001 characters; at most 10 000 are read"
    assert said(letters.replace("nn", "nnn", 1)) == ("G225", 1, 50 + len(quote), long)
    assert said(f",a{letters}{letters.replace('nn', 'nnn', 1)},b")[2] == 10053 + 3 * len(quote)
    blank = 23 + 3 * len(quote)
    assert refused_at(f"{HEAD}{ROW}40,15.0,{quote * 2}406,13.06,1/3{letters}x\n") == (
        "G225", 3, blank, "a cell of 10001 characters; at most 10 000 are read"
    )  # fmt: skip


def test_a_quoted_cell_over_lines_ends_with_its_quote():
    def said(cell):
        return refused_at(f'{HEAD.strip()},note\n{ROW.strip()},"{cell}\n{ROW}')

    assert said("n" * 9999 + '\n"') is None
    assert said("n" * 10_000 + '\n"')[:3] == ("G226", 2, 23)
    assert said("n" * 4000 + "\n" + "n" * 5998 + '\n"') is None
    assert said("n" * 4000 + "\n" + "n" * 5999 + '\n"')[:3] == ("G226", 2, 23)
    assert said('a""\n""b\n" c') is None
    notes = read_log(f'{HEAD.strip()},note\n{ROW.strip()},"a""\n""b\n" c\n{ROW.strip()},d\n').notes
    assert notes == ('a" "b  c', "d")


def refused_at(text):
    try:
        read_log(text)
    except InputError as error:
        last = error.diagnostics[-1]
        return last.code, last.line, last.column, last.message
    return None


USUAL = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "utf-16-be+", "utf-32-be+", "latin-1", "cp1250"]
)
def test_every_mark_of_an_encoding_is_known(encoding):
    name = encoding.removesuffix("+")
    data = ("\ufeff" * (encoding != name) + USUAL).encode(name)
    readings = read_log(data)
    assert (readings.ok, readings.diagnostics, readings.source_text) == (True, (), USUAL)


@pytest.mark.parametrize(
    ("data", "said", "hint"),
    [
        (b"\x00" + USUAL.encode(), "byte 1 is a NUL", "save"),
        (USUAL.encode() + b"\x00", f"byte {len(USUAL) + 1} is a NUL", "save"),
        (USUAL.encode("utf-16-le"), "byte 2 is a NUL", "it looks like UTF-16"),
        (USUAL.encode("utf-16-be"), "byte 1 is a NUL", "it looks like UTF-16"),
        # Nine of twenty are enough, and eight are not.
        (b"a\x00" * 9 + b"b" * 40, "byte 2 is a NUL", "it looks like UTF-16"),
        (b"a\x00" * 8 + b"b" * 40, "byte 2 is a NUL", "save"),
        (b"\x00a" * 9 + b"b" * 40, "byte 1 is a NUL", "it looks like UTF-16"),
        (b"\x00a" * 8 + b"b" * 40, "byte 1 is a NUL", "save"),
        (b"b" * 40 + b"a\x00" * 20, "byte 42 is a NUL", "save"),
        (USUAL.replace("20", "\x00").encode("utf-16"), "it holds NUL characters", "save"),
        (USUAL.replace("20", "\x00").encode("utf-8-sig"), "it holds NUL characters", "save"),
    ],
)
def test_what_is_no_text_is_told_from_text_in_two_bytes(data, said, hint):
    with pytest.raises(InputError) as caught:
        read_log(data)
    (found,) = caught.value.diagnostics
    assert (found.code, found.message) == ("G105", f"this is not text: {said}")
    assert found.hint.startswith(hint)


@pytest.mark.parametrize(
    ("words", "encoding"),
    [
        ("Masse [g];Abstand [cm];Präzessionszeit [s];Umläufe;Drehzahl [1/min];Bemerkung: für zwei °", "cp1252"),
        ("masse [g];bras [cm];durée [s];nombre de tours;fréquence de rotation [Hz];numéro", "cp1252"),
        ("масса [г];плечо [см];время [с];обороты;частота вращения [Гц];примечание", "cp1251"),
        ("масса [г];плечо [см];время [с];обороты;частота вращения [Гц];примечание", "koi8-r"),
        ("масса [г];плечо [см];время [с];обороты;частота вращения [Гц];примечание", "cp866"),
        ("masa [g];ramię [cm];czas [s];liczba obrotów;prędkość obrotowa [1/min];średnia", "cp1250"),
        ("mass [g];position ± 0.5 [cm];t [s];N;n [rpm];½ °C · µ", "cp1252"),
        ("m [g];x [cm];t [s];N;n [rpm];É ÉCOLE École", "cp1252"),
    ],
)
def test_a_code_page_is_known_by_its_words(words, encoding):
    data = f"{words}\n20,1;14,8;6,95;1/3;212;x\n".encode(encoding)
    readings = read_log(data)
    (told,) = [d.message for d in readings.diagnostics if d.code == "G109"]
    assert told == f"the file is not UTF-8; it was read as {encoding}"
    assert readings.source_text.partition("\n")[0] == words


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"BM\x00\x00", "a BMP picture"),
        (b"RIFF" + b"x" * 59 + b"\x00", "a picture or a sound"),
        (b"%!PS-Adobe", "a PostScript file"),
        (b"  <!DOCTYPE html>", "a web page"),
        (b"\n<?xml version", "a web page"),
        (b"<svg>", "a web page"),
    ],
)
def test_other_files_are_known_by_their_first_bytes(data, said):
    with pytest.raises(InputError, match=f"this is {said}, not a table"):
        read_log(data)


def test_words_that_begin_as_pictures_do_are_words():
    for name in ("BM", "RIFF"):
        assert read_log(f"{name};note\n{HEAD.replace(',', ';')}{ROW.replace(',', ';')}".encode()).ok
    with pytest.raises(InputError, match="byte 65 is a NUL"):
        read_log(b"RIFF" + b"x" * 60 + b"\x00")


def packed(**members):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in members.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return stream.getvalue()


def of_version_12(data: bytes) -> bytes:
    """Let a zip want a version of zip that there is none of."""
    at = data.index(b"PK\x01\x02") + 6
    return data[:at] + b"\x7b" + data[at + 1 :]


@pytest.mark.parametrize(
    ("data", "code", "said", "hint"),
    [
        (
            lambda: packed(a="x"),
            "G104",
            "this is a zip archive, not a table",
            "save the table as CSV and give that file; gyro",
        ),
        (lambda: packed(content_xml="x"), "G104", "this is an OpenDocument file, not a table", "save the table as CSV"),
        (lambda: packed(a="x")[:20], "G104", "this is a damaged zip archive, not a table", "give the CSV itself"),
        (lambda: of_version_12(packed(a="x")), "G104", "this is a damaged zip archive, not a table", "give the CSV"),
        (
            lambda: packed(xl__workbook_xml="x"),
            "G108",
            "the workbook cannot be read (KeyError: ",
            "save the table as CSV",
        ),
        (
            lambda: packed(xl__workbook_xml="x", big="0" * 99_999_999),
            "G108",
            "the workbook cannot be read (KeyError: ",
            "save the table as CSV",
        ),
        (
            lambda: packed(xl__workbook_xml="x", big="0" * 100_000_000),
            "G106",
            "the workbook unpacks to more than 100 MB",
            "a lab log has a few kilobytes",
        ),
    ],
)
def test_what_is_packed_is_looked_at_before_it_is_unpacked(data, code, said, hint):
    with pytest.raises(InputError) as caught:
        read_log(data())
    (found,) = caught.value.diagnostics
    assert (found.code, found.message[: len(said)], found.hint[: len(hint)]) == (code, said, hint)
    assert len(found.message) <= len("the workbook cannot be read ()") + 80


@pytest.mark.parametrize(
    ("rows", "shown", "more"), [(99, 99, None), (100, 100, None), (101, 100, "1 more"), (300, 100, "200 more")]
)
def test_a_hundred_faults_of_one_kind_are_shown(rows, shown, more):
    diagnostics = read_log(HEAD + "2O,15,400,7,1\n" * rows).diagnostics
    assert [d.line for d in diagnostics if d.line] == list(range(2, 2 + shown))
    assert [d.message for d in diagnostics[shown:]] == ([f"{more} of this kind are not shown"] if more else [])


def test_two_hundred_remarks_are_looked_at():
    def told(count):
        readings = read_log("".join(f"# key{i}: x\n" for i in range(count - 1)) + "# Gewicht: 20 g\n" + HEAD + ROW)
        return [d.code for d in readings.diagnostics]

    assert (told(200), told(201)) == (["G305"], [])


@pytest.mark.parametrize(("blanks", "codes_told"), [(200, ["G340"]), (201, ["G301"])])
def test_headers_of_two_hundred_letters_are_looked_at(blanks, codes_told):
    header = "position from surface [cm]".replace(" [", " " * (blanks - 25) + "[")
    assert len(header) == blanks
    assert codes(read_log(HEAD.replace("position [cm]", header) + ROW)) == codes_told
    bare = "m" + " " * (blanks - 4) + "ass"
    found = read_log(HEAD.replace("mass [g]", bare) + ROW.replace("20,", "20 g,")).diagnostics
    assert [d.code for d in found] == ([] if blanks == 200 else ["G301"])
    turns = "time for 1/3 turn [s]".replace(" [", " " * (blanks - 20) + "[")
    found = read_log(HEAD.replace("time [s],turns", turns) + ROW.replace(",1/3", "")).diagnostics
    assert [d.code for d in found] == (["G145"] if blanks == 200 else ["G301", "G301"])


def series(times, head="time [s];angle [deg];x", rest=";1;2", code="G144"):
    rows = "".join(f"{time}{rest}\n" for time in times)
    return code in codes(read_log(f"{head}\n{rows}"))


def test_a_record_of_a_sensor_is_one_of_many_even_steps():
    assert [series(range(count)) for count in (29, 30)] == [False, True]
    # Nine of ten steps are even: between half of the usual one and half as much again.
    for odd, even in ((3, True), (4, False)):
        steps = [10] * (30 - odd) + [16] * odd
        assert series([sum(steps[:i]) for i in range(31)]) is even
    for step, even in ((5, True), (4, False), (15, True), (16, False)):
        steps = [10] * 15 + [step] * 14 + [10] * 3
        assert series([sum(steps[:i]) for i in range(33)]) is even, step
    assert series([10 * i for i in range(30)] + [290]), "a time that stands still is one odd step"
    assert not series([10 * i for i in range(30)] + [289])
    assert not series([7] * 40)
    assert not series([*range(30), "x"])
    assert not series([*range(30), ""])
    # What comes behind two thousand rows is not looked at.
    assert [series([*range(count), 0]) for count in (1999, 2000)] == [False, True]
    assert series([f"{i},5" for i in range(40)])
    runs = "mass [g];position [cm];spin [rpm];time [s];turns", "20;15;400;"
    lab = "\n".join([runs[0], *(f"{runs[1]}{i};1" for i in range(1, 40))])
    assert "G144" not in codes(read_log(lab))
    for lacking in ("mass [g]", "turns"):
        assert "G144" in codes(read_log(lab.replace(lacking, "foo")))
    for instead in (("mass [g]", "force [N]"), ("mass [g]", "torque [N m]"), ("turns", "angle [deg]")):
        assert "G144" not in codes(read_log(lab.replace(*instead)))
    assert series(range(1, 40), "time [s];turns;x")
    (told,) = read_log("x;time [s]\n" + "".join(f"1;{i}\n" for i in range(30))).diagnostics
    assert (told.line, told.column, told.width) == (1, 3, 8)
    assert told.message == "the 30 times go up evenly: this is a time series, and one row a run is read"
    assert told.hint.startswith("work out the spin and the time of some turns of each run from it")


def test_limits_hold_whichever_way_a_log_comes(tmp_path, monkeypatch):
    log = (HEAD + ROW).encode()
    for size, code in ((LIMIT, None), (LIMIT + 1, "G106")):
        data = log + b" " * (size - len(log) - 23) + b"\n40,15.0,406,6.53,1/3\n\n"
        assert len(data) == size
        path = tmp_path / "log.csv"
        path.write_bytes(data)
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
        for source in (data, path, "-", io.BytesIO(data)):
            if code:
                with pytest.raises(InputError) as caught:
                    read_log(source)
                assert caught.value.diagnostics[-1].code == code
            else:
                assert len(read_log(source).runs) == 2


def test_files_with_names_like_the_one_that_is_missing_are_proposed(tmp_path):
    for name in ("data1.csv", "data2.csv", "data3.csv", "data4.csv", "notes.txt"):
        (tmp_path / name).write_text("x")
    (tmp_path / "data0.csv").mkdir()

    def hint(name):
        with pytest.raises(InputError) as caught:
            read_log(tmp_path / name)
        (found,) = caught.value.diagnostics
        assert found.code == "G101"
        return found.hint

    assert sorted(hint("data.csv").removeprefix("did you mean ").removesuffix("?").split(", ")) == [
        "data2.csv", "data3.csv", "data4.csv"
    ]  # fmt: skip
    assert hint("note.txt") == hint("my notes.txt") == "did you mean notes.txt?"
    assert hint("elsewhere.dat") == ""
    assert hint("gone/data.csv").startswith("there is no folder ")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("g = true", "not a number or a text"),
        ("g = 2026-01-03", "not a number or a text"),
        ("g = {a = 1}", "a table or a list, not a number or a text"),
        ("g = []", "a table or a list, not a number or a text"),
        ("g = 9.81", None),
        ("mass = 20", "has no unit"),
        ("turns = 1", None),
        ('turns = "1/3"', None),
    ],
)
def test_values_of_a_configuration(tmp_path, text, said):
    path = tmp_path / "c.toml"
    path.write_text("\ufeff" + text, encoding="utf-8")
    if said is None:
        assert read_log(HEAD + ROW, config=path).ok
        return
    with pytest.raises(InputError) as caught:
        read_log(HEAD + ROW, config=path)
    assert said in caught.value.diagnostics[0].message


def test_what_is_wrong_with_a_configuration(tmp_path):
    def told(path):
        with pytest.raises(InputError) as caught:
            read_log(HEAD + ROW, config=path)
        (found,) = caught.value.diagnostics
        assert found.code == "G505"
        return found.message.rpartition(": ")[2], found.hint

    (tmp_path / "a.toml").write_text("g")
    assert told(tmp_path / "none.toml") == ("No such file or directory", "check its name")
    assert told(tmp_path / "a.toml" / "b.toml") == ("Not a directory", "check its name")
    assert told(tmp_path)[1].startswith("give a text file")
    assert told(tmp_path / "a.toml")[1].startswith("give a text file")
    assert told(tmp_path / "a.toml")[0].startswith("Expected")


def test_a_workbook_has_two_hundred_columns_too():
    import openpyxl

    def told(columns):
        book = openpyxl.Workbook()
        book.active.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns", *["x"] * (columns - 5)])
        book.active.append([20, 15.5, 206, 7.06, "1/3", *range(columns - 5)])
        stream = io.BytesIO()
        book.save(stream)
        try:
            return codes(read_log(stream.getvalue()))
        except InputError as error:
            return [d.code for d in error.diagnostics]

    assert (told(200)[-1], told(201)) == ("G210", ["G224"])


def test_a_byte_that_a_code_page_lacks_weighs_less_than_a_word():
    data = b"m [g];x [\xf1\xec];t [s];N;n [rpm];\x98\n20,1;14,8;6,95;1/3;212;x\n"
    assert [d.message[-6:] for d in read_log(data).diagnostics if d.code == "G109"] == ["cp1251"]


def test_quoted_rows_may_end_in_as_many_blanks_again():
    for blanks, refused in ((396, False), (397, True)):
        head = HEAD.strip().replace("mass [g]", '"mass [g]"') + "," * blanks
        if refused:
            with pytest.raises(InputError) as caught:
                read_log(f"{head}\n{ROW}")
            assert caught.value.diagnostics[-1].code == "G224"
        else:
            assert len(read_log(f"{head}\n{ROW}").runs) == 1
