"""Many logs in one call: one bad log does not stop the others, and none changes the
answer of another.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from analyzed_once import analyzed_once
from places import ROOT
from sheets import HABITS, lab, source
from typer.testing import CliRunner, Result

from gyrodata.cli import app
from gyrodata.reporting.figures import FIGURES

SAMPLE = (ROOT / "sample_data" / "air_gyroscope.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_bad_log_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [f"{i}.csv" for i in range(8)]
    for i, name in enumerate(names):
        (tmp_path / name).write_text(
            SAMPLE.replace("1,20.00,15.00,205.0", f"1,20.00,15.00,{205 + i % 10}"),
            "utf-8",
        )
    (tmp_path / "1.csv").write_bytes(bytes(range(256)))
    (tmp_path / "2.csv").write_text("mass [g]\n20\n", encoding="utf-8")
    (tmp_path / "3.csv").unlink()
    monkeypatch.chdir(tmp_path)
    done = run("analyze", "--format", "ndjson", "--quiet", *names)
    documents = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.exit_code == 2
    assert [document["input"]["name"] for document in documents] == names
    assert [
        i for i, document in enumerate(documents) if document["result"] is None
    ] == [1, 2, 3]
    assert all(document["diagnostics"] for document in documents[1:4])


@pytest.mark.slow
def test_a_log_has_the_same_answer_alone_and_among_others(tmp_path: Path) -> None:
    for at, habit in enumerate(HABITS[::30]):
        log = source(habit.make(lab(at, habit.turns, habit.unloaded)))
        (
            tmp_path / f"{at:03}{'.xlsx' if log.startswith(b'PK') else '.csv'}"
        ).write_bytes(log)
    names = [str(path) for path in sorted(tmp_path.iterdir())]
    among = (
        CliRunner()
        .invoke(app, ["analyze", "--format", "ndjson", *names])
        .stdout.splitlines()
    )
    alone = [
        CliRunner().invoke(app, ["analyze", "--format", "ndjson", name]).stdout.strip()
        for name in names
    ]
    assert len(alone) > 3
    assert among == alone


# --- names, tables and files ---


@pytest.fixture
def same_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Two logs and a bad one, all called lab.csv, below the folder that one is in.

    Each is analysed once.
    """
    samples = ROOT / "sample_data"
    for person, sample in (
        ("alice", "air_gyroscope.csv"),
        ("bob", "heidelberg_ball.csv"),
    ):
        (tmp_path / person).mkdir()
        (tmp_path / person / "lab.csv").write_bytes((samples / sample).read_bytes())
    (tmp_path / "eve").mkdir()
    (tmp_path / "eve" / "lab.csv").write_text("x\n")
    monkeypatch.chdir(tmp_path)
    with analyzed_once():
        yield tmp_path


def run(*arguments: str, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(app, [*arguments], input=stdin)


LABS = ("alice/lab.csv", "bob/lab.csv", "eve/lab.csv")


@pytest.mark.slow
@pytest.mark.parametrize("absolute", [False, True])
def test_each_row_names_its_log(same_names: Path, absolute: bool) -> None:
    logs = [str(same_names / log) if absolute else log for log in LABS]
    done = run("analyze", *logs, "--format", "ndjson")
    assert [
        json.loads(line)["input"]["name"] for line in done.stdout.splitlines()
    ] == list(LABS)
    assert "eve/lab.csv:1:1: error G222" in done.stderr
    assert str(same_names) not in done.output
    for table, count in (("logs", 3), ("runs", 2)):
        rows = csv.DictReader(
            io.StringIO(run("analyze", *logs, "-f", "csv", "--table", table).stdout)
        )
        assert {row["log"] for row in rows} == set(LABS[:count])


@pytest.mark.slow
def test_reports_of_one_name_lie_apart(same_names: Path) -> None:
    run("analyze", *LABS[:2], "-o", "outs")
    assert all(
        Path(f"outs/{name}/lab-report/results.json").is_file()
        for name in ("alice", "bob")
    )
    run("analyze", *LABS[:2], "-f", "markdown", "-o", "marked")
    for name in ("alice", "bob"):
        folder = Path(f"marked/{name}/lab-report")
        text = (folder / "report.md").read_text(encoding="utf-8")
        linked = re.findall(r"\]\(([^)]+\.svg)\)", text)
        assert len(linked) == len(FIGURES)
        assert all((folder / figure).is_file() for figure in linked)


@pytest.mark.slow
def test_data_go_into_a_file_whole_or_not_at_all(same_names: Path) -> None:
    shown = run("analyze", LABS[0], "-f", "json").stdout
    assert run("analyze", LABS[0], "-f", "json", "-o", "x.json").stdout == ""
    assert Path("x.json").read_text(encoding="utf-8") == shown
    rows = run("analyze", *LABS, "-f", "csv", "--table", "logs")
    run("analyze", *LABS, "-f", "csv", "--table", "logs", "-o", "sub/logs.csv")
    assert Path("sub/logs.csv").read_text(encoding="utf-8") == rows.stdout
    Path("taken.json").mkdir()
    done = run("analyze", LABS[0], "-f", "json", "-o", "taken.json")
    assert done.exit_code == 2
    assert "cannot be written" in done.stderr
    assert sorted(path.name for path in same_names.iterdir()) == [
        "alice",
        "bob",
        "eve",
        "sub",
        "taken.json",
        "x.json",
    ]


@pytest.mark.slow
def test_a_log_from_standard_input_has_a_name(same_names: Path) -> None:
    data = Path(LABS[0]).read_bytes()
    assert '"name": "<stdin>"' in run("analyze", "-", "-f", "json", stdin=data).stdout
    assert "<stdin>:1:1: error G222" in run("analyze", "-", stdin=b"x\n").output
    assert (
        'kg*m^2", from <stdin>'
        in run("predict", "tip", "--log", "-", stdin=data).stdout
    )
