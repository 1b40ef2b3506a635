"""Let every call to the system fail in turn: ``python tests/faults``; each fault is told with its number.

``--scene NAME --call N`` tries one; ``--kills 200`` kills drivers and workers of real runs at random times instead.
"""

from __future__ import annotations

import argparse
import re
import secrets
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from faults.calls import WAYS
from faults.kills import try_kills
from faults.scenes import NAMES, Promise, scene_of


def main() -> None:
    """Try all that is asked for, and exit with 1 if something did not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", choices=NAMES)
    parser.add_argument("--way", action="append", choices=WAYS)
    parser.add_argument("--call", type=int, help="only this one")
    parser.add_argument("--named", default="", metavar="REGEX", help="only these, such as 'pipe|dup|fork_exec|sendfds'")
    parser.add_argument("--step", type=int, default=1, help="every so many calls")
    parser.add_argument("--in-turn", action="store_true", help="one way for each call, not all of them")
    parser.add_argument("--list", action="store_true", help="list the calls of a run, and stop")
    parser.add_argument("--kills", type=int, metavar="N", help="kill so many drivers and workers of real runs instead")
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the times of the kills")
    options = parser.parse_args()
    faults = 0
    if options.kills:
        print(f"seed {options.seed}", flush=True)
        with tempfile.TemporaryDirectory() as room:
            for wrong in try_kills(Path(room), options.kills, options.seed):
                faults += 1
                print(wrong, flush=True)
        print(f"{options.kills} kills, {faults} faults")
        sys.exit(1 if faults else 0)
    for name in options.scene or NAMES:
        with tempfile.TemporaryDirectory() as room:
            promise = Promise(scene_of(name, Path(room)), Path(room))
            if options.list:
                print("\n".join(f"{at + 1} {call}" for at, call in enumerate(promise.calls)))
                continue
            named = [at for at, call in enumerate(promise.calls, 1) if re.match(options.named, call)]
            at = [options.call] if options.call else named[:: options.step]
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
