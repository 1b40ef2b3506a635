"""Try very many inputs: ``python tests/fuzz --count 100000``; every fault is told with the seed that repeats it.

``--door NAME`` tries another door than the analysis (reader, writers, rubric, desk, gradebooks, zips, options), and
``--door all`` all of them, as many each. ``--seed S --only`` tries one; ``--clean`` draws logs without any slip, whose
truth is known, of 3 to 3000 runs; ``--workers N`` takes N processes.
"""

from __future__ import annotations

import argparse
import collections
import os
import secrets
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from fuzz.clean import try_clean
from fuzz.doors import DOORS
from fuzz.grammar import draw_input
from fuzz.relations import try_log


def analysis(seed: int) -> str:
    """Analyse the log of a seed."""
    return "refused" if try_log(*draw_input(seed), thorough=seed % 5 == 0) is None else "taken"


WAYS = {"analysis": analysis, "clean": try_clean, **DOORS}


def one(seed: int, door: str) -> tuple[int, str, str]:
    """Try the input of a seed at a door: what became of it, and the fault."""
    begun = time.process_time()
    try:
        end = WAYS[door](seed)
        took = time.process_time() - begun
        return (seed, "slow", f"{took:.1f} s") if took > 30 else (seed, end, "")
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}:{last.lineno} {type(error).__name__}"
        return seed, "FAULT", f"{where}: {str(error)[:300]}"


def main() -> None:
    """Run as many as asked for, and exit with 1 if there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the first log")
    doors = ("analysis", *DOORS)
    parser.add_argument("--door", choices=(*doors, "all"), default="analysis", help="what the inputs are given to")
    parser.add_argument("--clean", action="store_true", help="logs without a slip, whose truth is known")
    parser.add_argument("--only", action="store_true", help="one input; a log is printed")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    options = parser.parse_args()
    print(f"seed {options.seed}", flush=True)
    if options.only:
        if options.door == "analysis" and not options.clean:
            data, model = draw_input(options.seed)
            sys.stdout.buffer.write(data + f"\nmodel: {model}\n".encode())
            sys.stdout.flush()
        print(WAYS["clean" if options.clean else options.door](options.seed))
        return
    faults = 0
    for door in ["clean"] if options.clean else doors if options.door == "all" else [options.door]:
        faults += try_door(door, range(options.seed, options.seed + options.count), options.workers)
    sys.exit(1 if faults else 0)


def try_door(door: str, seeds: range, workers: int) -> int:
    """Try many inputs at a door, and count the faults."""
    ends: collections.Counter[str] = collections.Counter()
    with ProcessPoolExecutor(workers) as pool:
        tried = pool.map(one, seeds, [door] * len(seeds), chunksize=50)
        for done, (seed, end, fault) in enumerate(tried, 1):
            ends[end] += 1
            if done % 1000 == 0:
                # A run that is stopped has said how far it came.
                print(f"{done} tried", flush=True)
            if fault:
                print(f"{end} {door} seed {seed}: {fault}", flush=True)
    print(f"{door}: {', '.join(f'{count} {end}' for end, count in sorted(ends.items()))}", flush=True)
    return ends["FAULT"] + ends["slow"]


if __name__ == "__main__":
    main()
