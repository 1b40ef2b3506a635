"""``gyro explain``: what every code means, with an example and what to do; and colours on a terminal only."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.diagnostics import SEVERITIES, explanations


@pytest.mark.parametrize("code", sorted(explanations()))
def test_every_code_is_explained(code: str) -> None:
    done = CliRunner().invoke(app, ["explain", code.lower()])
    assert done.exit_code == 0, done.output
    head, example, *told = done.stdout.split("\n\n")
    assert head == f"{code}, {SEVERITIES[code]}: {explanations()[code].title}"
    assert example.startswith("For example:\n  ")
    # What gyro says of the example has a line of advice below, or there is one of its own.
    said = told[0].startswith("Of this log gyro says:\n  ") and f" {code}: " in told[0] and told[0].count("\n") > 2
    assert said or any(block.startswith("What to do:\n  ") for block in told)


def test_an_unknown_code_is_refused() -> None:
    done = CliRunner().invoke(app, ["explain", "G999"])
    assert (done.exit_code, 'there is no code "G999"' in done.output) == (2, True)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def on_terminal(monkeypatch: pytest.MonkeyPatch, *words: str) -> str:
    with monkeypatch.context() as here:
        here.setattr("sys.stdout", shown := Terminal())
        app([*words], standalone_mode=False)
    return shown.getvalue()


def test_colours_are_for_terminals(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    log = tmp_path / "log.csv"
    log.write_text("mass [g],position [cm],spin [rpm],time [s],turns\n20,15,400,40.4,1\n20,15,,20.4,1\n", "utf-8")
    assert "log.csv:3:8: warning G452: " in CliRunner().invoke(app, ["check", str(log)]).stdout
    assert "log.csv:3:8: \033[1;33mwarning G452:\033[0m " in on_terminal(monkeypatch, "check", str(log))
