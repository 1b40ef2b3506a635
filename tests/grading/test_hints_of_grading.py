"""Hints of the commands and of a class are promises: each is carried out as it is written, and what comes out is right.

A class of three is graded; ann and bob made no mistake, and cat misspelt a key of her log.
"""

from __future__ import annotations

import csv
import io
import itertools
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, reported_line, sheet
from grading.test_fair_grades import CARRIED_OUT as OF_A_CLASS
from test_options_hints import CARRIED_OUT as OF_A_LOG
from test_options_hints import LOG, ROWS, TRUTH, WITHOUT_TURNS, log
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app
from gyrodata.diagnostics import CODES
from gyrodata.disk import alone_in
from gyrodata.errors import InputError
from gyrodata.grading import find_submissions, read_answers, read_rubric
from gyrodata.readings import read_log

Test = Callable[..., None]
CARRIED_OUT: set[str] = set()
"""Filled by the tests themselves."""


def carries_out(*codes: str) -> Callable[[Test], Test]:
    CARRIED_OUT.update(codes)
    return lambda test: test


def gyro(*words: str | Path) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words], prog_name="gyro")


def hint_of(done: Result, code: str) -> str:
    """Give what stands below the first message of a code."""
    lines = done.stderr.splitlines()
    at = next(i for i, line in enumerate(lines) if re.search(rf"\b{CODES[code].severity} {code}: ", line))
    return "\n".join(line.strip() for line in itertools.takewhile(lambda one: one.startswith("   "), lines[at + 1 :]))


def found(pattern: str, text: str) -> str:
    match = re.search(pattern, text)
    assert match, (pattern, text)
    return match[1] if match.re.groups else match[0]


# --- options of a command ------------------------------------------------------------------------------------


P = "predict precession --inertia '4.44e-3 kg m^2' --torque '0.05 N*m'"
W = "predict precession --inertia '4.44e-3 kg m^2' --spin '400 rpm'"
E = "predict earth --latitude '42.5 deg'"
SAMPLE = Path(__file__).parents[2] / "sample_data" / "air_gyroscope.csv"
STEEP = "simulate --pitch 60deg --transverse '0.02 kg m^2'"
IN_WORDS = [
    ("G621", f"{P} --spin 400", 'write --spin "400 rpm"', f"{P} --spin '400 rpm'"),
    ("G621", f"{P} --spin '40 1/s'", "write rev/s (or Hz)", f"{P} --spin '40 rev/s'"),
    ("G621", f"{P} --spin nan", 'write it like "400 rpm"', f"{P} --spin '400 rpm'"),
    ("G621", f"{P} --spin 1,400rpm", "write it without marks between the thousands", f"{P} --spin 1400rpm"),
    ("G621", f"{E} --hours soon", "write it like --hours 24", f"{E} --hours 24"),
    ("G622", f"{E} --hours -3", "write it like --hours 24", f"{E} --hours 24"),
    ("G622", f"{P} --spin 400rpm --transverse '1e-3 kg m^2'", "leave --transverse out", f"{P} --spin 400rpm"),
    ("G632", "simulate --weights 0g", '--imbalance "0.3 mN m"', "simulate --weights 0g --imbalance '0.3 mN m'"),
    ("G633", f"{STEEP} --spins 50rpm", "more than 148.4 rpm", f"{STEEP} --spins '148.5 rpm'"),
    ("G635", "simulate --motion horizontal --pitch 10deg", "take --motion steady",
     "simulate --motion steady --pitch 10deg"),
    ("G635", "simulate --decay-law dry", '--spin-decay "600 s"', "simulate --decay-law dry --spin-decay '600 s'"),
    ("G635", "simulate --spin-reading both", '--spin-decay "600 s"',
     "simulate --spin-reading both --spin-decay '600 s'"),
    ("G635", "simulate --delay 2s", 'take --spin-decay "600 s" --spin-reading half as well',
     "simulate --delay 2s --spin-decay '600 s' --spin-reading half"),
    ("G635", "simulate --weights 60g --spins 400rpm --motion released --spin-decay '9 %' --decay-law dry",
     'take --spin-decay "600 s" --decay-law viscous',
     "simulate --weights 60g --spins 400rpm --motion released --spin-decay '600 s' --decay-law viscous"),
    ("G635", "simulate --sighting 1deg", "such as --turns 1/3", "simulate --sighting 1deg --turns 1/3"),
    ("G622", f"{P} --spin 400rpm --pitch 90deg", "take a smaller --pitch", f"{P} --spin 400rpm --pitch 89deg"),
    ("G622", f"{W} --mass=-60g --position 15cm", "a negative --position", f"{W} --mass 60g --position=-15cm"),
    ("G622", "predict earth --latitude=-91deg", "in the south with a minus", "predict earth --latitude=-42.5deg"),
    ("G622", f"{E} --hours 1e6 --step 1e-6", "give a longer --step", f"{E} --hours 1e6 --step 1e4"),
    ("G622", "simulate --turns 0", "above zero is needed", "simulate --turns 1"),
    ("G623", f"{W}", "give --torque, or", f"{W} --torque '0.05 N*m'"),
    ("G623", f"{W} --mass 60g", "--mass and --position", f"{W} --mass 60g --position 15cm"),
    ("G623", f"{W} --mass 60g --torque '0.05 N*m'", "not both", f"{W} --torque '0.05 N*m'"),
    ("G624", "predict twist --wheel-spin 300rpm", "give --wheel-inertia, or a log",
     "predict twist --wheel-spin 300rpm --wheel-inertia '0.1 kg m^2'"),
    ("G624", "predict twist", "--log data.csv", f"predict twist --log {SAMPLE}"),
    ("G631", "simulate --pitch 90deg", "", "simulate --pitch 10deg"),
    ("G631", "simulate --weights=-20g,40g", "negative position", "simulate --weights 20g,40g --position=-15cm"),
    ("G631", "simulate --timing-bias=-20s", "a timing bias nearer to 0 s", "simulate --timing-bias=-0.2s"),
    ("G631", "simulate --timing-bias=-3s --turns 1/3", "more turns", "simulate --timing-bias=-3s --turns 3"),
    ("G631", "simulate --repeats 1000000", "a log has 1 to 100000", "simulate --repeats 2"),
    ("G631", "simulate --spin-decay '0 %'", "write it like 10 %", "simulate --spin-decay '10 %'"),
    ("G632", "simulate --weights 0g", "", f"simulate {found('--weights .*', CODES['G632'].remedy)}"),
    ("G633", f"{STEEP} --spins 50rpm", "", "simulate --pitch 1deg --transverse '0.02 kg m^2' --spins 150rpm"),
    ("G633", f"{STEEP} --spins 50rpm", "", "simulate --pitch 60deg --transverse '6e-3 kg m^2' --spins 150rpm"),
    ("G634", "simulate --noise none --spin-decay 1s --decay-law dry", "fewer turns",
     "simulate --noise none --spin-decay 1s --decay-law dry --turns 1/100"),
    ("G634", "simulate --spin-decay 1s --decay-law dry", "a slower decay",
     "simulate --spin-decay 600s --decay-law dry"),
    ("G637", "simulate --truth no-such-folder/t.json", "choose another file with --truth", "simulate --truth t.json"),
    ("G638", f"analyze {SAMPLE} --out report.pdf", "--out report;", f"analyze {SAMPLE} --quiet --out report"),
    ("G639", "schema --check --grades", "gyro schema --check", "schema --check"),
]  # fmt: skip
"""Code, what was typed, what the hint says of it in words, and what a person makes of that."""


