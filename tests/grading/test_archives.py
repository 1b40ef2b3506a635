"""A class is listed with care and read file by file; what is not safe is refused, and
nothing is written anywhere.
"""

import stat
import struct
import zipfile
from pathlib import Path

import pytest
from grading.classes import LOG, find_submissions, make_folder, make_zip, packed

from gyrodata.base.errors import InputError

ENTRY = b"PK\x01\x02"


ONE = packed({"a/lab.csv": LOG})


def students(path: Path) -> dict[str, tuple[str, ...]]:
    return {one.student: one.members for one in find_submissions(path).items}


def refusal(path: Path) -> str:
    """Why a class is refused, or the log of its last student."""
    with pytest.raises(InputError) as caught:
        find_submissions(path).items[-1].log()
    (diagnostic,) = caught.value.diagnostics
    return str(diagnostic)


@pytest.mark.parametrize("make", [make_folder, make_zip])
def test_files_that_systems_strew_in_are_not_seen(make, tmp_path: Path) -> None:
    strewn = [
        "__MACOSX/a/._lab.csv",
        "a/.DS_Store",
        "a/._lab.csv",
        "a/~$lab.xlsx",
        "a/Thumbs.db",
        ".git/config",
    ]
    root = make(
        tmp_path / "class",
        dict.fromkeys(
            [*strewn, "a/lab.csv", "a/desktop.ini", "a/my.ini", "b/x.csv"], LOG
        ),
    )
    assert students(root) == {"a": ("a/lab.csv", "a/my.ini"), "b": ("b/x.csv",)}


def test_links_in_a_folder_are_left_out_and_told(tmp_path: Path) -> None:
    secret = tmp_path / "secret.csv"
    secret.write_text(LOG)
    root = make_folder(tmp_path / "class", {"a/lab.csv": LOG, "b/notes.txt": "x"})
    (root / "b" / "lab.csv").symlink_to(secret)
    (root / "c").symlink_to(root / "a")
    (root / "a" / "loop").symlink_to(root)
    found = find_submissions(root)
    assert students(root) == {"a": ("a/lab.csv",), "b": ("b/notes.txt",)}
    assert [one.code for one in found.diagnostics] == ["G714"] * 3
    (root / "a" / "lab.csv").unlink()
    (root / "a" / "lab.csv").symlink_to(secret)
    with pytest.raises(InputError, match="no longer there"):
        found.items[0].log()


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("../evil.csv", ".."),
        ("/etc/cron.d/evil", "absolute"),
        ("C:\\evil.csv", "absolute"),
    ],
)
def test_path_that_leads_out_of_the_class_is_refused(
    name: str, why: str, tmp_path: Path
) -> None:
    (tmp_path / "inner").mkdir()
    path = make_zip(tmp_path / "inner" / "class.zip", {"a/lab.csv": LOG, name: "evil"})
    before = set(tmp_path.rglob("*"))
    told = refusal(path)
    assert ("G703" in told, why in told) == (True, True)
    assert set(tmp_path.rglob("*")) == before


def link() -> bytes:
    info = zipfile.ZipInfo("a/lab.csv")
    info.create_system, info.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    return packed({info: "/etc/passwd"})  # type: ignore[dict-item]


def encrypted() -> bytes:
    data = bytearray(ONE)
    data[6] |= 1
    data[data.index(ENTRY) + 8] |= 1
    return bytes(data)


HOSTILE = {
    "link": (link, "G703"),
    "too many entries": (
        lambda: packed(dict.fromkeys(map(str, range(1001)), "")),
        "G704",
    ),
    "encrypted": (encrypted, "encrypted"),
    "bzip2": (lambda: packed({"a/lab.csv": LOG}, zipfile.ZIP_BZIP2), "no platform"),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_zip_that_is_not_safe_or_damaged_is_refused(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyrodata.grading.submissions.archives.MOST_FILES", 1000)
    make, told = HOSTILE[kind]
    (tmp_path / "class.zip").write_bytes(make())
    assert told in refusal(tmp_path / "class.zip")


@pytest.mark.slow
def test_ten_gigabytes_of_zeros_are_not_read(tmp_path: Path) -> None:
    # 12 MB are enough of them: the zip says of itself that it has four thousand
    # million.
    data = packed({"a/lab.csv": LOG, "b/lab.csv": bytes(12_000_000)})
    data = data.replace(struct.pack("<L", 12_000_000), struct.pack("<L", 4_000_000_000))
    (tmp_path / "class.zip").write_bytes(data)
    ann, bob = find_submissions(tmp_path / "class.zip").items
    assert ann.log() == LOG.encode()
    with pytest.raises(InputError, match="larger than 10 MB"):
        bob.log()
