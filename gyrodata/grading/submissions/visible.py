"""Leave out of a text what a person who opens it does not see: it is no answer.

What is hidden for certain is left out. What may be hidden, such as by a rule of a style
sheet, stays with a mark (`DOUBT`): an answer there is graded, and a person is asked.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from html.parser import HTMLParser
from itertools import filterfalse

from msgspec import Struct
from msgspec.structs import replace

Attributes = Mapping[str, str]
"""Of one element, by their names in small letters."""

DOUBT = "\U0010fffd"
"""Mark of a line that may be unseen; no text contains this character."""


def doubted(text: str) -> str:
    """Return a text with the mark of doubt on each of its lines."""
    return DOUBT + text.replace("\n", f"\n{DOUBT}")


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
_MAY_HIDE = re.compile(
    r";(?:clip|clip-path|mask|transform|filter|zoom|content-visibility|text-indent)"
    r":(?!none|0;|0$|auto)"
    r"|;(?:max-)?(?:height|width):0(?![.\d]*[1-9])|;opacity:0?\.[0-4]|;letter-spacing:-"
    r"|;font-size:(?:[0-5](?:\.\d*)?(?:px|pt)|0?\.[0-4]\d*r?em|[1-4]?\d%)"
    r"|;color:rgba\([^;)]*,0\)"
)
"""A declaration that may hide an element, in a style without blanks."""
_WHITE = re.compile(
    r"(?:white|snow|ivory|transparent|#?(?:f[c-f]){3}|#?fff|rgb\((?:25[3-5][,)]){3})"
)
_LIGHT = re.compile(r";color:#(?:(?:[ef][0-9a-f]){3}|[ef]{3})(?![0-9a-f])")
"""A color of text that is hard to see on white."""
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
    doubt: bool = False  # whether it may be hidden
    names: frozenset[str] = frozenset()  # by which a rule of a style sheet may mean it


class _Seen(HTMLParser):
    """Write a page, or the XML of a word processor, again without the text that nobody sees."""

    def __init__(
        self, styles: Mapping[str, str], rules: Iterable[_Rule], white_is_seen: bool
    ) -> None:
        super().__init__(convert_charrefs=False)
        self.styles = styles
        self.rules: dict[str, list[_Rule]] = {}
        """Rules that may hide an element, by each of the names that it must have."""
        for rule in _few(rules):
            for name in rule[-1]:
                self.rules.setdefault(name, []).append(rule)
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
            self.written.append(doubted(data) if around.doubt else data)

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
        classes = attributes.get("class", "").lower().split()
        names = {tag, "*", *(f".{name}" for name in classes)}
        names |= {f"#{attributes['id'].lower()}"} if "id" in attributes else set()
        doubt = around.doubt or self._may_hide(names)
        doubt |= _MAY_HIDE.search(style) is not None
        doubt |= not self.white_is_seen and _LIGHT.search(style) is not None
        return _Element(tag, hidden, white, doubt, frozenset(names))

    def _may_hide(self, names: set[str]) -> bool:
        """Return whether a rule of a sheet may hide an element with these names."""
        rules = (rule for name in names for rule in self.rules.get(name, ()))
        return any(rule[-1] <= names and self._are_open(rule[:-1]) for rule in rules)

    def _are_open(self, parts: _Rule) -> bool:
        """Return whether each part of a rule may mean an open element."""
        return all(any(part <= one.names for one in self.open) for part in parts)

    def _add_property(self, tag: str, attributes: Attributes) -> None:
        """Apply a property of Word, which is an element in the piece of text that it describes."""
        value = attributes.get("w:val", "").lower()
        inner = [one.tag for one in reversed(self.open[-3:])]
        depth = next((at for at, one in enumerate(inner, 1) if one in _PIECES), 0)
        if depth == 0:
            return
        described = self.open[-depth]
        white = described.white
        if tag == "w:color":
            white = _WHITE.fullmatch(value) is not None
        is_style = tag in ("w:pstyle", "w:rstyle") and bool(self.styles.get(value))
        is_seen = tag == "w:color" and self.white_is_seen
        doubt = is_style or (_is_faint(tag, value) and not is_seen)
        self.open[-depth:] = [
            replace(
                one,
                hidden=described.hidden or _is_hiding(tag, value),
                white=white,
                doubt=described.doubt or doubt,
            )
            for one in self.open[-depth:]
        ]


_PIECES = ("w:r", "w:p")
"""Elements that a property of Word describes."""


def _is_hiding(tag: str, value: str) -> bool:
    """Return whether a property of Word hides a text."""
    if tag == "w:vanish":
        return value not in ("0", "false", "off")
    return tag == "w:sz" and value.isdigit() and int(value) <= _TINIEST


_SMALL = 10
"""Height of letters in Word that are hard to see [half points]."""


def _is_faint(tag: str, value: str) -> bool:
    """Return whether a property of Word makes a text hard to see."""
    if tag == "w:color":
        return re.fullmatch("(?:[ef].){3}", value) is not None
    return tag in ("w:sz", "w:w") and value.isdigit() and int(value) <= _SMALL


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
    sheet = _style_sheet(text)
    is_dark = _BACKGROUND.search(text) is not None
    page = _Seen(styles or {}, _hiding_rules(sheet, is_dark), white_is_seen=is_dark)
    _parsed(page, text)
    # A style sheet can write texts of its own.
    shown = re.findall(r"content:\s*[\"']([^\"'\n]{5,200})", sheet)
    return "".join([*page.written, *(f"\n<p>{doubted(one)}</p>" for one in shown)])


_Rule = tuple[frozenset[str], ...]
"""Whom a rule means: the names of an element, behind those of the ones around it."""


_MOST_RULES = 1000


def _few(rules: Iterable[_Rule]) -> Iterable[_Rule]:
    """Return each rule once; of too many, one that means all elements."""
    each = dict.fromkeys(rules)
    return each if len(each) <= _MOST_RULES else [(frozenset("*"),)]


def _style_sheet(text: str) -> str:
    """Return the style sheets in a page."""
    if "<style" not in text.lower():
        return ""
    parser = _Elements()
    _parsed(parser, text)
    return "\n".join(parser.styles)


def _hiding_rules(sheet: str, is_dark: bool) -> Iterator[_Rule]:
    """Yield whom the rules of a style sheet may hide, but those for printers."""
    around: list[str] = []
    text = ""
    for piece in re.split(r"([{}])", sheet.lower()):
        if piece == "{":
            around.append(text)
        elif piece == "}" and around:
            selectors = around.pop()
            if _hides(text, is_dark) and not any("print" in one for one in around):
                yield from map(
                    _rule, filterfalse(_IN_A_STATE.search, selectors.split(","))
                )
        text = piece


def _hides(declarations: str, is_dark: bool) -> bool:
    """Return whether declarations of a style sheet may hide an element."""
    style = ";" + re.sub(r"\s|!important", "", declarations)
    color = re.search(";color:([^;]*)", style)
    if color and not is_dark and (_WHITE.match(color[1]) or _LIGHT.match(color[0])):
        return True
    return (_HIDES.search(style) or _MAY_HIDE.search(style)) is not None


_IN_A_STATE = re.compile(
    r"^(?!.*:not).*(?:::|:(?:before|after|hover|focus|active|visited|disabled)\b)",
    re.DOTALL,
)
"""A selector of what is beside an element, or of an element while it is used."""


def _rule(selector: str) -> _Rule:
    """Read a selector without its conditions on attributes and on places."""
    plain = re.sub(r"\[[^\[\]]*\]|:[\w:-]+(?:\([^()]*\))?", "*", selector)
    parts = re.sub(r"[>+~]", " ", plain).split()
    names = (re.findall(r"[.#]?[\w-]+", part) or ["*"] for part in parts)
    return tuple(map(frozenset, names)) or (frozenset("*"),)


class _Elements(HTMLParser):
    """The start tags of an XML file, and the style sheets of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.elements: list[tuple[str, Attributes]] = []
        self.styles: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, _attributes(attrs)))

    def handle_data(self, data: str) -> None:
        if self.elements and self.elements[-1][0] == "style":
            self.styles.append(data)


