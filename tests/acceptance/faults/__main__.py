"""Let every call to the system fail in turn: ``python tests/acceptance/faults``; or
``--kills 200``: kill runs at random times.
"""

import argparse
import secrets
import sys
import tempfile
from pathlib import Path

sys.path += [
    str(Path(__file__).parents[2] / room) for room in ("acceptance", "support", "")
]

from faults.calls import WAYS
from faults.scenes import SCENES, Promise, try_kills


def main() -> None:
    """Try all that is asked for, and exit with 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", action="append", choices=SCENES)
    parser.add_argument("--step", type=int, default=1, help="every so many calls")
    parser.add_argument(
        "--kills", type=int, default=0, metavar="N", help="kill so many runs instead"
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=secrets.randbelow(2**31),
        help="of the times of the kills",
    )
    options = parser.parse_args()
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as room:
        if options.kills:
            print(f"seed {options.seed}", flush=True)
            wrong += try_kills(Path(room), options.kills, options.seed)
        for name in () if options.kills else options.scene or SCENES:
            promise = Promise(name, Path(room) / name)
            for at in range(1, len(promise.calls) + 1, options.step):
                # A disk that is full stays full.
                for way, lasting in [(way, False) for way in WAYS] + [("ENOSPC", True)]:
                    wrong += [
                        f"{name}: {told}" for told in promise.break_at(at, way, lasting)
                    ]
            print(f"{name}: {len(promise.calls)} calls", flush=True)
    print("\n".join(wrong), f"{len(wrong)} faults", sep="\n")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
