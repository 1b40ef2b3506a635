"""A class is listed with care and read file by file; what is not safe is refused, and nothing is written anywhere."""

import os
import stat
import struct
import zipfile
from pathlib import Path

import pytest
from grading.classes import LOG, make_folder, make_zip

from gyrodata.errors import InputError
from gyrodata.grading import find_submissions
from gyrodata.grading.submissions.archives import list_files, read_file


def code_of(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        list_files(path)
    assert len(caught.value.diagnostics) == 1
    return caught.value.diagnostics[0].code


@pytest.mark.parametrize("make", [make_folder, make_zip])
def test_a_folder_and_its_zip_list_and_read_the_same(tmp_path: Path, make) -> None:
    files = {"b/lab.csv": LOG, "a/sub/データ.csv": "x", "a/empty.csv": "", "c/": ""}
    listing = list_files(make(tmp_path / "class.zip", files))
    assert list(listing.sizes) == ["a/empty.csv", "a/sub/データ.csv", "b/lab.csv"]
    assert listing.sizes["b/lab.csv"] == len(LOG)
    assert "c/" in listing.folders
    assert read_file(listing.root, "b/lab.csv") == LOG.encode()
    assert listing.diagnostics == ()


@pytest.mark.parametrize("make", [make_folder, make_zip])
def test_what_systems_strew_in_is_not_seen(tmp_path: Path, make) -> None:
    strewn = ["__MACOSX/a/._lab.csv", "a/.DS_Store", "a/._lab.csv", "a/~$lab.xlsx", "a/Thumbs.db", ".git/config"]
    root = make(tmp_path / "class", dict.fromkeys([*strewn, "a/lab.csv", "a/desktop.ini", "a/my.ini"], "x"))
    assert list(list_files(root).sizes) == ["a/lab.csv", "a/my.ini"]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("../evil.csv", ".."),
        ("a/../../evil.csv", ".."),
        ("..\\evil.csv", ".."),
        ("/etc/cron.d/evil", "absolute"),
        ("C:\\evil.csv", "absolute"),
        ("c:evil.csv", "absolute"),
        ("\\\\server\\evil.csv", "absolute"),
    ],
)
def test_path_that_leads_out_of_the_class_is_refused(tmp_path: Path, name: str, why: str) -> None:
    (tmp_path / "inner").mkdir()
    path = make_zip(tmp_path / "inner" / "class.zip", {"a/lab.csv": LOG, name: "evil"})
    before = set(tmp_path.rglob("*"))
    with pytest.raises(InputError, match=why) as caught:
        find_submissions(path)
    assert caught.value.diagnostics[0].code == "G703"
    assert set(tmp_path.rglob("*")) == before


def test_a_name_with_a_nul_is_refused(tmp_path: Path) -> None:
    path = make_zip(tmp_path / "class.zip", {"a/labXcsv": LOG})
    path.write_bytes(path.read_bytes().replace(b"labXcsv", b"lab\x00csv"))
    assert code_of(path) == "G703"


def test_a_link_in_a_zip_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "class.zip"
    with zipfile.ZipFile(path, "w") as archive:
        info = zipfile.ZipInfo("a/lab.csv")
        info.create_system = 3
        info.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(info, "/etc/passwd")
    assert code_of(path) == "G703"


def test_links_in_a_folder_are_left_out_and_told(tmp_path: Path) -> None:
    secret = tmp_path / "secret.csv"
    secret.write_text("secret")
    root = make_folder(tmp_path / "class", {"a/lab.csv": LOG, "b/notes.txt": "x"})
    (root / "b" / "lab.csv").symlink_to(secret)
    (root / "c").symlink_to(root / "a")
    (root / "a" / "loop").symlink_to(root)
    listing = list_files(root)
    assert list(listing.sizes) == ["a/lab.csv", "b/notes.txt"]
    assert [diagnostic.code for diagnostic in listing.diagnostics] == ["G714"] * 3
    with pytest.raises(InputError, match="no longer there"):
        read_file(root, "b/lab.csv")


def test_ten_gigabytes_of_zeros_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "class.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a/lab.csv", LOG)
        with archive.open("b/lab.csv", "w", force_zip64=True) as file:
            for _ in range(12):
                file.write(bytes(1_000_000))
    # 12 MB are enough of them: it now says of itself that it is four thousand million.
    data = path.read_bytes()
    assert struct.pack("<L", 12_000_000) in data
    path.write_bytes(data.replace(struct.pack("<L", 12_000_000), struct.pack("<L", 4_000_000_000)))
    submissions = find_submissions(path)
    assert submissions.items[0].problem is None
    assert submissions.items[1].problem == "lab.csv is 4 GB; a log of more than 10 MB is not read"
    with pytest.raises(InputError, match="larger than 10 MB"):
        read_file(path, "b/lab.csv")


