"""``gyro explain``: what every code means, with an example and what to do; and colours on a terminal only."""

from __future__ import annotations

import io

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.cli.terminal import coloured
from gyrodata.diagnostics import CODES


@pytest.mark.parametrize("code", sorted(CODES))
def test_every_code_is_explained(code: str) -> None:
    done = CliRunner().invoke(app, ["explain", code.lower()])
    assert done.exit_code == 0, done.output
    head, example, *told = done.stdout.split("\n\n")
    assert head == f"{code}, {CODES[code].severity}: {CODES[code].title}"
    assert example.startswith("For example:\n  ")
    # What gyro says of the example has a line of advice below, or there is one of its own.
    assert any(block.startswith("What to do:\n  ") for block in told) or (
        told[0].startswith("Of this log gyro says:\n  ")
        and f" {code}: " in told[0]
        and len(told[0].strip().splitlines()) > 2
    )


def test_a_code_that_is_none() -> None:
    done = CliRunner().invoke(app, ["explain", "G999"])
    assert done.exit_code == 2
    assert 'there is no code "G999"' in done.output


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_page_is_laid_out_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout", terminal := Terminal())
    app(["explain", "theory"], standalone_mode=False)
    assert "Frames and signs" in terminal.getvalue()
    assert "## Frames" not in terminal.getvalue()


def test_colours_are_for_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    text = "log.csv:3:5: warning G218: spin is blank\nDo not rely on this answer: why\n"
    assert coloured(text, io.StringIO()) == text
    shown = coloured(text, Terminal())
    assert "log.csv:3:5: \033[1;33mwarning G218:\033[0m spin" in shown
    assert "\033[1;31mDo not rely on this answer:\033[0m why" in shown
    monkeypatch.setenv("NO_COLOR", "1")
    assert coloured(text, Terminal()) == text
