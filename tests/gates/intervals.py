"""Gate 6: the 95 % interval contains the true I_zz in 92 to 99 % of the labs, in each of 12 cells.

The labs are drawn by `gates.labs`, which uses no code of the package, typed as logs and given to `gyrodata.analyze`. In
most cells something is worse than the log says: a bad hand, a bad balance, a late reading of the spin, a false balance
test. The same labs are drawn in each run, so the counts change only if the answers do.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import gyrodata
from gates.labs import INERTIA, Bench, typed
from gates.stored import Found

LABS = 150
NINE, MANY = Bench(), Bench(repeats=3)
STATED = "# u_time: 0.14 s\n"
CELLS = {
    "9 runs, as stated": NINE._replace(lines=STATED),
    "27 runs, as stated": MANY._replace(lines=f"{STATED}# u_time_bias: 0.05 s\n# u_spin_delay: 0 s\n"),
    "9 runs, hand 0.5 s, 0.14 s stated": NINE._replace(hand=0.5, lines=STATED),
    "9 runs, hand of heavy tails, 0.14 s stated": NINE._replace(hand=0.4, tails=3, lines=STATED),
    "27 runs, hand errs by 4 % of the time": MANY._replace(hand=0.0, in_proportion=1 / 24),
    "3 runs, hand 0.5 s": Bench(spins=(400,), hand=0.5),
    "9 runs, M0 20 % of the lightest torque": NINE._replace(imbalance=0.2),
    "9 runs, a balance test that is false": NINE._replace(
        imbalance=0.1, hand=0.3, lines="# balance_drift: 1 deg in 60 s at 400 rpm\n"
    ),
    "27 runs, hand late by 0.11 s": MANY._replace(late=0.11, late_u=0.04),
    "9 runs, thirds of a turn, sighting 3 deg": NINE._replace(thirds=True, sighting=3.0),
    "9 runs, spin read 2 s late": NINE._replace(time_constant=300.0, delay=2.0),
    "9 runs, rod tilted by 30 deg": NINE._replace(pitch=30.0),
}  # fmt: skip


def inside(job: tuple[Bench, int]) -> bool:
    """Whether the interval of one lab contains the truth; a lab that is refused counts as one that does not."""
    bench, seed = job
    try:
        interval = gyrodata.analyze(typed(bench, seed)).inertia.interval_95
    except gyrodata.GyroError:
        return False
    return interval is not None and interval[0] <= INERTIA <= interval[1]


def gate(accept: bool = False, part: bool = False) -> Found:
    """Draw the labs of all cells, or a few of one cell."""
    cells = dict(list(CELLS.items())[:1]) if part else CELLS
    labs = LABS // 4 if part else LABS
    jobs = [(bench, 1000 * at + lab) for at, bench in enumerate(cells.values()) for lab in range(labs)]
    if part:
        held = [inside(job) for job in jobs]
    else:
        with ProcessPoolExecutor(2) as pool:
            held = list(pool.map(inside, jobs, chunksize=40))
    shares = {name: 100 * sum(held[at * labs :][:labs]) / labs for at, name in enumerate(cells)}
    wrong = [
        f"{name}: 92 to 99 % | {share:.1f} %" for name, share in shares.items() if not 92 <= share <= 99 and not part
    ]
    low, high = min(shares.values()), max(shares.values())
    return Found(f"{low:.1f} to {high:.1f} % in {len(cells)} cells of {labs} labs", "92 to 99 %", not wrong, wrong or [
        f"{name}: {share:.1f} %" for name, share in shares.items()])  # fmt: skip