def test_a_size_that_is_a_lie_is_found_out(tmp_path: Path) -> None:
    path = make_zip(tmp_path / "class.zip", {"a/lab.csv": bytes(20_000_000)})
    data = path.read_bytes()
    path.write_bytes(data.replace(struct.pack("<L", 20_000_000), struct.pack("<L", 1000)))
    assert list_files(path).sizes == {"a/lab.csv": 1000}
    with pytest.raises(InputError, match="damaged"):
        read_file(path, "a/lab.csv")


@pytest.mark.parametrize(("count", "stated"), [(300_000, 1), (300_000, 300_000 % 65536), (1_000_000, 65535)])
def test_a_million_entries_are_refused_before_they_are_built(tmp_path: Path, count: int, stated: int) -> None:
    path = make_zip(tmp_path / "class.zip", {"a/lab.csv": LOG})
    data = path.read_bytes()
    start, end = data.index(b"PK\x01\x02"), data.index(b"PK\x05\x06")
    many = data[start:end] * count
    tail = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, stated, stated, len(many), start, 0)
    path.write_bytes(data[:start] + many + tail)
    assert code_of(path) == "G704"


def test_zip64_with_a_false_count_of_entries_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "class.zip"
    end64 = struct.pack("<4sQ2H2L4Q", b"PK\x06\x06", 44, 45, 45, 0, 0, 10**6, 10**6, 6 * 10**7, 0)
    locator = struct.pack("<4sLQL", b"PK\x06\x07", 0, 0, 1)
    path.write_bytes(end64 + locator + struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 65535, 65535, 2**32 - 1, 0, 0))
    assert code_of(path) == "G702"


def test_an_encrypted_file_is_said_to_be_one(tmp_path: Path) -> None:
    path = make_zip(tmp_path / "class.zip", {"a/lab.csv": LOG})
    data = bytearray(path.read_bytes())
    data[6] |= 1
    data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="encrypted"):
        read_file(path, "a/lab.csv")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packings_without_a_bound_are_not_unpacked(tmp_path: Path, method: int) -> None:
    path = tmp_path / "class.zip"
    with zipfile.ZipFile(path, "w", method) as archive:
        archive.writestr("a/lab.csv", LOG)
    with pytest.raises(InputError, match="no platform"):
        read_file(path, "a/lab.csv")


def test_a_damaged_file_in_a_zip_is_told_of_its_student_only(tmp_path: Path) -> None:
    path = tmp_path / "class.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("a/lab.csv", LOG)
        archive.writestr("b/lab.csv", LOG.replace("406", "407"))
    path.write_bytes(path.read_bytes().replace(b"407", b"408", 1))
    submissions = find_submissions(path).items
    assert submissions[0].log() == LOG.encode()
    with pytest.raises(InputError, match="damaged") as caught:
        submissions[1].log()
    assert caught.value.diagnostics[0].code == "G713"
    assert submissions[1].digest != submissions[0].digest


@pytest.mark.parametrize("cut", [10, 200])
def test_a_zip_that_is_cut_off_is_damaged(tmp_path: Path, cut: int) -> None:
    path = make_zip(tmp_path / "class.zip", {f"student{n}/lab.csv": LOG for n in range(20)})
    path.write_bytes(path.read_bytes()[:-cut])
    assert code_of(path) == "G702"


def test_what_is_no_class_is_refused(tmp_path: Path) -> None:
    assert code_of(tmp_path / "nothing") == "G701"
    log = tmp_path / "lab.csv"
    log.write_text(LOG)
    assert code_of(log) == "G701"
    os.mkfifo(tmp_path / "pipe")
    assert code_of(tmp_path / "pipe") == "G701"


def test_of_the_same_name_twice_in_a_zip_the_later_is_read(tmp_path: Path) -> None:
    path = tmp_path / "class.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a/lab.csv", "first")
        archive.writestr("a/./lab.csv", LOG)
    assert list(list_files(path).sizes) == ["a/lab.csv"]
    assert read_file(path, "a/lab.csv") == LOG.encode()


def test_names_in_utf8_without_the_mark_are_read(tmp_path: Path) -> None:
    path = make_zip(tmp_path / "class.zip", {"Zoë/lab.csv": LOG})
    data = bytearray(path.read_bytes())
    for at in (data.index(b"PK\x03\x04") + 7, data.index(b"PK\x01\x02") + 9):
        assert data[at] & 0x08
        data[at] &= ~0x08
    path.write_bytes(bytes(data))
    assert list(list_files(path).sizes) == ["Zoë/lab.csv"]
    assert read_file(path, "Zoë/lab.csv") == LOG.encode()
