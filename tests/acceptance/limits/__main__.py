"""The limits of the code: ``python tests/acceptance/limits`` compares the package with
them.

Each function over a limit is listed in ``allowed.toml`` with its number. A number may
only fall, and a function that is not listed may not be over a limit. A room may only
grow with an entry ``growth`` that says why. ``--accept`` writes smaller numbers, and
never a larger one.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from limits.measures import Measures, measure

ALLOWED = Path(__file__).with_name("allowed.toml")
PACKAGE = Path(__file__).parents[3] / "gyrodata"
HEAD = """\
# What is over a limit of measures.py today, each with its number: a number may only
# fall. `python tests/acceptance/limits --accept` writes numbers that have fallen. A room may only
# grow with an entry that says why:
#
# [[rooms.physics.growth]]
# nodes = 120
# why = "the model of a rod on a spring"
"""


def faults(measures: Measures, allowed: dict[str, Any]) -> Iterator[str]:
    """Yield each limit that the package does not keep, with what to do."""
    yield from new_complexity(measures, allowed)
    for name, number in measures.package.items():
        limit = allowed["package"].get(name, 0)
        if number > limit:
            yield f"{name}: {number:g}, allowed {limit:g}: write simpler statements"
    for room, size in measures.rooms.items():
        limit = allowed_size(allowed["rooms"].get(room, {"size": 0}))
        if size > limit:
            yield (
                f"the room {room} has grown to {size} nodes, allowed {limit}: make it "
                f"smaller, or add to allowed.toml an entry [[rooms.{room}.growth]] "
                f"with nodes = {size - limit} and why"
            )


def new_complexity(measures: Measures, allowed: dict[str, Any]) -> Iterator[str]:
    """Yield each function that is over a limit, and more than it is allowed."""
    for measure_name, functions in measures.functions.items():
        listed = allowed.get(measure_name, {})
        for function, number in functions.items():
            limit = listed.get(function, 0)
            if number > limit:
                before = f"more than the {limit} of the list" if limit else "a new one"
                yield (
                    f"{function}: {measure_name} {number}, {before}: "
                    f"let each function do one thing"
                )


def allowed_size(room: dict[str, Any]) -> int:
    """Return the allowed size of a room: that of the list, and what is explained."""
    explained = [
        entry["nodes"] for entry in room.get("growth", []) if entry["why"].strip()
    ]
    return int(room["size"] + sum(explained))


def accepted(measures: Measures, allowed: dict[str, Any]) -> str:
    """Return the file with every number that is smaller now, and no larger one."""
    lines = [HEAD]
    for measure_name, functions in measures.functions.items():
        listed = allowed.get(measure_name, {})
        kept = {
            function: min(number, functions[function])
            for function, number in listed.items()
            if function in functions
        }
        lines.append(f"[{measure_name}]")
        for function, number in sorted(kept.items(), key=lambda row: (-row[1], row[0])):
            lines.append(f'"{function}" = {number}')
        lines.append("")
    lines.append("[package]")
    for name, number in measures.package.items():
        lines.append(f'"{name}" = {min(number, allowed["package"].get(name, number))}')
    for room, size in sorted(measures.rooms.items()):
        lines += ["", *room_lines(room, size, allowed["rooms"].get(room))]
    return "\n".join(lines) + "\n"


def room_lines(room: str, size: int, allowed: dict[str, Any] | None) -> list[str]:
    """Return the entry of a room; one that is smaller now needs no explanation."""
    name = room if room.isidentifier() else f'"{room}"'
    if allowed is None or size <= allowed["size"]:
        return [f"[rooms.{name}]", f"size = {size}"]
    lines = [f"[rooms.{name}]", f"size = {allowed['size']}"]
    for entry in allowed.get("growth", []):
        lines += ["", f"[[rooms.{name}.growth]]", f"nodes = {entry['nodes']}"]
        lines.append(f'why = "{entry["why"]}"')
    return lines


def main() -> int:
    """Compare the package with the limits, or accept smaller numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("package", nargs="?", type=Path, default=PACKAGE)
    parser.add_argument("--accept", action="store_true", help="write smaller numbers")
    options = parser.parse_args()
    measures = measure(options.package)
    allowed = tomllib.loads(ALLOWED.read_text(encoding="utf-8"))
    if options.accept:
        ALLOWED.write_text(accepted(measures, allowed), encoding="utf-8")
    found = list(faults(measures, allowed))
    print("\n".join(found) or "all limits are kept")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
