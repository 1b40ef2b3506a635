"""Try very many inputs: ``python tests/acceptance/fuzz --count 100000``; every fault is
shown with the seed that repeats it.

``--door NAME`` tries another door than the analysis, and ``--door all`` all of them, as
many each; ``clean`` draws logs without a slip, whose truth is known. ``--seed S
--only`` tries one and shows the log."""

from __future__ import annotations

import argparse
import collections
import secrets
import sys
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path += [
    str(Path(__file__).parents[2] / room) for room in ("acceptance", "support", "")
]

from gates.fuzzed import attempt, draw

from fuzz.clean import try_clean
from fuzz.doors import DOORS


def analysis(seed: int) -> str:
    """Analyse the log of a seed; an answer must be near the truth or come with a
    warning.
    """
    end, wrong, *_ = attempt(seed)
    assert not wrong, wrong
    return end


WAYS = {"analysis": analysis, "clean": try_clean, **DOORS}


def one(seed: int, door: str) -> tuple[int, str, str]:
    """Try the input of a seed at a door: what became of it, and the fault."""
    try:
        return seed, WAYS[door](seed), ""
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return (
            seed,
            "FAULT",
            f"{Path(last.filename).name}:{last.lineno} {type(error).__name__}: {str(error)[:300]}",
        )


def main() -> None:
    """Run as many as asked for, and exit with 1 if there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument(
        "--seed", type=int, default=secrets.randbelow(2**31), help="of the first log"
    )
    parser.add_argument(
        "--door",
        choices=(*WAYS, "all"),
        default="analysis",
        help="what the inputs are given to",
    )
    parser.add_argument(
        "--only", action="store_true", help="one input; a log is printed"
    )
    options = parser.parse_args()
    print(f"seed {options.seed}", flush=True)
    if options.only:
        if options.door == "analysis":
            print(draw(options.seed)[0].decode("utf-8", "replace"))
        sys.exit(print(WAYS[options.door](options.seed)))
    ends: collections.Counter[str] = collections.Counter()
    with ProcessPoolExecutor() as pool:
        for door in WAYS if options.door == "all" else [options.door]:
            seeds = range(options.seed, options.seed + options.count)
            for seed, end, fault in pool.map(
                one, seeds, [door] * len(seeds), chunksize=50
            ):
                ends[f"{door} {end}"] += 1
                if fault:
                    print(f"{door} seed {seed}: {fault}", flush=True)
    print(", ".join(f"{count} {end}" for end, count in sorted(ends.items())))
    sys.exit(any("FAULT" in end for end in ends))


if __name__ == "__main__":
    main()
