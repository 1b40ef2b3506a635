"""Leave out of a text what a person who opens it does not see: it is no answer.

Pages of HTML, and the XML of word processors, go through the parser of the standard library, which writes them again
without hidden text. LaTeX and Markdown lose what is not typeset, a workbook loses its hidden sheets, and a line ends
in front of more blanks than a screen is wide.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from html.parser import HTMLParser
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import replace

Attributes = Mapping[str, str]
"""Of one element, by their names in small letters."""
Style = dict[str, str]
"""Declarations of CSS: values by property, all in small letters."""
Color = tuple[float, ...]
"""Red, green and blue, each from 0 to 1."""

# --- how text looks ------------------------------------------------------------------------------------------

WHITE: Color = (1.0, 1.0, 1.0)
FAINTEST = 1.2  # smallest contrast of text that can be read; black on white has 21
SMALLEST = 3.0  # smallest height of letters that can be read [pt]
FAR_OUT = -500.0  # a shift of so many pixels leads out of the screen

_PALE_NAMES = "white snow ivory ghostwhite whitesmoke floralwhite mintcream azure seashell transparent"
_PALE = frozenset(_PALE_NAMES.split())
_LENGTH = re.compile(r"\s*(-?[\d.]+)\s*(px|pt|em|rem|%|cm|mm|)")
_POINTS = {"px": 0.75, "pt": 1.0, "em": 12.0, "rem": 12.0, "%": 0.12, "cm": 28.3, "mm": 2.83, "": 0.75}
"""Length of each unit [pt], if the letters around are of 12 pt."""


class Look(Struct, frozen=True):
    """How the text of an element looks."""

    tag: str = ""
    classes: frozenset[str] = frozenset()
    """Its name, its classes with ``.`` and its id with ``#``."""
    gone: bool = False  # neither the element nor anything in it is shown
    hidden: bool = False  # by its visibility, which an element in it may have again
    tiny: bool = False
    color: Color | None = None  # None: as usual
    background: Color | None = None

    @property
    def seen(self) -> bool:
        """Whether a person sees text that looks so."""
        if self.gone or self.hidden or self.tiny:
            return False
        return self.color is None or contrast(self.color, self.background or WHITE) >= FAINTEST


def contrast(one: Color, other: Color) -> float:
    """Return the contrast of two colours by the formula of WCAG, from 1 to 21."""
    low, high = sorted(map(_brightness, (one, other)))
    return (high + 0.05) / (low + 0.05)


def _brightness(color: Color) -> float:
    red, green, blue = color
    return float(0.21 * red**2.2 + 0.72 * green**2.2 + 0.07 * blue**2.2)


def color_of(text: str) -> Color | None:
    """Read a colour; None for one that is not nearly white, or not known."""
    text = text.strip().lower()
    if text.split(" ")[0] in _PALE:
        return WHITE
    if match := re.match(r"#?([0-9a-f]{3}|[0-9a-f]{6})(?:[0-9a-f]{1,2})?(?![\w#])", text):
        size = len(match[1]) // 3
        return tuple(int(match[1][at : at + size] * (3 - size), 16) / 255 for at in range(0, 3 * size, size))
    numbers = re.findall(r"[\d.]+%?", text) if text.startswith(("rgb", "hsl")) else []
    if len(numbers) == 4 and float(numbers[3].rstrip("%")) == 0:
        return WHITE  # transparent
    if text.startswith("hsl"):
        return WHITE if numbers[2:] and float(numbers[2].rstrip("%")) >= 98 else None
    parts = [float(one[:-1]) / 100 if one[-1] == "%" else float(one) / 255 for one in numbers[:3]]
    return tuple(parts) if len(parts) == 3 else None


def _points(text: str) -> float:
    """Read a length [pt]; that of usual letters if it is not a number."""
    match = _LENGTH.match(text)
    try:
        return float(match[1]) * _POINTS[match[2]] if match else 12.0
    except ValueError:
        return 12.0


