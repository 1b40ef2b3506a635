"""Leave out of a text what a person who opens it does not see: it is no answer.

Only the usual ways to hide a text are known. Beside a visible answer, an answer that is
hidden in another way is a second one: two answers that differ are a question to a
person.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser

from msgspec import Struct

Attributes = Mapping[str, str]
"""Of one element, by their names in small letters."""

# --- pages, OpenDocument and Word ---

_OF_PAGES = "script style template title noscript dialog metadata"
_OF_DOCUMENTS = (
    "text:tracked-changes text:hidden-text text:hidden-paragraph w:del w:movefrom "
    "w:instrtext"
)
_UNSEEN = frozenset(f"{_OF_PAGES} {_OF_DOCUMENTS}".split())
"""Elements whose text nobody sees."""
_NO_END = "area base br col embed hr img input link meta param source track wbr"
_WITHOUT_END = frozenset(_NO_END.split())
_BLOCKS = "p div ul ol table h1 h2 h3 h4 h5 h6 section article pre hr blockquote"
_PARAGRAPHS = frozenset(_BLOCKS.split())
"""Elements of HTML that end a paragraph."""
_HIDES = re.compile(
    r"display:none|visibility:(?:hidden|collapse)|opacity:0(?!\.?\d*[1-9])"
    r"|font-size:[0-2](?:\.\d*)?(?:px|pt|;|$)"
    r"|(?:text-indent|left|top|margin-left):-\d{4}"
)
"""A declaration that hides an element; the style has no blanks."""
_WHITE = re.compile(
    r"(?:white|snow|ivory|transparent|#?(?:f[c-f]){3}|#?fff|rgb\((?:25[3-5][,)]){3})"
)
_BACKGROUND = re.compile(
    r"(?i)(?:background(?:-color)?\s*:|bgcolor=|<w:shd\b[^<>]*w:fill=|<w:highlight\b"
    r"|\\(?:colorbox|pagecolor))"
    r"(?![\s\"']*(?:none|transparent|inherit|auto|white|#?fff))"
)
"""A background, on which white text may be seen."""
_TINIEST = 4
"""Height of letters in Word that nobody reads [half points]."""


class _Element(Struct, frozen=True):
    """An open element."""

    tag: str
    hidden: bool = False
    white: bool = False


class _Seen(HTMLParser):
    """Write a page, or the XML of a word processor, again without the text that nobody sees."""

    def __init__(self, styles: Mapping[str, str], white_is_seen: bool) -> None:
        super().__init__(convert_charrefs=False)
        self.styles = styles
        self.white_is_seen = white_is_seen
        self.written: list[str] = []
        self.open = [_Element("")]
        self.count: Counter[str] = Counter()
        """Number of open elements by their names."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in _PARAGRAPHS and self.open[-1].tag == "p":
            self._close("p")
        self._write_tag(tag)
        if tag not in _WITHOUT_END:
            self.open.append(self._element(tag, _attributes(attrs)))
            self.count[tag] += 1

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._write_tag(tag)
        if tag.startswith("w:"):
            self._add_property(tag, _attributes(attrs))

    def handle_endtag(self, tag: str) -> None:
        self.written.append(f"</{tag}>")
        self._close(tag)

    def handle_data(self, data: str) -> None:
        around = self.open[-1]
        if not around.hidden and (self.white_is_seen or not around.white):
            self.written.append(data)

    def handle_entityref(self, name: str) -> None:
        self.handle_data(f"&{name};")

    def handle_charref(self, name: str) -> None:
        self.handle_data(f"&#{name};")

    def unknown_decl(self, data: str) -> None:
        if data.startswith("CDATA["):
            self.handle_data(data[6:])

    def _write_tag(self, tag: str) -> None:
        text = self.get_starttag_text() or ""
        # A ">" in an attribute is not the end of its tag.
        self.written.append(f"<{tag}>" if re.search("[<>]", text[1:-1]) else text)

    def _close(self, tag: str) -> None:
        """Close the innermost element of this name, and all elements in it."""
        if not self.count[tag]:
            return
        closed = ""
        while closed != tag:
            closed = self.open.pop().tag
            self.count[closed] -= 1

    def _element(self, tag: str, attributes: Attributes) -> _Element:
        around = self.open[-1]
        style = (
            self.styles.get(attributes.get("text:style-name", ""), "")
            + ";"
            + attributes.get("style", "")
        )
        style = re.sub(r"\s", "", style.lower())
        hidden = (
            around.hidden
            or tag in _UNSEEN
            or "hidden" in attributes
            or _HIDES.search(style) is not None
        )
        declared = re.search(";color:([^;]*)", style)
        color = declared[1] if declared else attributes.get("color", "").lower()
        white = _WHITE.match(color) is not None if color else around.white
        return _Element(tag, hidden, white)

    def _add_property(self, tag: str, attributes: Attributes) -> None:
        """Apply a property of Word, which is an element in the piece of text that it describes."""
        value = attributes.get("w:val", "").lower()
        first = next(
            (
                at
                for at in (-1, -2, -3)
                if self.open[at:] and self.open[at].tag in ("w:r", "w:p")
            ),
            0,
        )
        if first == 0:
            return
        described = self.open[first]
        hidden = described.hidden or (
            tag == "w:vanish" and value not in ("0", "false", "off")
        )
        hidden |= tag == "w:sz" and value.isdigit() and int(value) <= _TINIEST
        white = (
            _WHITE.fullmatch(value) is not None if tag == "w:color" else described.white
        )
        self.open[first:] = [
            _Element(one.tag, hidden, white) for one in self.open[first:]
        ]


def _attributes(attrs: list[tuple[str, str | None]]) -> dict[str, str]:
    return {name: value or "" for name, value in attrs}


