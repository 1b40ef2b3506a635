"""Try very many logs: ``python tests/fuzz --count 100000``; every fault is told with the seed that repeats it.

``--seed S --only`` tries one; ``--clean`` draws logs without any slip, whose truth is known, of 3 to 3000 runs.
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
from fuzz.grammar import draw_input
from fuzz.relations import try_log


def one(seed: int, clean: bool) -> tuple[int, str, str]:
    """Try the log of a seed: what became of it, and the fault."""
    begun = time.process_time()
    try:
        if clean:
            return seed, try_clean(seed), ""
        analysis = try_log(*draw_input(seed), thorough=seed % 5 == 0)
        took = time.process_time() - begun
        if took > 30:
            return seed, "slow", f"{took:.1f} s"
        return seed, "refused" if analysis is None else "answered", ""
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}:{last.lineno} {type(error).__name__}"
        return seed, "FAULT", f"{where}: {str(error)[:300]}"


def main() -> None:
    """Run as many as asked for, and exit with 1 if there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the first log")
    parser.add_argument("--clean", action="store_true", help="logs without a slip, whose truth is known")
    parser.add_argument("--only", action="store_true", help="one log, which is printed")
    options = parser.parse_args()
    print(f"seed {options.seed}", flush=True)
    if options.only:
        if options.clean:
            print(try_clean(options.seed))
            return
        data, model = draw_input(options.seed)
        sys.stdout.buffer.write(data + f"\nmodel: {model}\n".encode())
        sys.stdout.flush()
        print(try_log(data, model))
        return
    seeds = range(options.seed, options.seed + options.count)
    ends: collections.Counter[str] = collections.Counter()
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        tried = pool.map(one, seeds, [options.clean] * len(seeds), chunksize=50)
        for done, (seed, end, fault) in enumerate(tried, 1):
            ends[end] += 1
            if done % 1000 == 0:
                # A run that is stopped has said how far it came.
                print(f"{done} tried", flush=True)
            if fault:
                print(f"{end} seed {seed}: {fault}", flush=True)
    print(", ".join(f"{count} {end}" for end, count in sorted(ends.items())))
    sys.exit(1 if ends["FAULT"] or ends["slow"] else 0)


if __name__ == "__main__":
    main()
