"""The help of every command on 80 columns: nothing cut, no option broken in two, an example at the end."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
import typer

from gyrodata.cli import app
from gyrodata.units import STANDARD_GRAVITY


def commands(command: Any, name: str = "gyro") -> Iterator[tuple[str, Any]]:
    yield name, command
    for sub, one in getattr(command, "commands", {}).items():
        yield from commands(one, f"{name} {sub}")


COMMANDS = dict(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_whole_on_80_columns(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    command = COMMANDS[name]
    shown = command.get_help(command.context_class(command, info_name=name))
    lines, flowing = shown.splitlines(), " ".join(shown.split())
    assert max(map(len, lines)) <= 80
    assert [line for line in lines if re.search(r"…|-$|(?<!\])\.\.\.$", line) and not line.startswith("Usage")] == []
    for param in command.params:
        if param.param_type_name == "option" and not param.hidden:
            assert " ".join((param.help or "").split()) in flowing
            assert all(re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", shown) for option in param.opts)
    for sub, one in getattr(command, "commands", {}).items():
        assert one.hidden or f"{sub} {one.short_help}" in re.sub(" +", " ", shown)
    if not hasattr(command, "commands") and not command.hidden:
        assert f"  Example:  {name}" in lines[-1] + lines[-2] + lines[-3]


def test_there_are_all_of_them() -> None:
    assert {"gyro analyze", "gyro check", "gyro predict tip", "gyro schema"} <= set(COMMANDS)


@pytest.mark.parametrize("name", ["gyro simulate", "gyro predict precession"])
def test_help_states_the_gravity_that_is_used(name: str) -> None:
    (option,) = (param for param in COMMANDS[name].params if param.name == "g")
    assert f"{STANDARD_GRAVITY} m/s^2" in f"{option.default} {option.help}"
