"""What a class gets that worked well, and what is found of the rest: ``python tests/classes`` prints the table.

A line a cell: measured, what must hold, whether it does. ``--cell NAME`` takes the cells with NAME in their names,
``--students N`` the size of a class (honest pairs take five times as many), ``--seed S`` other students. 1 if a cell
does not hold.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from classes.cells import cells


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cell", action="append", metavar="NAME", help="part of the names of the cells; several times")
    parser.add_argument("--students", type=int, default=200, help="in a class")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chosen = [cell for cell in cells() if any(name in cell.name for name in options.cell or [""])]
    if options.students < 20 or not chosen:
        parser.error(
            f"no cell has {' or '.join(options.cell)} in its name" if not chosen else "take 20 students at least"
        )
    width = max(len(cell.name) for cell in chosen)
    print(f"{'cell':<{width}}  {'measured':>12}  {'must hold':<9}  {'holds':<5}", flush=True)
    failed = 0
    for cell in chosen:
        number = cell.measure(options.students, options.seed)
        failed += not number.holds
        word = "yes" if number.holds else "NO"
        print(f"{cell.name:<{width}}  {number.shown:>12}  {number.must_hold:<9}  {word:<5}  {number.told}", flush=True)
    print(f"{len(chosen)} cells, {failed} do not hold")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
