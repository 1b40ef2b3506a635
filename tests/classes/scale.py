"""What a class costs by its size, and what the process that hands the work out needs of memory.

``python tests/classes/scale.py 100 1000 10000`` makes such classes, grades each with two workers, and again as three
parts whose journals are put together; it adds lines to ``scale.csv`` beside it. Without sizes it only draws the figure
of the pages from that table, ``sample_data/figures/class_size.png``.
"""

from __future__ import annotations

import argparse
import csv
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from classes.cost import make_class, metered

TABLE = Path(__file__).with_suffix(".csv")
FIGURE = Path(__file__).parents[2] / "sample_data" / "figures" / "class_size.png"
HEAD = ("students", "way", "CPU a log [ms]", "of the driver [ms]", "memory of the driver [MB]")

LEAST, EACH = 60.0, 0.020
"""What the driver may take: a start, and so much a student [MB]."""


def measure(size: int, seed: int = 1) -> list[tuple[object, ...]]:
    """Grade a class at once, and in three parts put together."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        root = make_class(home / "class", size, seed)
        options = ("--workers", "2", "--quiet")
        # What is compiled once is no cost of a class.
        metered(home / "cache", make_class(home / "few", 4, seed), "-o", home / "first", *options)
        rows = [_row(size, "at once", metered(home / "cache", root, "-o", home / "grades", *options))]
        names = sorted(path.name for path in root.iterdir())
        journals, parts = [], []
        for part in range(3):
            some = home / f"part{part}" / "class"
            some.mkdir(parents=True)
            for name in names[part::3]:
                shutil.copyfile(root / name, some / name)
            out = some.parent / "grades"
            parts.append(metered(home / "cache", some, "-o", out, *options))
            journals.append(out / "journal.ndjson")
        together = home / "together"
        together.mkdir()
        (together / "journal.ndjson").write_bytes(b"".join(path.read_bytes() for path in journals))
        rows.append(
            _row(size, "three parts put together", metered(home / "cache", root, "-o", together, *options), *parts)
        )
    return rows


def _row(size: int, way: str, last: dict[str, float], *before: dict[str, float]) -> tuple[object, ...]:
    """Add up what several runs used; memory is that of the one that needs most."""
    runs = [last, *before]
    used = [f"{1000 * sum(run[part] for run in runs) / size:.1f}" for part in ("all", "alone")]
    return size, way, *used, f"{max(run['peak'] for run in runs):.0f}"


def draw(rows: list[dict[str, str]]) -> None:
    """Draw cost and memory against the size of the class."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for way, mark in (("at once", "o-"), ("three parts put together", "s")):
        some = [row for row in rows if row["way"] == way]
        sizes = [float(row["students"]) for row in some]
        if some:
            left.plot(sizes, [float(row[HEAD[2]]) for row in some], mark, label=way)
            right.plot(sizes, [float(row[HEAD[4]]) for row in some], mark, label=way)
    ends = [float(row["students"]) for row in rows]
    steps = [min(ends) * (max(ends) / min(ends)) ** (step / 50) for step in range(51)]
    right.plot(steps, [LEAST + EACH * size for size in steps], color="0.5", label="60 MB + 20 kB a student")
    left.set(
        xscale="log",
        ylim=(0, None),
        title="few logs bear the start of the tool",
        xlabel="students",
        ylabel="CPU a log, workers and driver [ms]",
    )
    right.set(xscale="log", yscale="log", xlabel="students", ylabel="memory of the driver [MB]")
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    figure.savefig(FIGURE, dpi=150, metadata={"Software": None})


def main() -> None:
    """Measure what is asked for, and draw all that is known."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, help="students in a class")
    for size in parser.parse_args().sizes:
        for row in measure(size):
            print(*row, sep=", ", flush=True)
            with TABLE.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
    with TABLE.open(encoding="utf-8", newline="") as file:
        draw(list(csv.DictReader(file)))


if __name__ == "__main__":
    main()
