"""Name the roles that a run or a log lacks."""

from __future__ import annotations

from collections.abc import Collection

from gyrodata.readings import roles


def missing_roles(there: set[str], columns: Collection[str], loaded: bool) -> list[str]:
    """Name what a run lacks, or the whole log.

    Of several roles that serve, one that the log has a column of. A run that is not
    `loaded` needs no load.
    """
    missing = _missing_load(there, columns) if loaded else []
    return [*missing, *_missing_spin(there, columns), *_missing_timing(there, columns)]


def _missing_load(there: set[str], columns: Collection[str]) -> list[str]:
    if "torque" in there:
        return []
    pulls = [role for role in ("mass", "force", "torque") if role in columns]
    pull = pulls[0] if pulls else "mass"
    missing = [pull] if there.isdisjoint(("mass", "force")) else []
    if pull != "torque" and "position" not in there:
        missing.append("position")
    return missing


def _missing_spin(there: set[str], columns: Collection[str]) -> list[str]:
    if any(there.issuperset(names) for names in roles.SPIN_SETS):
        return []
    known = there.union(columns)
    begun = [names for names in roles.SPIN_SETS if not known.isdisjoint(names)]
    needed = begun[0] if begun else ("spin",)
    return [role for role in needed if role not in there]


def _missing_timing(there: set[str], columns: Collection[str]) -> list[str]:
    if not there.isdisjoint(roles.ONE_TURN):
        return []
    missing = [] if "time" in there else ["time"]
    whole = [role for role in roles.ONE_TURN if role in columns]
    if whole and "time" not in columns:
        return whole[:1] if missing else []
    return [*missing, *_missing_count(there, columns)]


def _missing_count(there: set[str], columns: Collection[str]) -> list[str]:
    if not there.isdisjoint(roles.COUNTS):
        return []
    counts = [role for role in roles.COUNTS if role in columns]
    return counts[:1] or ["turns"]
