"""Whose names the files of a class have, and what each says: a platform's, or a folder or file for each student."""

from __future__ import annotations

import re

from gyrodata.grading import gradescope_metadata as gradescope
from gyrodata.grading.choice import ending, is_answers, is_log
from gyrodata.grading.patterns import PLATFORMS, Named, fit, recognise, shown

_NO_SUBMISSION = (".md", ".json", ".ndjson", ".html", ".py", ".yml", ".yaml", ".ini", ".sh")
"""Endings of what stands beside the files of a flat folder and is no student's."""


def whose_names(names: list[str], folders: tuple[str, ...], lms: str, packed: bool) -> tuple[str, str]:
    """Tell whose names they are and below which folder they stand.

    `names`: All files of the class, parts joined by ``/``. `folders`: All its folders, each with a ``/`` at its end.
    `lms`: ``auto``, ``folder`` or one of `PLATFORMS`. `packed`: Whether it is a zip, which as a rule holds the folder
    that was packed. Gives: ``folder`` or one of `PLATFORMS`; and the folder around all files, with a ``/`` at its end,
    or "".
    """
    outer = _outer_folder([*names, *folders])
    for below in ("", outer) if outer else ("",):
        inner = [name.removeprefix(below) for name in names]
        seen = "gradescope" if gradescope.EXPORT in inner else recognise(inner)
        if lms == "auto" and seen:
            return seen, below
        if lms in PLATFORMS and any(fit(name, lms) for name in inner):
            return lms, below
    if lms in PLATFORMS:
        return lms, ""
    return "folder", _class_folder(names, outer, packed)


def _outer_folder(names: list[str]) -> str:
    """Find the folder that all files stand in."""
    firsts = {name.partition("/")[0] for name in names}
    return f"{firsts.pop()}/" if len(firsts) == 1 and all("/" in name for name in names) else ""


def _class_folder(names: list[str], outer: str, packed: bool) -> str:
    """Tell a folder around the class from the folder of its only student: the class's holds the logs of several."""
    logs = [name.removeprefix(outer) for name in names if is_log(name)]
    people = {name.partition("/")[0] for name in logs if "/" in name}
    if packed:
        people |= {_flat_key(name) for name in logs if "/" not in name}
    return outer if len(people) > 1 else ""


def name_all(names: list[str], lms: str, below: str) -> dict[str, Named | None]:
    """Read each name as `whose_names` found; None for a file of no student."""
    inner = {name: name.removeprefix(below) for name in names}
    if lms == "folder":
        nested = {"/" in own for own in inner.values() if is_log(own)} or {"/" in own for own in inner.values()}
        in_folders = True in nested
        return {name: _fit_folder(own, in_folders) for name, own in inner.items()}
    return {name: fit(own, lms) for name, own in inner.items()}


def _fit_folder(name: str, in_folders: bool) -> Named | None:
    """Read a name of a class with a folder, or where there are none with a file, for each student."""
    first, slash, rest = name.partition("/")
    if in_folders:
        student = shown(first) or "_"
        return Named(student, student, {"folder": student}, rest, student) if slash else None
    if slash or ending(name) in _NO_SUBMISSION:
        return None
    student = _flat_key(name)
    return Named(student, student, {"folder": student}, name, student)


def _flat_key(name: str) -> str:
    """Key of a student with a file of their own: ``jdoe`` of ``jdoe.csv``, ``jdoe (1).csv``, ``jdoe_answers.toml``."""
    stem = re.sub(r"(?i)(?:\.toml\.txt|\.[^.]+(?:\.gz)?)$", "", name) or name
    if is_answers(name):
        stem = re.sub(r"(?i)[-_. ]?answers$", "", stem) or stem
    return shown(re.sub(r" ?\([0-9]{1,2}\)$", "", stem)) or "_"