def _parsed(parser: HTMLParser, text: str) -> None:
    """Read a whole text with a parser."""
    # A comment without an end goes on to the end of the page.
    comment = text.find("<!--", text.rfind("-->") + 1)
    if comment >= 0 and "</script" not in text[comment:].lower():
        text = text[:comment]
    # The parser looks for the end of each "<" again and again, and stops at a
    # declaration that it does not know.
    text = _NO_TAG.sub("&lt;", _DATA.sub('""', text))
    parser.feed(re.sub(r"<!\[(?!CDATA\[)", "&lt;![", text))
    parser.close()


_DATA = re.compile(r"""(["'])data:[^"'<>]*\1""")
"""A picture in an attribute, as text."""
_NO_TAG = re.compile(
    r"""<(?![!?]|/?[a-zA-Z](?:[^<>"']|"[^"]{0,5000}"|'[^']{0,5000}')*+>)"""
)
"""A "<" that does not begin a tag."""


def page_seen(text: str, styles: Mapping[str, str] | None = None) -> str:
    """Return a page without its unseen text.

    The text may also be the XML of Word, or Markdown with elements of HTML.
    """
    if "<" not in text:
        return text
    page = _Seen(styles or {}, white_is_seen=_BACKGROUND.search(text) is not None)
    _parsed(page, text)
    return "".join(page.written)


class _Elements(HTMLParser):
    """The start tags of an XML file, with their attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.elements: list[tuple[str, Attributes]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, _attributes(attrs)))


def _elements(text: str) -> list[tuple[str, Attributes]]:
    parser = _Elements()
    _parsed(parser, text)
    return parser.elements


_OF_TEXT = {"text:display": "display", "fo:color": "color", "fo:font-size": "font-size"}
"""Properties of OpenDocument, by the names of the same properties in CSS."""


def open_text_seen(content: str) -> str:
    """Return the text of an OpenDocument without its hidden text."""
    styles: dict[str, str] = {}
    name = ""
    for tag, attributes in _elements(content):
        if tag == "style:style":
            name = attributes.get("style:name", "")
        elif tag == "style:text-properties" and name:
            properties = (
                f"{css}:{attributes[key]}"
                for key, css in _OF_TEXT.items()
                if key in attributes
            )
            styles[name] = ";".join(["", *properties])
    return page_seen(content, styles)


# --- workbooks ---

_MOST_XML = 10_000_000  # bytes


def hidden_sheets(data: bytes) -> frozenset[str]:
    """Return the names of the sheets of a workbook that are hidden."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        member = (
            "xl/workbook.xml"
            if "xl/workbook.xml" in archive.namelist()
            else "content.xml"
        )
        with archive.open(member) as file:
            text = file.read(_MOST_XML).decode("utf-8", "replace")
    return frozenset(_hidden_sheets(_elements(text)))


def _hidden_sheets(elements: list[tuple[str, Attributes]]) -> Iterator[str]:
    """Yield the names of the hidden sheets.

    A sheet is hidden by its state in Excel, and by its style in OpenDocument.
    """
    unseen: set[str] = set()
    style = ""
    for tag, attributes in elements:
        if tag == "sheet" and attributes.get("state", "visible").lower() != "visible":
            yield attributes.get("name", "")
        elif tag == "style:style":
            style = attributes.get("style:name", "")
        elif (
            tag == "style:table-properties"
            and attributes.get("table:display") == "false"
        ):
            unseen.add(style)
        elif tag == "table:table" and attributes.get("table:style-name") in unseen:
            yield attributes.get("table:name", "")


# --- LaTeX, Markdown and plain lines ---

_NOT_TYPESET = r"[hv]?phantom|invisible|hypersetup|pdfinfo|typeout"
"""Commands of LaTeX that print nothing of their arguments."""
_IN_WHITE = r"textcolor\s*\{white\}"


def latex_seen(text: str) -> str:
    """Return a text without the arguments of LaTeX's commands that print nothing, or in white."""
    names = _NOT_TYPESET if _BACKGROUND.search(text) else f"{_NOT_TYPESET}|{_IN_WHITE}"
    command = re.compile(rf"\\(?:{names})\s*\{{")
    kept: list[str] = []
    at = 0
    while match := command.search(text, at):
        end = _end_of_group(text, match.end())
        # Lines are counted as they are written.
        kept += text[at : match.start()], "\n" * text.count("\n", match.start(), end)
        at = end
    return "".join([*kept, text[at:]])


def _end_of_group(text: str, at: int) -> int:
    """Return where the group in braces ends that a place is in.

    The end of the text if it does not end.
    """
    depth = 1
    for match in re.compile(r"\\.|[{}]").finditer(text, at):
        depth += {"{": 1, "}": -1}.get(match[0], 0)
        if depth == 0:
            return match.end()
    return len(text)


_LINK = re.compile(
    r"(?m)^ {0,3}\[(?!\^)[^\[\]\n]+\]:[ \t]*(?:<[^<>\n]*>|[^\s<]\S*)[ "
    r"\t]*(?:[\"'(].*[\"')])?[ \t]*$"
)
"""A definition of a link in Markdown, which is not shown: ``[//]: # (a remark)``."""


def markdown_seen(text: str) -> str:
    """Return Markdown without definitions of links, and without what its elements of HTML hide."""
    return page_seen(_LINK.sub("", text))


_WIDE = re.compile(r"[ \t\u00a0\u2000-\u200a\u3000]{200}")
"""More blanks than a screen is wide."""


def line_seen(line: str) -> str:
    """Return the part of a line that is not far outside of the screen."""
    return _WIDE.split(line, maxsplit=1)[0]
