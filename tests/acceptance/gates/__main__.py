"""Does the tool still behave the same, seen from outside? ``python
tests/acceptance/gates`` prints a line for each gate.

A line has the name of the gate, what was measured, what is required, and ok or DIFFERS;
below a gate that differs are the differences, as it was | as it is. The exit code is 1
if a gate differs. ``--only NAME`` runs one gate. ``--accept`` stores what is found now
as what is expected from now on: read the differences first. ``--details`` shows all
that a gate has to say. Times go to standard error, so that standard output is the same
in each run.

The gates use the command line and the public names of the package alone, so that they
survive a redesign of its inside."""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path

sys.path += [
    str(Path(__file__).parents[2] / room) for room in ("acceptance", "support", "")
]

from relations import comparison

import gyrodata
from gates import (
    classroom,
    fuzzed,
    hostile,
    intervals,
    logs,
    outputs,
    published,
    ratios,
    whatif,
)

GATES = {
    "logs": logs.gate,
    "json": outputs.gate_json,
    "printed": outputs.gate_printed,
    "class": classroom.gate,
    "published": published.gate,
    "coverage": intervals.gate,
    "fuzz": fuzzed.gate,
    "hostile": hostile.gate,
    "what-if": whatif.gate,
    "relations": comparison.gate,
    "ratios": ratios.gate,
}


def main() -> None:
    """Run the gates."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--only", action="append", choices=GATES, metavar="NAME", help=", ".join(GATES)
    )
    parser.add_argument("--accept", action="store_true", help="store what is found now")
    parser.add_argument(
        "--details", action="store_true", help="show all that each gate has to say"
    )
    options = parser.parse_args()
    warnings.simplefilter("ignore", gyrodata.GyroWarning)
    begun, differ = time.perf_counter(), 0
    for name in options.only or GATES:
        start = time.perf_counter()
        found = GATES[name](accept=options.accept)
        differ += not found.ok
        print(
            f"{name}: {found.measured}; required: {found.required}: "
            f"{'ok' if found.ok else 'DIFFERS'}"
        )
        shown = (
            found.differences
            if options.details
            else found.differences[: 0 if found.ok else 40]
        )
        print("".join(f"  {line}\n" for line in shown), end="", flush=True)
        print(
            f"{name} took {time.perf_counter() - start:.0f} s",
            file=sys.stderr,
            flush=True,
        )
    print(f"all took {time.perf_counter() - begun:.0f} s", file=sys.stderr)
    sys.exit(1 if differ else 0)


if __name__ == "__main__":
    main()
