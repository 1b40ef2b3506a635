"""Leave out of a text what a person who opens it does not see: it is no answer.

What is hidden for certain is left out. What may be hidden, such as a page whose style
sheet hides something, stays with a mark (`DOUBT`): an answer there is graded, and a
person is asked.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from html.parser import HTMLParser

from msgspec import Struct

Attributes = Mapping[str, str]
"""Of one element, by their names in small letters."""

DOUBT = "\U0010fffd"
"""Mark of a line that may be unseen; no text contains this character."""


def doubted(text: str) -> str:
    """Return a text with the mark of doubt on each of its lines."""
    return DOUBT + text.replace("\n", f"\n{DOUBT}")


# --- pages ---

_NO_TEXT = "script style template title noscript dialog metadata"
_UNSEEN = frozenset(_NO_TEXT.split())
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


class _Element(Struct, frozen=True):
    """An open element."""

    tag: str
    hidden: bool = False
    white: bool = False
    doubt: bool = False  # whether it may be hidden


class _Seen(HTMLParser):
    """Write a page again without the text that nobody sees."""

    def __init__(self, white_is_seen: bool, doubt: bool) -> None:
        super().__init__(convert_charrefs=False)
        self.white_is_seen = white_is_seen
        self.written: list[str] = []
        self.open = [_Element("", doubt=doubt)]
        self.count: Counter[str] = Counter()
        """Number of open elements by their names."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in _PARAGRAPHS and self.open[-1].tag == "p":
            self._close("p")
        self.handle_startendtag(tag, attrs)
        if tag not in _WITHOUT_END:
            attributes = {name: value or "" for name, value in attrs}
            self.open.append(self._element(tag, attributes))
            self.count[tag] += 1

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        text = self.get_starttag_text() or ""
        # A ">" in an attribute is not the end of its tag.
        self.written.append(f"<{tag}>" if re.search("[<>]", text[1:-1]) else text)

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
        style = ";" + re.sub(r"\s", "", attributes.get("style", "").lower())
        hidden = around.hidden or tag in _UNSEEN or "hidden" in attributes
        hidden |= _HIDES.search(style) is not None
        declared = re.search(";color:([^;]*)", style)
        color = declared[1] if declared else attributes.get("color", "").lower()
        white = _WHITE.match(color) is not None if color else around.white
        doubt = around.doubt or _MAY_HIDE.search(style) is not None
        doubt |= not self.white_is_seen and _LIGHT.search(style) is not None
        return _Element(tag, hidden, white, doubt)


def _without_traps(text: str) -> str:
    """Return a page without what makes its parser slow, or stops it."""
    # A comment without an end goes on to the end of the page.
    comment = text.find("<!--", text.rfind("-->") + 1)
    if comment >= 0 and "</script" not in text[comment:].lower():
        text = text[:comment]
    # The parser looks for the end of each "<" again and again, and stops at a
    # declaration that it does not know.
    text = _NO_TAG.sub("&lt;", _DATA.sub('""', text))
    return re.sub(r"<!\[(?!CDATA\[)", "&lt;![", text)


_DATA = re.compile(r"""(["'])data:[^"'<>]*\1""")
"""A picture in an attribute, as text."""
_NO_TAG = re.compile(
    r"""<(?![!?]|/?[a-zA-Z](?:[^<>"']|"[^"]{0,5000}"|'[^']{0,5000}')*+>)"""
)
"""A "<" that does not begin a tag."""


def page_seen(text: str) -> str:
    """Return a page, or Markdown with elements of HTML, without its unseen text."""
    if "<" not in text:
        return text
    sheet = "\n".join(re.findall(r"(?is)<style\b[^<>]*>(.*?)</style", text)).lower()
    is_dark = _BACKGROUND.search(text) is not None
    # A style sheet can write texts of its own.
    written = re.findall(r"content:\s*[\"']([^\"'\n]{5,200})", sheet)
    page = _Seen(is_dark, bool(written) or _hides_something(sheet, is_dark))
    page.feed(_without_traps(text))
    page.close()
    return "".join([*page.written, *(f"\n<p>{doubted(one)}</p>" for one in written)])


def _hides_something(sheet: str, is_dark: bool) -> bool:
    """Return whether a style sheet hides something, but for printers."""
    around: list[str] = []
    text = ""
    for piece in re.split(r"([{}])", sheet):
        if piece == "{":
            around.append(text)
        elif piece == "}" and around:
            if _hides(text, is_dark) and not any("print" in one for one in around):
                return True
            around.pop()
        text = piece
    return False


