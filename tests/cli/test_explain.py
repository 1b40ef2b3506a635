"""``gyro explain``: codes, words and keys; and colours on a terminal only."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from places import SAMPLES
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

from gyrodata.analysis import check_log
from gyrodata.base.diagnostics import explanations, messages
from gyrodata.base.errors import Diagnostic, GyroError
from gyrodata.cli import app
from gyrodata.cli.documentation import COMMANDS
from gyrodata.quantities.error_sources import SOURCES
from gyrodata.quantities.units import DISPLAY
from gyrodata.readings import read_log, roles

SAMPLE = (SAMPLES / "air_gyroscope.csv").read_text("utf-8")


def explain(*topics: str) -> Result:
    return CliRunner().invoke(app, ["explain", *topics])


@pytest.mark.slow
@pytest.mark.parametrize("code", sorted(explanations()))
def test_every_code_is_explained(code: str) -> None:
    entry, done = explanations()[code], explain(code.lower())
    assert done.exit_code == 0, done.output
    title, *parts = done.stdout.split("\n\n")
    assert title == f"{code}, {entry.severity}: {entry.title}"
    heads = [part.partition(":\n  ")[0] for part in parts]
    meaning = ["What it means"] if entry.meaning else []
    assert heads == [*meaning, "How to fix it", "Example"]


ABOUT_BYTES = {"G107", "G109"}
"""Codes of a file that is not text: a character of the example is a byte."""


@pytest.mark.slow
@pytest.mark.parametrize("code", [code for code in explanations() if code < "G5"])
def test_the_example_of_a_code_raises_it(code: str) -> None:
    example = explanations()[code].example
    if example.split(" ")[0] in COMMANDS:
        return
    log = example.encode("latin-1" if code in ABOUT_BYTES else "utf-8")
    # Most are found before the log is judged, which takes ten times as long.
    assert any(code in codes(check, log) for check in (check_briefly, check_all))


def check_briefly(log: bytes) -> Iterable[Diagnostic]:
    return analyze_briefly(log, name="log.csv").diagnostics


def check_all(log: bytes) -> Iterable[Diagnostic]:
    return check_log(read_log(log, name="log.csv"))[1]


def codes(check: Callable[[bytes], Iterable[Diagnostic]], log: bytes) -> set[str]:
    """List the codes of what is found in a log, or of the reasons to refuse it."""
    try:
        found = check(log)
    except GyroError as error:
        found = error.diagnostics
    return {finding.code for finding in found}


def test_each_code_has_one_explanation_and_one_severity() -> None:
    records = messages().values()
    explaining = [record.code for record in records if record.title]
    assert sorted(explaining) == sorted({record.code for record in records})
    severities = {record.code: record.severity for record in records}
    assert [one for one in records if one.severity != severities[one.code]] == []


def test_only_an_explanation_has_example_and_remedy() -> None:
    for name, record in messages().items():
        explanation = record.meaning + record.example + record.remedy
        assert record.title or not explanation, name
        # Without a remedy the hint is shown, so it must not contain a value.
        hint = record.hint.replace("{{", "").replace("}}", "")
        assert record.remedy or not record.title or (hint and "{" not in hint), name


def words(text: str) -> list[str]:
    return re.findall(r"\w+", text.lower())


@pytest.mark.slow
@pytest.mark.parametrize("code", ["G105", "G404", "G702"])
def test_hint_that_is_the_remedy_is_shown_once(code: str) -> None:
    entry = explanations()[code]
    assert words(entry.hint) == words(entry.remedy)
    shown = " ".join(words(explain(code).stdout))
    assert shown.count(" ".join(words(entry.hint))) == 1


def test_an_explanation_does_not_repeat_its_message() -> None:
    for name, record in messages().items():
        parts = [
            words(part)
            for text in (record.text, record.hint, record.meaning, record.remedy)
            for part in re.split(r"[.;:]\s", text)
        ]
        long = [tuple(part) for part in parts if len(part) > 3]
        assert len(long) == len(set(long)), name


TURNS = {"1/3": "1", "2/3": "2", "1": "3", "1/12": "1/4"}
EFFECTS = [
    ("G206", "9.55 times too small", r"spin \[rpm\]", "spin [rad/s]", 1 / 9.55, 0),
    ("G206", "60 times too small", r"spin \[rpm\]", "spin [Hz]", 1 / 60, 0),
    (
        "G230",
        "3 times too small",
        r",([\d/]+),ccw",
        lambda found: f",{TURNS[found[1]]},ccw",
        1 / 2.99,
        0,
    ),
    ("G229", "4 % too small", r"(\d+)\.\d+,([\d/]+),ccw", r"\1,\2,ccw", 0.959, 0),
    (
        "G305",
        "0.74 % instead of 1.2 %",
        "# station",
        "# u_spin_scale: 1 %\n# station",
        1,
        1.23,
    ),
    ("G340", "34 % too small", ",15.00,", ",9.92,", 0.661, 0),
    ("G407", "2.1 % instead of 0.74 %", ",15.00,", ",15,", 1, 2.06),
    ("G408", "0.63 % instead of 0.74 %", r"(?s)(1,20.*)", r"\1\1", 0.999, 0.627),
    ("G414", "9 % instead of 0.74 %", "(?s)4,39.*", "", 0.988, 9.1),
    ("G426", "1.2 % instead of 0.74 %", ",ccw|,precession_sense", "", 0.992, 1.24),
    ("G440", "1000 times too large", r"mass \[g\]", "mass [kg]", 1000, 0),
    (
        "G441",
        "930 times too large",
        r"spin \[rpm\],time \[s\]",
        "time [s],spin [rpm]",
        932,
        0,
    ),
    ("G454", "1.1 % instead of 0.74 %", "10,0,.*", "", 0.99, 1.06),
]
"""Code, words of its text, what is changed in the sample log; I_zz after and before,
and u(I_zz) [%] if not 0."""


@pytest.mark.slow
@pytest.mark.parametrize(("code", "words", "old", "new", "factor", "u"), EFFECTS)
def test_the_effect_on_the_sample_is_as_stated(
    code: str, words: str, old: str, new: Any, factor: float, u: float
) -> None:
    assert words in " ".join(explanations()[code].meaning.split())
    before, after = (
        analyze_briefly(log.encode()).inertia
        for log in (SAMPLE, re.sub(old, new, SAMPLE))
    )
    assert after.value / before.value == pytest.approx(factor, rel=0.005)
    assert not u or 100 * after.u / after.value == pytest.approx(u, rel=0.02)


def lines_about(key: str) -> Iterator[str]:
    """Write what the glossary must say about a key: its unit, and what gyro assumes."""
    role, base = roles.BY_NAME.get(key), key.removeprefix("u_")
    source = SOURCES.get(base)
    if key in roles.UNCERTAINTIES:
        yield f"standard uncertainty of {source.words if source else base}."
        if source:
            yield f"If the log does not state it, gyro assumes {source.usual}."
    unit = DISPLAY[roles.kind_of_role(key)]
    if base in roles.BY_NAME:
        yield f"As a column: {key} [{unit}]" if unit else f"As a column: {key}"
    if key not in roles.TEXTS:
        sample = role.sample if role else ""
        yield f"For all runs: # {key}: {sample or f'NUMBER {unit}'.rstrip()}"


@pytest.mark.slow
@pytest.mark.parametrize("key", roles.KEYS)
def test_every_key_of_a_log_is_explained(key: str) -> None:
    shown = " ".join(explain(key.upper()).stdout.partition(":\n")[2].split())
    assert f" {key}" in shown
    if key not in roles.OTHER_KEYS:
        for line in lines_about(key):
            assert line in shown


@pytest.mark.slow
@pytest.mark.parametrize(
    ("asked", "found"),
    [
        ("454", "G454, warning"),
        ("chi square", "chi-square, "),
        ("m0", "M0, "),
        ("THEORY.md", "# Theory"),
        ("thoery", "did you mean theory?"),
        ("ccw", "counterclockwise"),
        ("screw", "A, B or C"),
        ("precession_sense", "# precession_sense: ccw"),
        ("reported_inertia", "gyro grade"),
        ("partner", "below its title"),
        ("scale", "# ruler: 2"),
        ("together", "these pages contain it: first-timer"),
        ("analyze", "gyro analyze --help; these pages contain it: "),
        ("budgt", "did you mean budget?"),
        ("u_tme", "did you mean u_time?"),
        ("G4544", "did you mean G454?"),
        ("G999", 'there is no page, code, word or key "G999"'),
    ],
)
def test_a_name_or_the_nearest_one_is_found(asked: str, found: str) -> None:
    done = explain(asked)
    assert found.lower() in done.output.lower()
    assert done.exit_code == (2 if "error G607" in done.stderr else 0)


@pytest.mark.parametrize("word", ["student", "together", "analyze"])
def test_a_word_that_is_not_near_has_no_proposal(word: str) -> None:
    assert "error G607" in explain(word).stderr
    assert "did you mean" not in explain(word).stderr


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def on_terminal(monkeypatch: pytest.MonkeyPatch, *words: str) -> str:
    with monkeypatch.context() as here:
        here.setattr("sys.stdout", shown := Terminal())
        app([*words], standalone_mode=False)
    return shown.getvalue()


def test_colours_are_for_terminals(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    log = tmp_path / "log.csv"
    log.write_text(
        "mass [g],position [cm],spin [rpm],time [s],turns\n20,15,400,40.4,1\n20,15,,20.4,1\n",
        "utf-8",
    )
    assert (
        "log.csv:3:8: warning G452: "
        in CliRunner().invoke(app, ["check", str(log)]).stdout
    )
    assert "log.csv:3:8: \033[1;33mwarning G452:\033[0m " in on_terminal(
        monkeypatch, "check", str(log)
    )
