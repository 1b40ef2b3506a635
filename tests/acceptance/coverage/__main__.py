"""Is the 95 % interval true, and how long is it? ``python tests/acceptance/coverage``
simulates the table; 1 if a cell fails.

A cell that is short of what is asked by less than two standard errors may be so by
chance, and is told as such. ``--labs N`` draws more labs or fewer, ``--cell NAME`` only
the cells with NAME in their names."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path += [
    str(Path(__file__).parents[2] / room) for room in ("acceptance", "support", "")
]

from coverage_cells import CHANCE, cells


def main() -> None:
    """Print the table, a line a cell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--labs", type=int, default=400, help="how many labs a cell")
    parser.add_argument("--cell", default="", help="part of the names of the cells")
    options = parser.parse_args()
    chosen, failed = [cell for cell in cells() if options.cell in cell.name], 0
    if options.labs < 2 or not chosen:
        parser.error(
            f"no cell has {options.cell!r} in its name"
            if not chosen
            else "take 2 labs at least"
        )
    for cell in chosen:
        number = cell.judge(options.labs)
        failed += number.short >= CHANCE
        word = (
            "FAILS" if number.short >= CHANCE else "by chance?" if number.short else ""
        )
        found = f"{number.value:{number.digits}} ({number.asked})"
        print(
            f"{cell.name:<70} {found:<20} {word:<10} {cell.told(options.labs)}",
            flush=True,
        )
    print(f"{len(chosen)} cells of {options.labs} labs, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