def _hides(declarations: str, is_dark: bool) -> bool:
    """Return whether declarations of a style sheet may hide an element."""
    style = ";" + re.sub(r"\s|!important", "", declarations)
    color = re.search(";color:([^;]*)", style)
    if color and not is_dark and (_WHITE.match(color[1]) or _LIGHT.match(color[0])):
        return True
    return (_HIDES.search(style) or _MAY_HIDE.search(style)) is not None


# --- Word ---

_DELETED = re.compile(
    r"(?s)<w:(del|moveFrom|instrText)(?:\s[^<>]*)?(?<!/)>.*?</w:\1\s*>"
)
_PIECE = re.compile(
    r"(?s)(?P<properties>(?><w:rPr\b.{0,5000}?</w:rPr>))(?!\s*</w:pPr>)"
    r"(?P<text>.*?)(?=<w:rPr\b|</w:r>|</w:p>|\Z)"
)
"""Properties, but for those of the end of a paragraph, and the text that has them."""
_TINIEST, _SMALL = 4, 10
"""Height of letters that nobody reads, and that are hard to see [half points]."""


def word_seen(text: str, styles: str) -> str:
    """Return the XML of Word without hidden text; a hiding style doubts all of it."""
    is_dark = _BACKGROUND.search(text) is not None
    text = _PIECE.sub(lambda piece: _piece_seen(piece, is_dark), text)
    text = _DELETED.sub("", text)
    used = set(re.findall(r'<w:[pr]Style\s+w:val="([^"]*)"', text))
    for style in re.split(r"(?=<w:style\b)", styles):
        name = re.search(r'w:styleId="([^"]*)"', style)
        if name and name[1] in used and any(_visibility(style, is_dark)):
            return re.sub(r">(?=[^<>])", f">{DOUBT}", text)
    return text


def _piece_seen(piece: re.Match[str], is_dark: bool) -> str:
    """Return a text of Word, without its letters if its properties hide them."""
    hidden, doubt = _visibility(piece["properties"], is_dark)
    letters = re.sub(r">[^<>]+<", "><", piece["text"]) if hidden else piece["text"]
    return piece["properties"] + (doubted(letters) if doubt else letters)


def _visibility(properties: str, is_dark: bool) -> tuple[bool, bool]:
    """Return whether properties of Word hide a text, and whether they may hide it."""
    found = re.findall(r'<w:(\w+)(?:\s+w:val="([^"]*)")?', properties.lower())
    values = dict(found)
    size = min(int(values.get(key) or 99) for key in ("sz", "w"))
    color = values.get("color", "") if not is_dark else ""
    hidden = values.get("vanish", "0") not in ("0", "false", "off")
    hidden |= "vanish" in values and not values["vanish"]
    hidden |= size <= _TINIEST or _WHITE.fullmatch(color) is not None
    doubt = size <= _SMALL or re.fullmatch("(?:[ef].){3}", color) is not None
    return hidden, doubt


# --- LaTeX, Markdown and plain lines ---

_NOT_TYPESET = r"[hv]?phantom|invisible|hypersetup|pdfinfo|typeout"
"""Commands of LaTeX that print nothing of their arguments."""
_IN_WHITE = r"textcolor\s*\{white\}"
_MAY_BE_UNSEEN = (
    r"color\s*\{white\}|fontsize\s*\{[0-4](?:\.\d*)?\D|scalebox\s*\{0"
    r"|setbox|sbox|savebox|begin\s*\{lrbox"
)
"""Commands of LaTeX behind which a text may be unseen."""


def latex_seen(text: str) -> str:
    """Return a text without what LaTeX does not print, or prints in white.

    Text behind such a command whose argument has braces in it may be unseen.
    """
    names = _NOT_TYPESET if _BACKGROUND.search(text) else f"{_NOT_TYPESET}|{_IN_WHITE}"
    # Lines are counted as they are written.
    seen = re.sub(
        rf"\\(?:{names})\s*\{{[^{{}}]*\}}",
        lambda found: "\n" * found[0].count("\n"),
        text,
    )
    hides = re.search(rf"\\(?:{_MAY_BE_UNSEEN}|(?:{names})\s*\{{)", seen)
    return seen[: hides.start()] + doubted(seen[hides.start() :]) if hides else seen


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
    """Return Markdown without definitions of links, and without hidden elements."""
    text = _FRONT.sub(lambda found: doubted(found[0]), text)
    return page_seen(_LINK.sub("", text))


_WIDE = re.compile(r"[ \t\u00a0\u2000-\u200a\u3000]{200}")
"""More blanks than a screen is wide."""


def line_seen(line: str) -> str:
    """Return the part of a line that is not far outside of the screen."""
    return _WIDE.split(line, maxsplit=1)[0]
