"""A log with something of everything, and its page, for the tests of the page."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from functools import cache
from html.parser import HTMLParser
from typing import Any

from places import DATA

from gyrodata import analyze
from gyrodata.reporting.content import defaults_used
from gyrodata.reporting.data import json_text
from gyrodata.reporting.figures import FIGURES
from gyrodata.reporting.page import report_page
from gyrodata.results import Analysis

TOLD = tomllib.loads((DATA / "texts_of_the_page.toml").read_text(encoding="utf-8"))
KINDS: dict[str, str] = TOLD["logs"]
LOG = KINDS["ball and a slip"]
IN_ORDER = tuple(FIGURES)


@cache
def analysis_of(kind: str) -> Analysis:
    """Analyse a log of `KINDS`, once for all tests of a process."""
    return analyze(KINDS[kind].encode(), name="log.csv")


EMPTY = dict.fromkeys(FIGURES, b"<svg/>")


def make_page(analysis: Analysis, figures: Mapping[str, bytes] = EMPTY) -> str:
    return report_page(analysis, figures)


VOID = {"meta", "img", "br", "hr", "input", "link", "path"}


class Structure(HTMLParser):
    """Tags in order, with a check that every one is closed; numbers marked and other
    text apart.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.numbers: list[tuple[dict[str, str | None], str]] = []
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag == "data":
            self.numbers.append((dict(attrs), ""))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "data" in self.open:
            attributes, text = self.numbers[-1]
            self.numbers[-1] = attributes, text + data
        elif not {"style", "script", "q", "title"} & set(self.open):
            self.text += data


def find(document: dict[str, Any], place: str) -> Any:
    """What stands at a place of results.json, as the page gives it."""
    found: Any = document if place.startswith("/") else document["result"]
    for key in place.removeprefix("/").split("."):
        if isinstance(found, list) and key == "length":
            return len(found)
        found = found[int(key) if isinstance(found, list) else key]
    return found


def strings(found: Any) -> list[str]:
    """Every text in a document."""
    if isinstance(found, dict):
        return strings([*found, *found.values()])
    if isinstance(found, list):
        return [text for value in found for text in strings(value)]
    return [found] if isinstance(found, str) else []


def known(analysis: Analysis) -> list[str]:
    """Texts with digits that are no numbers of the result, the longest first: what the
    log says, and what is fixed.
    """
    document = json.loads(json_text(analysis.to_dict()))
    # What is short and begins with a digit may be a number that is shown.
    quoted = [
        text
        for text in strings(document)
        if len(text) > (20 if text[:1].isdigit() else 3)
    ]
    texts = {
        *quoted,
        *TOLD["fixed"],
        *analysis.readings.metadata.values(),
        *map(str.strip, defaults_used(analysis)),
    }
    return sorted(
        (text for text in texts if any(map(str.isdigit, text))), key=len, reverse=True
    )
