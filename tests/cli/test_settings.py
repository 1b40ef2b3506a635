"""Settings of a course: gyro.toml above the log, GYRO_CONFIG, and the worksheet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from analyzed_once import drawn_once
from places import SAMPLES
from typer.testing import CliRunner, Result

from gyrodata.cli import app

SAMPLE = SAMPLES / "air_gyroscope.csv"


@pytest.fixture(scope="module", autouse=True)
def figures_are_kept() -> Iterator[None]:
    """A report needs figures, and no test here looks at one."""
    with drawn_once():
        yield


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, words)], prog_name="gyro")


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A log two folders below a home folder, which is below another folder."""
    home = tmp_path / "home"
    folder = home / "course" / "monday"
    folder.mkdir(parents=True)
    (folder / "log.csv").write_bytes(SAMPLE.read_bytes())
    monkeypatch.setattr(Path, "home", lambda: home)
    monkeypatch.delenv("GYRO_CONFIG", raising=False)
    monkeypatch.chdir(folder)
    return folder


def ways_to(answer: Result) -> str:
    return answer.stderr.partition("constants of the apparatus: ")[2].partition("\n")[0]


def analyze(*more: str) -> Result:
    return run("analyze", "log.csv", "-f", "csv", "--table", "logs", *more)


def test_the_next_file_up_to_the_home_folder_is_used(lab: Path) -> None:
    alone = analyze()
    assert ways_to(alone) == ""
    above_home = lab.parents[2] / "gyro.toml"
    above_home.write_text('u_spin = "3 %"\n')
    assert analyze().stdout == alone.stdout
    (lab.parent / "gyro.toml").write_text('u_spin = "3 %"\n')
    found = analyze()
    assert ways_to(found) == "../gyro.toml"
    assert found.stdout == analyze("--config", "../gyro.toml").stdout != alone.stdout
    (lab / "gyro.toml").write_text("")
    assert ways_to(analyze()) == "gyro.toml"


def test_the_search_ends_at_the_top_of_a_repository(lab: Path) -> None:
    (lab.parent / "gyro.toml").write_text('u_spin = "3 %"\n')
    (lab / ".git").mkdir()
    assert ways_to(analyze()) == ""


def test_a_variable_names_another_file(
    lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (lab / "gyro.toml").write_text('u_spin = "3 %"\n')
    (lab / "bench.toml").write_text('u_spin = "1 %"\n')
    monkeypatch.setenv("GYRO_CONFIG", "bench.toml")
    found = analyze()
    assert ways_to(found) == "bench.toml"
    assert found.stdout == analyze("--config", "bench.toml").stdout
    told = run("explain", "settings").stdout
    assert "The file for a log in this folder: bench.toml" in told
    monkeypatch.setenv("GYRO_CONFIG", "missing.toml")
    missing = analyze()
    assert missing.exit_code == 2
    assert "missing.toml" in missing.stderr


@pytest.mark.slow
def test_a_teacher_makes_worksheets_the_rule(lab: Path) -> None:
    (lab.parent / "gyro.toml").write_text('worksheet = "yes"\n')
    assert run("analyze", "log.csv", "--figures", "svg").exit_code == 0
    page = Path("log-report/report.html").read_text(encoding="utf-8")
    assert page.count('class="task"') == 8
    (lab.parent / "gyro.toml").write_text('worksheet = "perhaps"\n')
    wrong = run("analyze", "log.csv")
    assert 'write "yes" for questions' in wrong.stderr


def test_a_minus_is_standard_output_for_data(lab: Path) -> None:
    data = run("analyze", "log.csv", "-f", "json")
    assert run("analyze", "log.csv", "-f", "json", "-o", "-").stdout == data.stdout
    refused = run("analyze", "log.csv", "-o", "-")
    assert refused.exit_code == 2
    assert "for data on standard output: -f json" in refused.stderr
    assert [path.name for path in lab.iterdir()] == ["log.csv"]


def test_a_file_whose_name_begins_with_a_minus_can_be_named(
    lab: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("-lead.csv").write_bytes(SAMPLE.read_bytes())
    line = ["gyro", "analyze", "-lead.csv", "--no-report"]
    monkeypatch.setattr("sys.argv", line)
    refused = run(*line[1:])
    assert "for a file whose name begins with -: ./-lead.csv" in refused.stderr
    assert run("analyze", "./-lead.csv", "--no-report").exit_code == 0


def report_of(lab: Path) -> str:
    return (lab / "log-report/report.html").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("value", ["yes", "no"])
def test_yes_and_no_are_true_and_false_too(lab: Path, value: str) -> None:
    word = "true" if value == "yes" else "false"
    assert run("analyze", "log.csv", "--set", f"worksheet={value}").exit_code == 0
    expected = report_of(lab)
    (lab / "gyro.toml").write_text(f"worksheet = {word}\n")
    assert analyze().exit_code == 0
    assert run("analyze", "log.csv").exit_code == 0
    assert ('class="task"' in report_of(lab)) == (value == "yes")
    assert report_of(lab).count('class="task"') == expected.count('class="task"')


@pytest.mark.slow
def test_the_file_names_the_course_unless_the_log_does(lab: Path) -> None:
    (lab / "gyro.toml").write_text('course = "Dynamics, lab 4"\n')
    assert run("analyze", "log.csv").exit_code == 0
    assert "Course: Dynamics, lab 4" in report_of(lab)
    log = lab / "log.csv"
    log.write_text("# Course: Mechanics\n" + log.read_text(encoding="utf-8"))
    assert run("analyze", "log.csv").exit_code == 0
    assert "Course: Mechanics" in report_of(lab)
    assert "Dynamics" not in report_of(lab)
    assert run("analyze", "log.csv", "--set", "course=Physics").exit_code == 0
    assert "Course: Physics" in report_of(lab)


def test_a_file_of_settings_with_a_mistake_is_named(lab: Path) -> None:
    (lab / "gyro.toml").write_text('[bench]\ng = "9.8"\n')
    refused = analyze()
    assert refused.exit_code == 2
    assert "the settings in 'gyro.toml' cannot be read" in refused.stderr


@pytest.mark.parametrize(
    ("typed", "hint"),
    [
        ("lgo.csv", "did you mean log.csv?"),
        ("Log.xlsx", "did you mean log.csv?"),
        ("nofile.csv", "check the folder"),
    ],
)
def test_names_with_another_ending_alone_are_alike(
    lab: Path, typed: str, hint: str
) -> None:
    (lab / "e.csv").write_bytes(b"")
    assert hint in run("analyze", typed).stderr
