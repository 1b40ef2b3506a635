"""Is the 95 % interval true, and how long is it? ``python tests/coverage`` simulates the table; 1 if a cell fails.

A cell that is short of what must hold by less than two standard errors may be so by chance, and is told as such; one
that no fit can hold says why, and does not fail.
``--labs N`` draws more labs or fewer, ``--cell NAME`` only the cells with NAME in their names.
"""

from __future__ import annotations

import argparse
import sys

from cells import cells


def main() -> None:
    """Print the table, a line a cell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--labs", type=int, default=400, help="how many labs a cell")
    parser.add_argument("--cell", default="", help="part of the names of the cells")
    options = parser.parse_args()
    chosen = [cell for cell in cells() if options.cell in cell.name]
    if options.labs < 2 or not chosen:
        parser.error(f"no cell has {options.cell!r} in its name" if not chosen else "take 2 labs at least")
    width = max(len(cell.name) for cell in chosen)
    print(f"{'cell':<{width}} {'found':>7}  {'must hold':<14}", flush=True)
    failed = 0
    for cell in chosen:
        number = cell.judge(options.labs)
        word = cell.verdict(number)
        failed += word == "FAILS"
        found = format(number.value, number.digits)
        told = cell.cannot if word == "cannot" else cell.told(options.labs)
        print(f"{cell.name:<{width}} {found:>7}  {number.asked:<14} {word:<10} {told}", flush=True)
    print(f"{len(chosen)} cells of {options.labs} labs, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