def test_answer_contains_what_an_upright_rod_does() -> None:
    assert "\nrod upright, " in gyro(*shlex.split(f"{P} --spin 400rpm --pitch 10deg")).stdout


def assert_fine(words: list[str]) -> None:
    """See that a command is done, and that a simulated log gives its own truth, where it has weights and times."""
    done = gyro(*words)
    assert (done.exit_code, done.stderr) == (0, "")
    if words[0] == "simulate" and not {"0g", "1/100"} & set(words):
        inertia = gyrodata.analyze(done.stdout.encode()).inertia
        assert abs(inertia.value - 4.44e-3) < 4 * (inertia.u or 0.0)


@carries_out(*(case[0] for case in IN_WORDS))
@pytest.mark.parametrize(("code", "typed", "says", "mended"), IN_WORDS, ids=[f"{t}: {s}" for _, t, s, _ in IN_WORDS])
def test_a_command_mended_by_a_person(
    code: str, typed: str, says: str, mended: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = gyro(*shlex.split(typed))
    assert done.exit_code == 2
    assert says in hint_of(done, code)
    assert_fine(shlex.split(mended))


NOISE = [
    ('u_tme = "0.1 s"', lambda hint, text: text.replace("u_tme", found(r"did you mean (\w+)", hint))),
    ('g = "0.1 %"', lambda hint, _: f'{found("(u_time),", hint)} = "0.1 s"'),
    ("u_time = 0.1", lambda hint, _: f'u_time = "0.1 {found("behind it: (.)", hint)}"'),
    ('u_time = "little"', lambda hint, _: f'u_time = "0.1 {found("its unit: (.)", hint)}"'),
    ('u_time = "0.1 furlong"', lambda hint, _: f'u_time = "0.1 {found("one of: (.)", hint)}"'),
    ('u_spin_scale = "1 rpm"', lambda hint, _: f"u_time = '0.1 s'\nu_spin_scale = {found('such as (.*)', hint)}"),
    ("nothing", lambda hint, _: found("write: (.*)", hint)),
    ("# a remark", lambda hint, _: found("write: (.*)", hint)),
]  # fmt: skip


@carries_out("G636")
@pytest.mark.parametrize(("text", "mend"), NOISE, ids=[text for text, _ in NOISE])
def test_a_file_of_noise(text: str, mend: Any, tmp_path: Path) -> None:
    path = tmp_path / "noise.toml"
    path.write_text(text)
    path.write_text(mend(hint_of(gyro("simulate", "--noise", path), "G636"), text))
    assert "# u_time: 0.1 s\n" in gyro("simulate", "--noise", path).stdout
    assert_fine(["simulate", "--noise", str(path)])


def test_a_noise_that_is_no_file() -> None:
    hint = hint_of(gyro("simulate", "--noise", "tpyical"), "G636")
    for word in re.findall('"([a-z]+)"', hint):
        assert_fine(["simulate", "--noise", word])


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with logs of a known truth."""
    monkeypatch.chdir(tmp_path)
    of_t = log("mass [g],position [cm],spin [rpm],T (s),turns\n", rows=ROWS)
    make_folder(tmp_path, {"log.csv": LOG, "again.csv": LOG, "short.csv": WITHOUT_TURNS, "t.csv": of_t})
    return tmp_path


def assert_truth(*documents: str) -> None:
    for text in documents:
        inertia = json.loads(text)["result"]["inertia"]
        assert abs(inertia["value"] - TRUTH) < 4 * inertia["u"]


@carries_out("G608", "G718", "G719")
def test_a_hand_in_is_read_as_it_is(lab: Path) -> None:
    """The other hints of G719 are in `test_hand_in`."""
    (lab / "mine.csv").write_text(log(), encoding="utf-8")
    refused = gyro("check", "mine.csv", "--hand-in", "--set", "g=9.8 m/s^2")
    assert refused.exit_code == 2
    assert "leave these out" in hint_of(refused, "G608")
    asked = gyro("check", "mine.csv", "--hand-in")
    assert asked.exit_code == 1
    line = found(r"with your value: (# .+)", asked.stdout)
    (lab / "mine.csv").write_text(f"# g: 9.8 m/s^2\n{line}\n{log(top='')}", encoding="utf-8")
    done = gyro("check", "mine.csv", "--hand-in")
    assert (done.exit_code, "G718" in done.stdout) == (0, True)


@carries_out("G601", "G602", "G604")
@pytest.mark.parametrize(
    ("code", "typed", "kept", "more"),
    [
        ("G601", "short.csv -f json --set turns", 3, "--set .*"),
        ("G601", "t.csv -f json --map time", 3, "--map .*"),
        ("G602", "log.csv again.csv --format json", 2, "--format ndjson"),
        ("G602", "log.csv again.csv --format latex", 2, "--format markdown"),
        ("G604", "log.csv --format json --values short", 3, ""),
        ("G604", "log.csv --no-report --values short --format csv", 4, "--format text"),
    ],
)
def test_what_goes_together(code: str, typed: str, kept: int, more: str, lab: Path) -> None:
    words = typed.split()
    refused = gyro("analyze", *words)
    assert (refused.exit_code, refused.stdout) == (2, "")
    words = [*words[:kept], *shlex.split(found(more, hint_of(refused, code)))]
    done = gyro("analyze", *words)
    assert done.exit_code == 0, done.stderr
    if "ndjson" in words:
        assert_truth(*done.stdout.splitlines())
    elif "json" in words:
        assert_truth(done.stdout)
    else:
        assert len(re.findall("# Gyroscope lab report: |I_zz = ", done.stdout)) >= (2 if "again.csv" in words else 1)


@carries_out("G603", "G605", "G606", "G607", "G609")
def test_where_it_is_written_watched_and_explained(lab: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused = gyro(*shlex.split(E), "--out", lab / "log.csv")
    assert "with --out" in hint_of(refused, "G603")
    assert gyro(*shlex.split(E), "--out", lab / "new").exit_code == 0
    assert (lab / "new" / "earth.png").stat().st_size > 1000
    with alone_in(lab / "new"):
        hint = hint_of(gyro(*shlex.split(E), "--out", lab / "new"), "G609")
        assert "wait until it is done, then run it again; or choose another folder with --out" in hint
        assert gyro(*shlex.split(E), "--out", lab / "other").exit_code == 0
    assert gyro(*shlex.split(E), "--out", lab / "new").exit_code == 0
    monkeypatch.setattr("gyrodata.cli.watching.contents", lambda path, _: iter([path.read_bytes()]))
    hint = hint_of(gyro("analyze", "log.csv", "--watch", "--format", "json"), "G605")
    assert "I_zz" in gyro(*shlex.split(found("gyro (analyze .* --watch)", hint))).stdout
    hint = hint_of(gyro("explain", "G999"), "G607")
    assert gyro("explain", found(r"such as (G\d+)", hint)).stdout.startswith("G454, warning: ")
    assert "G454" in gyro(*found("gyro (.*) lists", hint).split()).stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device here")
def test_streams(lab: Path) -> None:
    def shell(line: str) -> subprocess.CompletedProcess[str]:
        line = f'gyro() {{ "{sys.executable}" -m gyrodata "$@"; }}\n{line}'
        return subprocess.run(["bash", "-c", line], cwd=lab, capture_output=True, text=True, check=False)

    assert "write to another file" in shell("gyro --version > /dev/full").stderr
    assert shell("gyro --version > out.txt").returncode == 0
    assert (lab / "out.txt").read_text(encoding="utf-8").strip() == gyro("--version").stdout.strip()
    typed = found("(- < log.csv)", shell("gyro check - <&-").stdout)
    assert "9 runs" in shell(f"gyro check {typed}").stdout


# --- a class ---------------------------------------------------------------------------------------------------


def a_log(seed: int, *head: str) -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log(*head, reported_line(*RIGHT.inertia(rows, "with_constant")))


PEOPLE = {"ann": a_log(1), "bob": a_log(5), "cat": a_log(3, "# u_tme: 0.2 s")}
TOTALS = {"ann": "20.00", "bob": "20.00", "cat": "19.50"}
"""A misspelt key costs cat half a point."""


class Room:
    """A class, and the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.home, self.root, self.out = home, home / "class", home / "grades"
        self.whole = False
        self.rows: dict[str, dict[str, str]] = {}

    def grade(self, *words: str | Path, root: str | Path = "class") -> Result:
        """Grade; the pages are only written where a file that is written matters."""
        files = self.whole or {"--gradebook", "--grade-center", "--worksheet"} & set(words)
        done = gyro(
            "grade", root, "-o", "grades", "--workers", "0", *words, *(() if files else ("--dry-run", "-f", "csv"))
        )
        table = done.stdout
        if files and (self.out / "grades.csv").is_file():
            table = (self.out / "grades.csv").read_text(encoding="utf-8")
        rows = csv.DictReader(io.StringIO(table))
        self.rows = {row["student"]: row for row in rows if row.get("student", "points possible") != "points possible"}
        return done

    def graded(self, *words: str | Path, root: str | Path = "class", totals: dict[str, str] = TOTALS) -> Result:
        """Grade, and see that all have what is right."""
        done = self.grade(*words, root=root)
        assert done.exit_code == 0, done.stderr
        assert {student: row["total"] for student, row in self.rows.items()} == totals
        return done

    def refused(self, code: str, *words: str | Path, root: str | Path = "class") -> str:
        """See that nothing is graded, and give the hint."""
        done = self.grade(*words, root=root)
        assert done.exit_code == 2
        return hint_of(done, code)


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The class, graded once."""
    home = tmp_path_factory.mktemp("first")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        make_folder(home / "class", {f"{name}/lab.csv": text for name, text in PEOPLE.items()})
        one = Room(home)
        one.whole = True
        one.graded()
    return home


@pytest.fixture
def room(first: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Room:
    home = Path(shutil.copytree(first, tmp_path / "home"))
    monkeypatch.chdir(home)
    return Room(home)


def packed(room: Room, name: str = "class.zip") -> Path:
    with zipfile.ZipFile(room.home / name, "w") as archive:
        for student, text in PEOPLE.items():
            archive.writestr(f"{student}/lab.csv", text)
    return room.home / name


@carries_out("G701", "G702", "G703", "G704")
def test_a_class_that_can_be_read(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    assert room.refused("G701", root="clas") == "check its name"
    with tarfile.open("class.tar.gz", "w:gz") as archive:
        archive.add("class")
    assert "unpack a .rar, .7z or .tar.gz first" in room.refused("G701", root="class.tar.gz")
    with tarfile.open("class.tar.gz") as archive:
        archive.extractall("unpacked", filter="data")
    room.graded(root="unpacked/class")
    path = packed(room)
    whole = path.read_bytes()
    for cut in (whole[:-10], whole[:40]):
        path.write_bytes(cut)
        assert room.refused("G702", root=path) == "download it again"
    path.write_bytes(whole)
    room.graded(root=path)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../evil.csv", "x")
    assert "take that file out" in room.refused("G703", root=path)
    packed(room)
    room.graded(root=path)
    with zipfile.ZipFile(path) as archive:
        archive.extractall("by-hand")
    room.graded(root="by-hand")
    monkeypatch.setattr("gyrodata.grading.submissions.archives.MOST_FILES", 10)
    make_folder(room.home / "all", {f"week{n}/{s}/lab.csv": text for n in range(4) for s, text in PEOPLE.items()})
    assert "of one assignment" in room.refused("G704", root="all")
    room.graded(root="all/week2")


@carries_out("G705", "G706", "G707")
def test_names_of_files(room: Room) -> None:
    hint = room.refused("G705", "--lms", "canvas")
    assert hint.startswith("leave --lms canvas out, or name them such as ")
    room.graded()
    name, number, _, rest = found(r"such as (\w+\.csv)", hint).split("_", 3)
    canvas = {f"{student}_{i}_7_{rest}": text for i, (student, text) in enumerate(PEOPLE.items(), int(number))}
    assert name.isalpha()
    make_folder(room.home / "named", canvas)
    totals = dict(zip(("9876", "9877", "9878"), TOTALS.values(), strict=True))
    room.graded("--lms", "canvas", root="named", totals=totals)
    make_folder(room.home / "flat", {f"{student}_lab.csv": text for student, text in PEOPLE.items()})
    hint = room.refused("G706", "--pattern", r"(\w+)_lab\.csv", root="flat")
    typed = shlex.split(found("(--pattern .*)", hint))
    room.graded(*typed, root="flat")
    room.graded(*shlex.split("--pattern '(?P<student>[a-z]+)_lab'"), root="flat")
    one = found("such a name: (.*)", room.refused("G705", "--pattern", "(?P<student>q)", root="flat"))
    room.graded("--pattern", one.replace("ann", r"(?P<student>\w+)"), root="flat")
    (room.home / "flat" / "bob_lab.csv").rename("flat/bob-lab.csv")
    done = room.grade(*typed, root="flat")
    assert set(room.rows) == {"ann", "cat"}
    hint = hint_of(done, "G707")
    assert "change --pattern so that it fits these as well, or rename them" in hint
    both = room.graded("--pattern", r"(?P<student>\w+)[-_]lab\.csv", root="flat")
    (room.home / "flat" / "bob-lab.csv").rename("flat/bob_lab.csv")
    assert "G707" not in both.stderr + room.graded(*typed, root="flat").stderr
    (room.home / "named" / "bob.csv").write_text(PEOPLE["bob"])
    sample = found("names files such as (.*)", hint_of(room.grade(root="named"), "G707"))
    (room.home / "named" / "bob.csv").rename(f"named/{sample.replace('9876', '9999')}")
    assert "G707" not in room.graded(root="named", totals=totals | {"9999": "20.00"}).stderr
    with pytest.raises(InputError) as caught:
        find_submissions(room.root, "sakai")
    for lms in found("one of: (.*)", caught.value.diagnostics[0].hint).split(", "):
        assert lms in ("auto", "folder") or room.refused("G705", "--lms", lms)


METADATA = "submission_1:\n  :submitters:\n  - :name: Ann Lee\n    :sid: ann\n    :email: a@uni.example\n"


@carries_out("G708", "G709", "G713", "G714")
def test_files_of_a_student(room: Room) -> None:
    again = {"ann/lab-1.csv": PEOPLE["cat"]}
    make_folder(room.root, again)
    done = room.graded(totals=TOTALS | {"ann": "19.50"})
    assert "note G708" in done.stderr
    assert CODES["G708"].remedy.endswith("then take the others out")
    (room.root / "ann" / "lab-1.csv").unlink()
    assert "G708" not in room.graded().stderr
    make_folder(room.home / "scope", {"submission_metadata.yml": "<html>", "submission_1/lab.csv": PEOPLE["ann"]})
    done = room.graded(root="scope", totals={"1": "20.00"})
    assert "students are named by their submission's number" in hint_of(done, "G709")
    (room.home / "scope" / "submission_metadata.yml").write_text(METADATA)
    assert "G709" not in room.graded(root="scope", totals={"ann": "20.00"}).stderr
    # A link, and what it leads to.
    (room.root / "ann" / "lab.csv").rename("lab.csv")
    (room.root / "ann" / "lab.csv").symlink_to(room.home / "lab.csv")
    assert "put a copy of what it leads to in its place" in hint_of(room.grade(), "G714")
    assert room.rows["ann"]["total"] == ""
    (room.root / "ann" / "lab.csv").unlink()
    shutil.copy("lab.csv", "class/ann/lab.csv")
    assert "G714" not in room.graded().stderr
    path = packed(room)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("ann/./lab.csv", PEOPLE["ann"])
    assert "take one of the two out" in hint_of(room.graded(root=path), "G714")
    assert "G714" not in room.graded(root=packed(room)).stderr
    # A file that is damaged in the zip, and the one that the student hands in again.
    data = bytearray(path.read_bytes())
    at = data.index(PEOPLE["bob"].encode())
    data[at + 300] ^= 1
    path.write_bytes(data)
    done = room.grade(root=path)
    assert done.exit_code == 1
    assert "damaged in the zip" in room.rows["bob"]["why_not_graded"]
    room.graded(root=packed(room))


@carries_out("G717")
def test_an_answer_beside_the_log(room: Room) -> None:
    note = found("it into the log, (# [^,]+),", CODES["G717"].remedy)
    told = read_answers(None, [("report.txt", note[2:].encode())])
    written = read_answers(read_log(f"{note}\n{LOG}".encode()))
    for answers, codes in ((told, ["G717"]), (written, [])):
        assert answers.inertia is not None
        assert answers.inertia.value == 4.4e-3
        assert [one.code for one in answers.diagnostics] == codes


# --- a rubric --------------------------------------------------------------------------------------------------


RUBRIC = """schema = 1
points = 10
[[criterion]]
id = "log"
check = "log"
points = 4
full = "warnings <= 0"
zero = "warnings >= 4"
[[criterion]]
id = "inertia"
check = "own_data"
points = 6
full = "d <= 0.3"
zero = "d >= 3"
"""
SECOND = '[[criterion]]\nid = "inertia"'
REFERENCE = '[[criterion]]\nid = "reference"\ncheck = "reference"\npoints = 3\n'
LATE = '[late]\ngrace = "15 min"\n'


RUBRICS = [
    ("G722", RUBRIC.replace("points = 4", "ponits = 4"), "did you mean points?", RUBRIC),
    ("G723", RUBRIC.replace("schema = 1", "schema = 2"), "write schema = 1", RUBRIC),
    ("G723", RUBRIC.replace("schema = 1\n", "schema = 1\nno_report = 'loook'\n"), "did you mean look?",
     RUBRIC.replace("schema = 1\n", "schema = 1\nno_report = 'look'\n")),
    ("G723", RUBRIC + "slip = '150 %'\n", 'write at most slip = "100 %"', RUBRIC + "slip = '100 %'\n"),
    ("G723", RUBRIC + "slip = 'half'\n", 'write slip = "10 %"', RUBRIC + "slip = '10 %'\n"),
    ("G723", RUBRIC + "gate = ['1 kg', '2 kg']\n", 'write gate = ["1e-6 kg m^2", "100 kg m^2"]',
     RUBRIC + "gate = ['1e-6 kg m^2', '100 kg m^2']\n"),
    ("G723", RUBRIC + LATE.replace("15 min", "15"), 'write grace = "15 min"', RUBRIC + LATE),
    ("G723", RUBRIC + LATE + "due = 'soon'\n", "write due = 2026-03-09T23:59:00+01:00",
     RUBRIC + LATE + "due = 2026-03-09T23:59:00+01:00\n"),
    ("G723", RUBRIC.replace('check = "log"\n', ""), 'write check = "log"', RUBRIC),
    ("G724", RUBRIC.replace("points = 10", "points = 12"), "write points = 10", RUBRIC),
    ("G725", RUBRIC.replace('check = "log"', 'check = "lgo"'), "did you mean log?", RUBRIC),
    ("G726", RUBRIC.replace("warnings <= 0", "warnings < 1"), 'write "warnings <= 0"', RUBRIC),
    ("G726", RUBRIC.replace("warnings >= 4", "warnings > 3"), 'write "warnings >= 4"', RUBRIC),
    ("G721", RUBRIC.replace('id = "log"', "id = log"), "its texts in quotation marks", RUBRIC),
    ("G721", RUBRIC.replace(SECOND, SECOND.partition("\n")[2]), "no key twice", RUBRIC),
    ("G721", RUBRIC.replace("points = 4", "points 4"), "a line is KEY = VALUE", RUBRIC),
    ("G721", RUBRIC.replace("[[criterion]]", "[[criterion]", 1), "[[criterion]]", RUBRIC),
    ("G722", RUBRIC + "ponits = 3\n", "take it out", RUBRIC),
    ("G727", RUBRIC + "[reference]\n", 'write from = "class"', RUBRIC + "[reference]\nfrom = 'class'\n"),
    ("G723", RUBRIC + "[reference]\ninertia = '4.4 g m^2'\n", "[reference.all]",
     RUBRIC + "[reference.all]\ninertia = '4.4 g m^2'\nu = '1 %'\n"),
    ("G723", RUBRIC + "[reference.3]\ninertia = '4.4'\nu = '1 %'\n", "write one behind it: kg*m^2, g*m^2",
     RUBRIC + "[reference.3]\ninertia = '4.4 g*m^2'\nu = '1 %'\n"),
    ("G723", RUBRIC + "[[late.exception]]\nstudent = 's1'\n", 'extra = "2 days"',
     RUBRIC + "[[late.exception]]\nstudent = 's1'\nextra = '2 days'\n"),
    ("G723", RUBRIC.replace('id = "inertia"', 'id = "log"'), "give each its own id", RUBRIC),
    ("G724", RUBRIC.replace("points = 10", "points = 12"), "or change the points of a criterion",
     RUBRIC.replace("points = 10", "points = 12").replace("points = 6", "points = 8")),
    ("G726", RUBRIC.replace('zero = "d >= 3"', 'zero = "d <= 1"'), 'write zero = "d >= NUMBER", farther out', RUBRIC),
    ("G726", RUBRIC.replace('zero = "d >= 3"', 'zero = "d >= 0.1"'), "farther out than the limit of full", RUBRIC),
    ("G726", RUBRIC.replace('zero = "d >= 3"', 'zero = "percent >= 3"'), 'write zero = "d >= NUMBER"', RUBRIC),
    ("G726", RUBRIC.replace('"d <= 0.3"', '"z <= 0.3"'), "write a condition on d or percent", RUBRIC),
    ("G726", RUBRIC.replace('"d <= 0.3"', '"at once"'), 'write it like "d <= 0.3"', RUBRIC),
    ("G726", RUBRIC.replace('"d <= 0.3"', '"d outside 0.3..3"'), 'write full = "d in LOW..HIGH"',
     RUBRIC.replace('"d <= 0.3"', '"d in 0..0.3"').replace('"d >= 3"', '"d outside -3..3"')),
    ("G723", "schema = 1\npoints = 2\n", "write a table, headed [[criterion]]",
     'schema = 1\npoints = 2\n[[criterion]]\nid = "log"\ncheck = "log"\npoints = 2\n'),
    ("G727", RUBRIC.replace("= 10", "= 13") + REFERENCE, '[reference] with from = "class"',
     RUBRIC.replace("= 10", "= 13") + REFERENCE + '[reference]\nfrom = "class"\n'),
    ("G727", RUBRIC.replace("= 10", "= 13") + REFERENCE,
     '[reference.3] with inertia = "4.44e-3 kg m^2" and u = "1 %"',
     RUBRIC.replace("= 10", "= 13") + REFERENCE + '[reference.3]\ninertia = "4.44e-3 kg m^2"\nu = "1 %"\n'),
    ("G727", CODES["G727"].example.replace("points = 2\n[[", "points = 2\n[["), "leave that out",
     CODES["G727"].example.replace("from = 'class'\n", "")),
]  # fmt: skip
"""Code, a rubric with a fault, words of the hint, and what a person makes of them."""


def faults_of(text: str) -> list[Any]:
    try:
        read_rubric(text.encode())
    except InputError as error:
        return list(error.diagnostics)
    return []


@carries_out(*(case[0] for case in RUBRICS))
@pytest.mark.parametrize(("code", "broken", "says", "right"), RUBRICS)
def test_a_rubric_mended_by_a_person(code: str, broken: str, says: str, right: str) -> None:
    (told,) = [one for one in faults_of(broken) if one.code == code][:1]
    assert says in told.hint
    assert faults_of(right) == []


# --- who is who ------------------------------------------------------------------------------------------------


@carries_out("G744")
def test_a_roster_names_partners(room: Room) -> None:
    (room.root / "bob" / "lab.csv").write_text(PEOPLE["ann"])
    room.graded()
    assert room.rows["bob"]["flags"] == "shared rows with ann"
    roster = room.home / "roster.csv"
    roster.write_text("mass [g],time [s]\n20,7\n")
    head = found("first line is (.*)", room.refused("G744", "--roster", roster))
    roster.write_text(f"{head}\nann,Ann Lee,Mon,3,bob\nbob,Bob Roe,Tue,4,\ndan,Dan Fox,Tue,4,\n")
    room.graded("--roster", roster, totals=TOTALS | {"dan": ""})
    assert (room.rows["ann"]["name"], room.rows["bob"]["section"], room.rows["bob"]["flags"]) == ("Ann Lee", "Tue", "")


BOOK = """Student,ID,SIS User ID,SIS Login ID,Section,Homework (111),Gyroscope lab (222)
    Points Possible,,,,,10.00,20.00
"Lee, Ann",1,,ann,A,,
"Roe, Bob",2,,bob,A,,
"Poe, Cat",3,,cat,A,,
"""
SHEET = """Identifier,Full name,Status,Grade,Maximum Grade,Grade can be changed,Last modified (grade),Feedback comments
Participant 1,Ann,x,,20.00,Yes,-,
Participant 2,Bob,x,,20.00,Yes,-,
Participant 3,Cat,x,,20.00,Yes,-,
"""
CENTER = """"Last Name","First Name","Username","Student ID","Homework [Total Pts: 10 Score] |11",\
"Lab [Total Pts: 20 Score] |22"
"Lee","Ann","ann","1","",""
"Roe","Bob","bob","2","","In Progress"
"Poe","Cat","cat","3","",""
"""

SAME_POINTS = "make the points of the rubric and of the assignment in {} the same"
BOOKS: dict[str, tuple[str, int, str, str, list[tuple[str, str, str]]]] = {
    "canvas": ("--gradebook", 6, BOOK, r"Gyroscope lab \((\d+)\)", [
        ("PK\x03\x04\0\0", "G751", "the CSV file that the gradebook exports"),
        ("", "G751", "export the gradebook again"),
        ("a,b\n1,2\n", "G752", "Export Entire Gradebook; give that file as it is"),
        (BOOK.replace(" (111)", "").replace(" (222)", ""), "G753", "make the assignment in Canvas first, and export"),
        (BOOK.replace("20.00", "(read only)"), "G754", "unlock it in Canvas and export again, or name another"),
        (BOOK.replace("20.00", "10.00"), "G754", SAME_POINTS.format("Canvas")),
    ]),
    "blackboard": ("--grade-center", 5, CENTER, r"Lab \[[^|]*\|(\d+)", [
        (CENTER.replace("Last Name", "Apellidos"), "G757", "with English as its language: Work Offline, Download"),
        (CENTER.replace(" |", " "), "G753", "make the assignment in Blackboard first, and export again"),
        (CENTER.replace("20 Score", "20 Letter"), "G754", "set its Primary Display in Blackboard to Score and export"),
        (CENTER.replace("20 Score", "10 Score"), "G754", SAME_POINTS.format("Blackboard")),
    ]),
    "moodle": ("--worksheet", 3, SHEET, "", [
        ("a,b,c\n1,2,3\n", "G755", "Download grading worksheet; give that file as it is"),
        (SHEET.replace("20.00", "10.00"), "G756", SAME_POINTS.format("Moodle")),
    ]),
}  # fmt: skip
"""Option, column of the points, a book, how a message names the assignment, and faults: text, code, hint."""


@carries_out("G751", "G752", "G753", "G754", "G755", "G756", "G757")
@pytest.mark.parametrize("lms", BOOKS)
def test_book_is_filled_once_its_hint_is_followed(lms: str, room: Room) -> None:
    option, column, text, named, faulty = BOOKS[lms]
    book, room.out = room.home / "book.csv", room.home / lms
    names = list(PEOPLE) if named else ["1", "2", "3"]
    files = [name if named else f"{name}_{name}_assignsubmission_file" for name in names]
    root = make_folder(
        room.home / "of" / lms, {f"{f}/lab.csv": log for f, log in zip(files, PEOPLE.values(), strict=True)}
    )
    given = ("-o", room.out, option, book)

    def filled(points: Iterable[str], *words: str) -> None:
        points = list(points)
        room.graded(*given, *words, root=root, totals=dict(zip(names, points, strict=True)))
        rows = list(csv.reader(io.StringIO((room.out / f"{lms}.csv").read_text(encoding="utf-8"))))
        assert [row[column] for row in rows[-3:]] == points

    book.write_text(text)
    number: tuple[str, ...] = ()
    if named:
        done = room.grade(*given, root=root)
        assert hint_of(done, "G753").startswith("give the number behind its title with --assignment")
        number = ("--assignment", found(named, done.stderr))
        if lms == "canvas":
            found(named, room.grade(*given, "--assignment", "lab", root=root).stderr)
    filled(TOTALS.values(), *number)
    for fault, code, says in faulty:
        book.write_text(fault)
        assert says in room.refused(code, *given, *(number if code != "G753" else ()), root=root)
    # The last had ten points.
    Path("rubric.toml").write_text(RUBRIC)
    filled(["10.00", "10.00", "9.00"], *number, "--rubric", "rubric.toml")


# --- the run of a class ---------------------------------------------------------------------------------------


@carries_out("G762")
def test_a_run_that_is_done_again(room: Room) -> None:
    room.whole = True
    room.graded()
    journal = room.out / "journal.ndjson"
    *grades, _run = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join(grades)[:-300])
    (room.root / "ann" / "new.txt").write_text("x")
    assert "note G762" in room.graded().stderr
    assert CODES["G762"].remedy == "nothing: what is lost is graded anew"
    assert "G762" not in room.graded().stderr


@carries_out("G763", "G764", "G765", "G766", "G767")
def test_what_is_asked_for(room: Room) -> None:
    Path("file").write_text("")
    room.whole = True
    assert room.refused("G763", "-o", "file") == "make room there, or choose another folder with --out"
    room.graded("-o", "grades")
    room.whole = False
    assert hint_of(gyro("grade"), "G764") == "give the class, a folder or a zip"
    Path("rubric.toml").write_text(RUBRIC)
    assert room.refused("G765", "--rubric", "rubirc.toml") == "check its name"
    room.graded("--rubric", "rubric.toml", totals={"ann": "10.00", "bob": "10.00", "cat": "9.00"})
    hint = room.refused("G765", "--previous", room.root / "ann" / "lab.csv")
    assert (room.out / found("with its (.*)", hint)).is_file()
    shutil.copytree(room.out, "last-year")
    room.graded("--previous", "last-year")
    assert all(row["flags"] for row in room.rows.values())
    hint = hint_of(gyro("grade", "class", "--format", "json", "--figures"), "G767")
    assert hint.startswith("add --out ")
    done = gyro("grade", "class", "--format", "json", "--gradebook", "book.csv", "--out", "new")
    assert "G767" not in done.stderr
    (room.home / "book.csv").write_text(BOOK)
    done = gyro("grade", "class", "-f", "json", "--gradebook", "book.csv", "--assignment", "222", "--out", "new")
    assert [one["points"] for one in json.loads(done.stdout)["students"]] == [20, 20, 19.5]


@carries_out("G768")
def test_an_autograder(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    rubric = room.home / "rubric.toml"
    printed = found(r"\(gyro (.*?) > rubric.toml", hint_of(gyro("grade", "--gradescope", "autograder"), "G768"))
    text = gyro(*printed.split()).stdout
    rubric.write_text(text)
    words = ("grade", "--gradescope", "autograder", "--rubric", rubric)
    lines = found(r': (\[reference.all\], .*"); or', hint_of(gyro(*words), "G768")).split(", ")
    rubric.write_text(text.replace('[reference]\nfrom = "class"', "\n".join(lines)))
    with monkeypatch.context() as patch:
        # As from a folder of the sources alone.
        patch.setattr("gyrodata.grading.exports.gradescope.distributions", lambda name: ())
        assert hint_of(gyro(*words), "G768").startswith("install it, python3 -m pip install . in its folder")
    assert not Path("autograder").exists()
    assert gyro(*words).exit_code == 0


@pytest.mark.parametrize("where", ["", "class", "class/ann"])
def test_the_grades_beside_the_class(where: str, room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(room.home / where)
    root = os.path.relpath(room.root)
    typed = shlex.split(found("(--out .*)", hint_of(gyro("grade", root, "--out", f"{root}/grades"), "G766")))
    room.out, room.whole = room.home / "class-grades", True
    room.graded(*typed, root=root)


@carries_out("G771", "G772", "G773", "G774")
@pytest.mark.parametrize(
    ("code", "lines", "mended", "total"),
    [
        ("G771", "bob,total,12\n", lambda hint, text: f"{found('first line is (.*)', hint)}\n{text}", "12.00"),
        ("G772", "student,what,value\nbbo,total,12\n",
         lambda hint, text: text.replace("bbo", found("did you mean (.*)[?]", hint)), "12.00"),
        ("G772", "student,what,value\nRoe,total,12\n",
         lambda hint, text: text.replace("Roe", "bob") if "grades.csv has under student" in hint else "", "12.00"),
        ("G773", "student,what,value\nbob,totl,12\n",
         lambda hint, text: text.replace("totl", found("did you mean (.*)[?]", hint)), "12.00"),
        ("G773", "student,what,value\nbob,xyz,12\n",
         lambda hint, text: text.replace("xyz", found("known here: .*(total),", hint)), "12.00"),
        ("G773", "student,what,value\nbob,total,60\n",
         lambda hint, text: text.replace("60", found("such as (.*)", hint)), "10.00"),
        ("G773", "student,what,value\nbob,reported,lots\n",
         lambda hint, text: text.replace("lots", found("unit: (.*)", hint)), None),
        ("G774", "student,what,value\nbob,total,12\nbob,total,13\n",
         lambda hint, text: text.replace("bob,total,13\n", "") if "remove the other" in hint else "", "12.00"),
    ],
)  # fmt: skip
def test_the_desk(code: str, lines: str, mended: Any, total: str | None, room: Room) -> None:
    desk = room.out / "desk.csv"
    desk.write_text(lines)
    desk.write_text(mended(room.refused(code), lines), encoding="utf-8")
    room.grade()
    if total is not None:
        assert {student: row["total"] for student, row in room.rows.items()} == TOTALS | {"bob": total}
    else:
        assert room.rows["bob"]["reported [kg*m^2]"] == "0.0044"


def test_every_hint_is_carried_out() -> None:
    carried = OF_A_LOG | OF_A_CLASS | CARRIED_OUT
    assert carried == {code for code in CODES if code[1] in "567"}
    # None of them is without advice.
    assert all(CODES[code].remedy for code in carried)


def test_the_desk_in_another_encoding(room: Room) -> None:
    desk = room.out / "desk.csv"
    desk.write_bytes("student,what,value,why\nbob,total,12,für Fleiß\n".encode("cp1252"))
    assert 'save it as "CSV UTF-8"' in room.refused("G771")
    desk.write_bytes(desk.read_bytes().decode("cp1252").encode("utf-8-sig"))
    room.graded(totals=TOTALS | {"bob": "12.00"})
