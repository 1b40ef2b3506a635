"""What a class gets that worked well, and what is found of the rest: ``python
tests/acceptance/classes`` prints the table.

A line for each cell: measured, its bound, whether it is kept. 1 if one is not.
"""

import argparse
import sys
from pathlib import Path

sys.path += [
    str(Path(__file__).parents[2] / room) for room in ("acceptance", "support", "")
]

from classes.class_cells import CELLS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--cell", default="", metavar="NAME", help="only cells with this in their names"
    )
    parser.add_argument(
        "--students",
        type=int,
        default=200,
        help="in a class; honest pairs take five times as many",
    )
    parser.add_argument("--seed", type=int, default=1, help="for other students")
    options = parser.parse_args()
    chosen = {name: cell for name, cell in CELLS.items() if options.cell in name}
    if options.students < 25 or not chosen:
        parser.error(
            "take 25 students at least"
            if chosen
            else f"no cell has {options.cell} in its name"
        )
    failed = 0
    for name, cell in chosen.items():
        number = cell(options.students, options.seed)
        failed += not number.holds
        measured = f"{name:<42} {number.value:>4} of {number.of:<5} {number.bound:<6}"
        print(measured, "yes" if number.holds else "NO ", number.told, flush=True)
    print(f"{len(chosen)} cells, {failed} beyond their bounds")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