def _elements(text: str) -> list[tuple[str, Attributes]]:
    parser = _Elements()
    _parsed(parser, text)
    return parser.elements


_OF_TEXT = {"text:display": "display", "fo:color": "color", "fo:font-size": "font-size"}
"""Properties of OpenDocument, by the names of the same properties in CSS."""


def hiding_styles(styles: str) -> dict[str, str]:
    """Return the styles of Word that may hide a text, each with the property that does."""
    found: dict[str, str] = {}
    name = ""
    for tag, attributes in _elements(styles):
        value = attributes.get("w:val", "").lower()
        if tag == "w:style":
            name = attributes.get("w:styleid", "").lower()
        elif name and (
            (tag == "w:vanish" and value not in ("0", "false", "off"))
            or _is_faint(tag, value)
        ):
            found[name] = tag
    return found


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
    seen = "".join([*kept, text[at:]])
    hides = _TYPESET_UNSEEN.search(seen)
    return seen[: hides.start()] + doubted(seen[hides.start() :]) if hides else seen


_TYPESET_UNSEEN = re.compile(
    r"\\(?:color\s*\{white\}|fontsize\s*\{[0-4](?:\.\d*)?\D|scalebox\s*\{0"
    r"|setbox|sbox|savebox|begin\s*\{lrbox)"
)
"""Commands of LaTeX behind which a text may be unseen."""


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
    r"(?m)^ {0,3}\[(?!\^)[^\[\]\n]+\]:[ \t]*(?:<[^<>\n]*>|[^\s<]\S*)[ \t]*"
    r"(?:[\"'(].*[\"')])?[ \t]*$"
)
"""A definition of a link in Markdown, which is not shown: ``[//]: # (a remark)``."""


_FRONT = re.compile(
    r"\A---[ \t]*\n.*?\n(?:---|\.\.\.)[ \t]*$", re.DOTALL | re.MULTILINE
)
"""Lines about a page of Markdown, above it, which are not shown."""


def markdown_seen(text: str) -> str:
    """Return Markdown without definitions of links, and without what its elements of HTML hide."""
    text = _FRONT.sub(lambda found: doubted(found[0]), text)
    return page_seen(_LINK.sub("", text))


_WIDE = re.compile(r"[ \t\u00a0\u2000-\u200a\u3000]{200}")
"""More blanks than a screen is wide."""


def line_seen(line: str) -> str:
    """Return the part of a line that is not far outside of the screen."""
    return _WIDE.split(line, maxsplit=1)[0]
