"""What to type for a header that could not be placed: what it seems to measure, and how many turns it tells of."""

from __future__ import annotations

import re

from gyrodata.readings.headers import MAX_HEADER, parse_header, suggest_role
from gyrodata.units import kinds_of

_DEGREES = re.compile(r"([0-9]+(?:[.,][0-9]+)?)\s*(?:°|º|˚|deg)")
_HALF = re.compile(r"half|halb|demi|medi[oa]\b|meia|pół|полов|1/2|½|/\s*2(?![0-9])", re.IGNORECASE)
_COUNT = re.compile(
    r"(?<![0-9.,_])([0-9]{1,2}(?:[.,]5)?)\s*"
    r"(?:T\b|(?:\w+\s)?(?:turn|rev|cycle|rotation|tour|Umdreh|Umläuf|об|vuelt|volta|obrot|periods?\b))",
    re.IGNORECASE,
)
_REPEAT = re.compile(r"(?<![0-9])([1-9])(?:ª|º|\.|st|nd|rd|th)?(?![0-9])")


def stated_turns(header: str) -> str:
    """Find the turns or the angle that a header says its time covers.

    Parameters
    ----------
    header : str
        As written: ``T/2 (s)``, ``T Ω(180°) (s)``, ``time for 10 revolutions``.

    Returns
    -------
    str
        ``turns=1/2``, ``angle="180 deg"``, ``turns=10``; "" if it says nothing of the kind.
    """
    match = _DEGREES.search(header)
    if match:
        return f'angle="{match[1].replace(",", ".")} deg"'
    match = _COUNT.search(header)
    if match:
        return f"turns={match[1].replace(',', '.')}"
    return "turns=1/2" if _HALF.search(header) else ""


def advise(role: str, headers: list[str]) -> str:
    """Propose what to type for a missing role, from the headers that could not be placed.

    Parameters
    ----------
    role : str
        What is missing.
    headers : list of str
        As written.

    Returns
    -------
    str
        To stand in front of the general hint; "" where no header looks like it.
    """
    headers = [header for header in headers if len(header) <= MAX_HEADER]
    if role in ("time", "turns"):
        timed = [header for header in headers if _is_time(header)]
        told = [header for header in timed if stated_turns(header) and not _is_of_spin(header, timed)]
        if len(told) == 1:
            return f'is it --map time="{told[0]}" --set {stated_turns(told[0])}? '
        numbered = [header for header in timed if _REPEAT.search(header)]
        if role == "time" and len(numbered) > 1:
            ways = " ".join(f'--map time_{i}="{header}"' for i, header in enumerate(numbered[:4], 1))
            return f"are they repeats? {ways}{' …' if len(numbered) > 4 else ''}; "
        whole = [header for header in timed if suggest_role(header) == "precession_period"]
        if role == "time" and whole:
            return f'is it --map precession_period="{whole[0]}", the time of one whole turn? '
    if role == "spin":
        turned = [header for header in headers if _is_time(header) and _is_of_spin(header, headers)]
        if turned:
            return f'is it "{turned[0]}"? divide by the turns, and write spin_period [s] (or _start, _end); '
    close = [header for header in headers if suggest_role(header) == role and (role != "turns" or not _is_time(header))]
    return f'is it "{close[0]}"? ' if close else ""


def _is_time(header: str) -> bool:
    unit = parse_header(header).unit
    return unit is not None and "time" in kinds_of(unit)


def _is_of_spin(header: str, headers: list[str]) -> bool:
    """Tell a time of turns of the wheel from one of the precession: read before and after, or so called."""
    lower = header.lower()
    if re.search(r"pr[äeéê][cz][eé]?[sc]|прецес", lower):
        return False
    if re.search(r"spin|wheel|dis[ck]|rotor|initial|final|before|after|start|end\b", lower):
        return bool(stated_turns(header))
    return False