def _is_gone(style: Style) -> bool:
    """Return whether an element is not drawn, or outside of the screen, or has no size."""
    cut = style.get("overflow", "").startswith(("hidden", "clip"))
    flat = any(_points(style.get(key, "")) <= 0 for key in ("height", "max-height", "width", "max-width"))
    out = any(_points(style.get(key, "")) < FAR_OUT for key in ("left", "top", "text-indent", "margin-left"))
    clipped = re.match(r"rect\(\s*[01](?:px)?[\s,]+[01]|inset\(\s*(?:50|100)%", style.get("clip", ""))
    return (
        style.get("display", "").startswith("none")
        or _points(style.get("opacity", "1")) < 0.05
        or (cut and flat)
        or out
        or clipped is not None
        or re.match(r"scale\(\s*0\s*[,)]", style.get("transform", "")) is not None
        or "line-through" in style.get("text-decoration", "")
    )


def look_of(tag: str, names: frozenset[str], style: Style, around: Look) -> Look:
    """Return how an element looks in another one."""
    look = replace(around, tag=tag, classes=names, gone=around.gone or _is_gone(style))
    if "visibility" in style:
        look = replace(look, hidden=style["visibility"].startswith(("hidden", "collapse")))
    if size := style.get("font-size"):
        # A share of nothing is nothing.
        is_share = re.search(r"(?:em|%)\s*$", size) is not None
        look = replace(look, tiny=_points(size) < SMALLEST or (is_share and around.tiny))
    if style.get("color", "inherit") != "inherit":
        look = replace(look, color=color_of(style["color"]))
    behind = style.get("background-color") or style.get("background") or ""
    if behind.split(" ")[0] not in ("", "none", "transparent", "inherit", "initial", "unset"):
        # On an image, or on a colour by another name, white text may well be seen.
        look = replace(look, background=color_of(behind) or (0.5, 0.5, 0.5))
    return look


# --- style sheets ----------------------------------------------------------------------------------------------

Rules = list[tuple[list[frozenset[str]], Style]]
"""Simple selectors, each as the names that an element and those around it need, with the declarations for it."""
_SHOWN_RULES = re.compile(r"@(?:media\s+(?:all|screen)|layer\b.*|supports\b.*)", re.DOTALL)


def declarations(text: str) -> Style:
    """Read the declarations between two braces, or those of an attribute."""
    pairs = (one.partition(":") for one in text.lower().split(";"))
    style = {key.strip(): value.replace("!important", "").strip() for key, _, value in pairs}
    for key, short in (("text-decoration", "text-decoration-line"), ("clip", "clip-path")):
        if short in style:
            style[key] = style[short]
    return style


def rules_of(sheet: str) -> Rules:
    """Read the rules of a style sheet for elements by name, class, id, and those around them."""
    found: Rules = []
    selectors: list[list[frozenset[str]]] = []
    before, skipped = "", 0
    for part in re.findall(r"[{}]|[^{}]+", re.sub(r"(?s)/\*.*?(?:\*/|\Z)", "", sheet)):
        if skipped:
            # Nothing of a rule for printers, or for small screens, is for everybody.
            skipped += {"{": 1, "}": -1}.get(part, 0)
        elif part == "{" and before.startswith("@") and not _SHOWN_RULES.fullmatch(before):
            skipped, before = 1, ""
        elif part == "}" and before:
            found += [(one, declarations(before)) for one in selectors]
            before = ""
        elif part == "{":
            selectors, before = [] if before.startswith("@") else list(_selectors(before)), ""
        else:
            before = "" if part == "}" else part.strip()
    return found


def _selectors(text: str) -> Iterator[list[frozenset[str]]]:
    """Read the selectors in front of a brace; those with a condition are left out."""
    for one in text.lower().split(","):
        parts = re.sub(r"\s*>\s*", " ", one.strip()).split()
        if parts and all(re.fullmatch(r"(?:[\w-]+|\*)?(?:[.#][\w-]+)*", part) for part in parts):
            yield [frozenset(re.findall(r"[.#]?[\w-]+", part)) for part in parts]


def _fits(selector: Sequence[frozenset[str]], names: frozenset[str], around: Sequence[Look]) -> bool:
    """Return whether a selector is about an element with these names, in these elements."""
    *outer, last = selector
    if not last <= names:
        return False
    left = iter(reversed(around))
    return all(any(part <= look.classes for look in left) for part in reversed(outer))


