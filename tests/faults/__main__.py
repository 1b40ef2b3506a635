"""Let every call to the system fail in turn: ``python tests/faults``; each fault is told with its number.

``--scene NAME --call N`` tries one; ``--kills 200`` kills drivers and workers of real runs at random times instead.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from faults.calls import WAYS
from faults.scenes import NAMES, Promise, scene_of


def main() -> None:
    """Try all that is asked for, and exit with 1 if something did not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", choices=NAMES)
    parser.add_argument("--way", action="append", choices=WAYS)
    parser.add_argument("--call", type=int, help="only this one")
    parser.add_argument("--step", type=int, default=1, help="every so many calls")
    parser.add_argument("--in-turn", action="store_true", help="one way for each call, not all of them")
    parser.add_argument("--list", action="store_true", help="list the calls of a run, and stop")
    options = parser.parse_args()
    faults = 0
    for name in options.scene or NAMES:
        with tempfile.TemporaryDirectory() as room:
            promise = Promise(scene_of(name, Path(room)), Path(room))
            if options.list:
                print("\n".join(f"{at + 1} {call}" for at, call in enumerate(promise.calls)))
                continue
            at = [options.call] if options.call else range(1, len(promise.calls) + 1, options.step)
            begun, tried = time.perf_counter(), 0
            ways = options.way or WAYS
            for number in at:
                for way in ways[number % len(ways) :][:1] if options.in_turn else ways:
                    # A disk that is full stays so.
                    for lasting in (False, True)[: 1 + (way == "ENOSPC")]:
                        tried += 1
                        for wrong in promise.break_at(number, way, lasting):
                            faults += 1
                            print(wrong, flush=True)
            took = time.perf_counter() - begun
            print(f"{name}: {len(promise.calls)} calls, {tried} runs, {took:.0f} s", flush=True)
    print(f"{faults} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
