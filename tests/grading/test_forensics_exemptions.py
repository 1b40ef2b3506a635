"""The file of partners and staff: read generously, every name that is nobody's told, never a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from gyrodata.diagnostics import CODES
from gyrodata.errors import InputError
from gyrodata.grading import read_exemptions
from gyrodata.grading.forensics import LARGEST_FILE, LONGEST_LINE

CLASS = {"alice": "alice", "bob": "bob", "Ωmega": "c3", "Doe, Jane": "jdoe", "jdoe": "jdoe", "ta1": "ta1"}


@pytest.mark.parametrize(
    ("line", "group"),
    [
        ("alice,bob", {"alice", "bob"}),
        ("alice; Doe, Jane", {"alice", "jdoe"}),
        ("alice\tbob\tjdoe", {"alice", "bob", "jdoe"}),
        ('"Doe, Jane", BOB', {"jdoe", "bob"}),
        ("ωMEGA, alice,", {"c3", "alice"}),
    ],
)
def test_a_line_is_a_group(line: str, group: set[str]) -> None:
    read = read_exemptions(f"\ufeff# partners\r\n\r\n{line}\r\n".encode(), CLASS)
    assert read.groups == (frozenset(group),)
    assert read.diagnostics == ()


def test_staff_are_named_in_lines_of_their_own() -> None:
    read = read_exemptions(b"staff: ta1\nalice, bob\nStaff: jdoe\n", CLASS)
    assert read.staff == {"ta1", "jdoe"}
    assert read.groups == (frozenset({"alice", "bob"}),)


def test_a_name_that_is_nobodys_is_told_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "partners.csv"
    path.write_text("alice, bbo, jdoe\n")
    read = read_exemptions(path, CLASS)
    assert read.groups == (frozenset({"alice", "jdoe"}),)
    assert str(read.diagnostics[0]) == (
        'partners.csv:1:8: warning G742: "bbo" is nobody in this class\n'
        "   alice, bbo, jdoe\n"
        "          ^^^  did you mean bob?"
    )


def test_a_group_of_one_is_told() -> None:
    (found,) = read_exemptions(b"alice\n", CLASS).diagnostics
    assert (found.code, found.line) == ("G743", 1)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"alice,b\xff\xfe", "no text in UTF-8"),
        (b"PK\x03\x04\0\0", "no text"),
        (b"a" * (LARGEST_FILE + 1), "larger than 1 MB"),
        (b"a" * (LONGEST_LINE + 1), "a line is longer"),
        (None, "No such file"),
    ],
)
def test_what_is_no_such_file_is_refused(content: bytes | None, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "partners.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=reason) as caught:
        read_exemptions(path, CLASS)
    assert [found.code for found in caught.value.diagnostics] == ["G741"]
    assert str(tmp_path) not in str(caught.value)


@pytest.mark.parametrize("code", ["G742", "G743"])
def test_the_example_raises_the_code(code: str) -> None:
    found = read_exemptions(CODES[code].example.encode(), CLASS).diagnostics
    assert [(one.code, one.severity) for one in found] == [(code, CODES[code].severity)]