# --- pages and texts of word processors ---------------------------------------------------------------------------

_EMPTY = frozenset(
    ["area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "param", "source", "track", "wbr"]
)
_OF_PAGES = "script style template title noscript noframes iframe datalist canvas audio video desc metadata defs"
_OF_DOCUMENTS = "text:tracked-changes text:hidden-text text:hidden-paragraph w:del w:movefrom w:instrtext"
_UNSEEN = frozenset(f"{_OF_PAGES} {_OF_DOCUMENTS}".split())
"""Elements whose text nobody sees."""
_BLOCKS = "p div ul ol table h1 h2 h3 h4 h5 h6 section article pre hr blockquote"
_CELLS, _TERMS = frozenset(["td", "th", "tr"]), frozenset(["dt", "dd"])
_ENDED_BY: Mapping[str, frozenset[str]] = {
    "p": frozenset(_BLOCKS.split()), "td": _CELLS, "th": _CELLS, "dt": _TERMS, "dd": _TERMS,
    **{name: frozenset([name]) for name in ("li", "tr", "option")},
}  # fmt: skip
"""Elements that end where another one begins, if their own end is left out."""


class _Page(HTMLParser):
    """Write a page again, without the text that a person does not see."""

    def __init__(self, rules: Rules, styles: Mapping[str, Style]) -> None:
        super().__init__(convert_charrefs=False)
        self.rules, self.styles = rules, styles
        self.written: list[str] = []
        self.sheets: list[str] = []
        self.around = [Look()]
        self.open: dict[str, int] = {}  # how many elements of each name are open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        while self.around[-1].tag in _ENDED_BY and tag in _ENDED_BY[self.around[-1].tag]:
            self._leave(self.around[-1].tag)
        self._write_tag(tag)
        if tag not in _EMPTY:
            self.around.append(self._look(tag, {name: value or "" for name, value in attrs}))
            self.open[tag] = self.open.get(tag, 0) + 1

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._write_tag(tag)
        if ":" not in tag and tag not in _EMPTY:
            # In HTML, "<span/>" begins a span.
            self.around.append(self._look(tag, {name: value or "" for name, value in attrs}))
            self.open[tag] = self.open.get(tag, 0) + 1

    def handle_endtag(self, tag: str) -> None:
        self.written.append(f"</{tag}>")
        self._leave(tag)

    def _leave(self, tag: str) -> None:
        while self.open.get(tag):
            left = self.around.pop().tag
            self.open[left] -= 1
            if left == tag:
                return

    def _write_tag(self, tag: str) -> None:
        text = self.get_starttag_text() or ""
        # A ">" in an attribute is not the end of its tag.
        self.written.append(f"<{tag}>" if re.search("[<>]", text[1:-1]) else text)

    def _look(self, tag: str, attributes: Attributes) -> Look:
        names = {tag, *(f".{one}" for one in attributes.get("class", "").lower().split())}
        names |= {f"#{attributes['id'].lower()}"} if attributes.get("id") else set()
        style: Style = {}
        for selector, declared in self.rules:
            if _fits(selector, frozenset(names), self.around):
                style |= declared
        style |= {key: attributes[name] for name, key in _AS_STYLE.items() if attributes.get(name)}
        style |= self.styles.get(attributes.get("text:style-name", ""), {})
        style |= declarations(attributes.get("style", ""))
        is_closed = tag == "dialog" and "open" not in attributes
        if tag in _UNSEEN or is_closed or "hidden" in attributes or attributes.get("text:display") == "none":
            style["display"] = "none"
        return look_of(tag, frozenset(names), style, self.around[-1])

    def handle_data(self, data: str) -> None:
        if self.around[-1].tag == "style":
            self.sheets.append(data)
        if self.around[-1].seen:
            self.written.append(data)

    def handle_entityref(self, name: str) -> None:
        self.handle_data(f"&{name};")

    def handle_charref(self, name: str) -> None:
        self.handle_data(f"&#{name};")

    def unknown_decl(self, data: str) -> None:
        if data.startswith("CDATA["):
            self.handle_data(data[6:])


_AS_STYLE = {"color": "color", "bgcolor": "background-color"}
"""Attributes that say the same as a declaration."""


_DATA = re.compile(r"""(["'])data:[^"'<>]*\1""")
"""A picture in an attribute, as text."""
_NO_TAG = re.compile(r"""<(?![!?]|/?[a-zA-Z](?:[^<>"']|"[^"]{0,5000}"|'[^']{0,5000}')*+>)""")
"""A "<" that does not begin a tag."""

Parser = TypeVar("Parser", bound=HTMLParser)


def _parsed(parser: Parser, text: str) -> Parser:
    """Read a whole text with a parser, and return it."""
    # A comment without an end goes on to the end of the page.
    comment = text.find("<!--", text.rfind("-->") + 1)
    if comment >= 0 and "</script" not in text[comment:].lower():
        text = text[:comment]
    # The parser looks for the end of each "<" again and again, and stops at a declaration that it does not know.
    text = _NO_TAG.sub("&lt;", _DATA.sub('""', text))
    parser.feed(re.sub(r"<!\[(?!CDATA\[)", "&lt;![", text))
    parser.close()
    return parser


def page_seen(text: str, styles: Mapping[str, Style] | None = None) -> str:
    """Return a page, or Markdown with elements of HTML, without its unseen text."""
    if "<" not in text:
        return text
    first = _parsed(_Page([], styles or {}), text)
    rules = rules_of("\n".join(first.sheets))
    return "".join((_parsed(_Page(rules, styles or {}), text) if rules else first).written)


class _Elements(HTMLParser):
    """The start tags of an XML file whose names begin so, with their attributes."""

    def __init__(self, *beginnings: str) -> None:
        super().__init__()
        self.beginnings = beginnings
        self.found: list[tuple[str, Attributes]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag.startswith(self.beginnings):
            self.found.append((tag, {name: value or "" for name, value in attrs}))


_OF_TEXT = {"text:display": "display", "fo:color": "color", "fo:font-size": "font-size",
            "fo:background-color": "background-color", "style:text-line-through-style": "line"}  # fmt: skip


def open_text_seen(content: str) -> str:
    """Return the text of an OpenDocument without its hidden text."""
    styles: dict[str, Style] = {}
    name = ""
    for tag, attributes in _parsed(_Elements("style:"), content).found:
        if tag == "style:style":
            name = attributes.get("style:name", "")
        elif tag == "style:text-properties" and name:
            styles[name] = {key: attributes[one].lower() for one, key in _OF_TEXT.items() if one in attributes}
            if styles[name].get("line", "none") != "none":
                styles[name]["text-decoration"] = "line-through"
    return page_seen(content, styles)


# --- Word ------------------------------------------------------------------------------------------------------

_OFF = ("0", "false", "off", "none")
_RUNS = ("w:r", "m:r")
"""Pieces of text, and of formulas."""
_IN_RUNS = (["w:r"], ["m:r"])


class _Run(Struct, frozen=True):
    """What the properties of a piece of text in Word, or of a style, say of it."""

    hidden: bool = False
    pale: bool = False  # white, or nearly so
    shaded: bool = False

    @property
    def seen(self) -> bool:
        """Whether a person sees it."""
        return not self.hidden and (self.shaded or not self.pale)


def _with_property(run: _Run, tag: str, attributes: Attributes) -> _Run:
    """Add one property of Word."""
    value = attributes.get("w:val", "").lower()
    if tag in ("w:vanish", "w:specvanish", "w:webhidden", "w:strike", "w:dstrike"):
        return replace(run, hidden=value not in _OFF)
    if tag == "w:sz":
        return replace(run, hidden=run.hidden or (value.isdigit() and int(value) / 2 < SMALLEST))
    if tag == "w:color":
        color = color_of(f"#{value}")
        pale = color is not None and contrast(color, WHITE) < FAINTEST
        return replace(run, pale=pale or attributes.get("w:themecolor", "").lower() in ("background1", "light1"))
    if tag in ("w:shd", "w:highlight", "w:tblstyle"):
        fill = attributes.get("w:fill", value).lower()
        return replace(run, shaded=run.shaded or fill not in ("", "auto", "ffffff", "white", "clear", "none"))
    return run


class _Word(HTMLParser):
    """Write the XML of Word again, without the runs of text that are hidden, white or struck out."""

    def __init__(self, styles: Mapping[str, _Run]) -> None:
        super().__init__(convert_charrefs=False)
        self.styles = styles
        self.written: list[str] = []
        self.cell, self.paragraph, self.run = _Run(), _Run(), _Run()
        self.inside: list[str] = []  # of what the properties are that come next: "w:tc", "w:p", "w:r"
        self.unseen = 0  # open elements whose text nobody sees

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._property(tag, {name: value or "" for name, value in attrs})
        self.unseen += tag in _UNSEEN
        if tag in ("w:tbl", "w:tc", "w:p", *_RUNS):
            self.inside.append(tag)
        if tag in ("w:tbl", "w:tc"):
            self.cell = self.cell if tag == "w:tc" else _Run()
        elif tag == "w:p":
            self.paragraph = self.cell
        elif tag in _RUNS:
            self.run = self.paragraph

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._property(tag, {name: value or "" for name, value in attrs})

    def _property(self, tag: str, attributes: Attributes) -> None:
        text = self.get_starttag_text() or ""
        self.written.append(f"<{tag}>" if re.search("[<>]", text[1:-1]) else text)
        inside = self.inside[-1] if self.inside else ""
        if tag in ("w:pstyle", "w:rstyle"):
            styled = self.styles.get(attributes.get("w:val", ""), _Run())
            if tag == "w:pstyle":
                self.paragraph = replace(styled, shaded=styled.shaded or self.cell.shaded)
            else:
                self.run = replace(styled, shaded=styled.shaded or self.paragraph.shaded)
        elif inside in _RUNS:
            self.run = _with_property(self.run, tag, attributes)
        elif inside == "w:p" and tag == "w:shd":
            self.paragraph = _with_property(self.paragraph, tag, attributes)
        elif inside in ("w:tc", "w:tbl") and tag in ("w:shd", "w:tblstyle"):
            self.cell = _with_property(self.cell, tag, attributes)

    def handle_endtag(self, tag: str) -> None:
        self.written.append(f"</{tag}>")
        self.unseen -= tag in _UNSEEN and self.unseen > 0
        if tag in self.inside[-1:]:
            self.inside.pop()
        if tag == "w:tbl":
            self.cell = _Run()

    def handle_data(self, data: str) -> None:
        if not self.unseen and (self.inside[-1:] not in _IN_RUNS or self.run.seen):
            self.written.append(data)

    def handle_entityref(self, name: str) -> None:
        self.handle_data(f"&{name};")

    def handle_charref(self, name: str) -> None:
        self.handle_data(f"&#{name};")

    def unknown_decl(self, data: str) -> None:
        if data.startswith("CDATA["):
            self.handle_data(data[6:])


def word_seen(document: str, styles: str = "") -> str:
    """Return the text of Word without its hidden text; `styles` are those of the file."""
    named: dict[str, _Run] = {}
    name = ""
    for tag, attributes in _parsed(_Elements("w:"), styles).found:
        if tag == "w:style":
            name = attributes.get("w:styleid", "")
            named[name] = _Run()
        elif name and tag == "w:basedon":
            named[name] = named.get(attributes.get("w:val", ""), _Run())
        elif name:
            named[name] = _with_property(named[name], tag, attributes)
    return "".join(_parsed(_Word(named), document).written)


# --- workbooks ---------------------------------------------------------------------------------------------------


def hidden_sheets(data: bytes) -> frozenset[str]:
    """Return the names of the sheets of a workbook that are hidden."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = archive.namelist()
        member = "xl/workbook.xml" if "xl/workbook.xml" in names else "content.xml"
        with archive.open(member) as file:
            text = file.read(_MOST_XML).decode("utf-8", "replace")
    hidden: set[str] = set()
    unseen_styles: set[str] = set()
    style = ""
    for tag, attributes in _parsed(_Elements("sheet", "style:", "table:table"), text).found:
        if tag == "sheet" and attributes.get("state", "visible").lower() != "visible":
            hidden.add(attributes.get("name", ""))
        elif tag == "style:style":
            style = attributes.get("style:name", "")
        elif tag == "style:table-properties" and attributes.get("table:display") == "false":
            unseen_styles.add(style)
        elif tag == "table:table" and attributes.get("table:style-name") in unseen_styles:
            hidden.add(attributes.get("table:name", ""))
    return frozenset(hidden)


_MOST_XML = 10_000_000  # bytes


# --- LaTeX, Markdown and plain lines ----------------------------------------------------------------------------

_NOT_TYPESET = frozenset(
    ["phantom", "hphantom", "vphantom", "invisible", "hypersetup", "pdfinfo", "label", "index", "typeout", "message"]
)
_COMMAND = re.compile(r"\\([a-zA-Z]+)\*?|\\.|[{}]")
_IN_WHITE = re.compile(r"\s*(?:\[(?P<model>\w*)\])?\s*\{\s*(?P<color>[^{}]*)\}")


def latex_seen(text: str) -> str:
    """Return a text without the arguments of LaTeX's commands that print nothing, or in white."""
    if "\\" not in text:
        return text
    kept, start, at = list[str](), 0, 0
    while match := _COMMAND.search(text, at):
        at = match.end()
        name = match[1] or ""
        if name in _NOT_TYPESET:
            end = _end_of_group(text, at)
        elif name in ("textcolor", "color") and (white := _IN_WHITE.match(text, at)) and _is_white(white):
            end = _end_of_group(text, white.end()) if name == "textcolor" else _end_around(text, white.end())
        else:
            continue
        kept.append(text[start : match.start()])
        # Lines are counted as they are written.
        kept.append("\n" * text.count("\n", match.start(), end))
        start = at = end
    return "".join([*kept, text[start:]])


def _is_white(written: re.Match[str]) -> bool:
    model, color = (written["model"] or "").lower(), written["color"].strip()
    if model in ("rgb", "gray"):
        numbers = [float(one) for one in re.findall(r"\d+(?:\.\d*)?|\.\d+", color)]
        most = 255.0 if written["model"] == "RGB" else 1.0
        return bool(numbers) and min(numbers) >= 0.97 * most
    read = color_of(f"#{color}" if model == "html" else color)
    return read is not None and contrast(read, WHITE) < FAINTEST


def _end_of_group(text: str, at: int) -> int:
    """Return where the group in braces ends that begins at a place, or the place itself."""
    begin = re.compile(r"\s*(?:\[[^\[\]]*\]\s*)?\{").match(text, at)
    return _end_around(text, begin.end()) if begin else at


def _end_around(text: str, at: int) -> int:
    """Return where the group in braces ends that a place is in; the end of the text if it does not end."""
    depth = 1
    for match in _COMMAND.finditer(text, at):
        depth += {"{": 1, "}": -1}.get(match[0], 0)
        if depth == 0:
            return match.end()
    return len(text)


_LINK = re.compile(
    r"(?m)^ {0,3}\[(?!\^)[^\[\]\n]+\]:[ \t]*(?:<[^<>\n]*>|[^\s<]\S*)"
    r"(?:[ \t]*\n?[ \t]*(?:\"[^\"\n]*\"|'[^'\n]*'|\([^()\n]*\)|\(.*\)))?[ \t]*$"
)
"""A definition of a link in Markdown, which is not shown: ``[//]: # (a remark)``."""


def markdown_seen(text: str) -> str:
    """Return Markdown without definitions of links, and without what its elements of HTML hide."""
    return page_seen(_LINK.sub(lambda found: "\n" * found[0].count("\n"), text))


_WIDE = re.compile(r"[ \t\u00a0\u2000-\u200a\u3000]{200}")
"""More blanks than a screen is wide."""


def line_seen(line: str) -> str:
    """Return the part of a line that is not far outside of the screen."""
    return _WIDE.split(line, maxsplit=1)[0]
