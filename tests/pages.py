"""A log with something of everything, and its page, for the tests of the page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html.parser import HTMLParser
from typing import Any

from gyrodata import plotting, reporting
from gyrodata.reporting.phrases import defaults_used
from gyrodata.results import Analysis

HEAD = "run,mass [g],position [cm],spin [rpm],time [s],turns,note\n"
LOG = (
    """# g: 9.803 m/s^2
# ball_mass: 4.10 ± 0.01 kg
# ball_diameter: 10.16 ± 0.005 cm
# group: <img src=x onerror=alert(1)> 77
"""
    + HEAD
    + """1,20.00,15.0,206,20.4,1,
2,20.00,15.0,407,40.4,1,
<b>3,20.00,15.0,601,59.5,1,"<script>alert('x')</script> & more 55"
4,40.00,15.0,203,10.2,1,
5,40.00,15.0,405,20.1,1,
6,40.00,15.0,607,30.1,2,
7,60.00,15.0,201,6.8,1,
8,60.00,15.0,404,13.4,1,
9,60.00,15.0,603,20.0,1,
10,0,,401,160.2,1/12,
"""
)
PIXEL = dict.fromkeys(plotting.FIGURES, b"\x89PNG\r\n")
WORDS = {name: f"what {name} shows" for name in plotting.FIGURES}


def make_page(analysis: Analysis, figures: Mapping[str, bytes] = PIXEL, alt: Mapping[str, str] = WORDS) -> str:
    return reporting.report_page(analysis, figures, "png", alt, plotting.list_looks(analysis))


VOID = {"meta", "img", "br", "hr", "input", "link", "path"}


class Structure(HTMLParser):
    """Tags in order, with a check that every one is closed; numbers marked and other text apart."""

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


# What a report says of itself and of the laws, whatever the log.
FIXED = [
    "Question 3", "3 (a)", "95 %", "2/5", "± 2 u", "± 2u", "eq. (9)", "eq. (8)", "100 rpm", "SHA-256", "n = 1",
    "with 1", "2π", "taken as 0", "as in step 2", "5 % of the torque, moves it by 5 %", "ball_mass: 4.10 ± 0.01 kg",
    "ball_diameter: 10.16 ± 0.01 cm", "Questions 1, 2 and 4", "question 1", "question 2", "question 4", "steps 3 to 5",
    "steps 4 and 6", "step 9", "Eq. (9)", "(60 s)", "York and others 2004", "Ellison 2011", "its 68.3 % interval",
    "from its 2.5 % to its 97.5 %",
    "JCGM 100:2008 and JCGM 101:2008", "Supplement 1", "72, 367 (2004)", "16, 483 (2011)", "eqs. (8) and (9)",
]  # fmt: skip

KINDS = {
    "ball and a slip": LOG,
    "no ball": HEAD + LOG.partition(HEAD)[2],
    "one torque": "# g: 9.81 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
    "165,7.3,308,6.8,1\n165,7.3,500,11,1\n",
    "latitude": "# latitude: 42.5 deg\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15,406,40.1,1\n"
    "40,15,405,20.5,1\n60,15,404,13.7,1\n",
    "one run": "mass [g],position [cm],spin [rpm],time [s],turns\n50,15,400,16.0,1\n",
    "torques, tilted": "torque [N*m],spin [rpm],time [s],turns,pitch [deg]\n0.05,400,24.0,1,10\n0.1,400,12.0,1,20\n"
    "0.1,600,17.6,1,-15\n",
    "far too much scatter": "# g: 9.803 m/s^2\n# u_time: 0.01 s\nmass [g],position [cm],spin [rpm],time [s],turns\n"
    "20,15,206,20.9,1\n20,15,407,40.1,1\n40,15,405,20.5,1\n40,15,607,29.8,1\n60,15,404,13.7,1\n60,15,603,19.8,1\n",
    "other side, heavy": "mass [kg],position [cm],spin [rpm],time [s],turns,note\n12,-15,400,160.0,1,9\n"
    "24,-15,400,80.3,1,\n24,-15,800,160.9,1,\n",
}


def known(analysis: Analysis) -> list[str]:
    """Texts with digits that are no numbers of the result, the longest first: what the log says, and what is fixed."""
    document = json.loads(reporting.json_text(analysis.to_dict()))
    # What is short and begins with a digit may be a number that is shown.
    quoted = [text for text in strings(document) if len(text) > (20 if text[:1].isdigit() else 3)]
    texts = {*quoted, *FIXED, *analysis.readings.metadata.values(), *map(str.strip, defaults_used(analysis))}
    return sorted((text for text in texts if any(map(str.isdigit, text))), key=len, reverse=True)
