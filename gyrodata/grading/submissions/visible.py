"""Leave out of a text what nobody sees who opens it: it is no answer.

Whether other text may be unseen, such as white or tiny letters, is only known of a
whole file: an answer in it is graded, and a person is asked to look.
"""

from __future__ import annotations

import html
import re
from collections.abc import Mapping
from html.parser import HTMLParser

_NO_TEXT = frozenset(
    ("script", "style", "template", "title", "noscript", "dialog", "metadata")
)
"""Elements whose text nobody sees."""
_NO_END = "area base br col embed hr img input link meta param source track wbr"
_WITHOUT_END = frozenset(_NO_END.split())
_BLOCKS = "p div ul ol table h1 h2 h3 h4 h5 h6 section article pre hr blockquote"
_PARAGRAPHS = frozenset(_BLOCKS.split())
"""Elements that end a paragraph."""
_HIDES = re.compile(
    r"display:none|visibility:(?:hidden|collapse)|opacity:0(?!\.?\d*[1-9])"
    r"|font-size:[0-2](?:\.\d*)?(?:px|pt|[;}]|$)"
    r"|(?:text-indent|left|top|margin-left):-\d{4}"
)
"""A declaration that hides an element; the style has no blanks."""
_MAY_HIDE = re.compile(
    r"[;{](?:clip|clip-path|mask|transform|filter|zoom|content-visibility|text-indent)"
    r":(?!none|0[;}]|0$|auto)"
    r"|[;{](?:max-)?(?:height|width):0(?![.\d]*[1-9])|[;{]opacity:0?\.[0-4]"
    r"|[;{]letter-spacing:-|[;{]content:[\"'][^\"']{5}"
    r"|[;{]font-size:(?:[0-5](?:\.\d*)?(?:px|pt)|0?\.[0-4]\d*r?em|[1-4]?\d%)"
    r"|[;{]color:rgba\([^;)]*,0\)"
)
"""A declaration that may hide an element, in a style without blanks."""
_NEARLY_WHITE = r"[;{]color:(?:white|snow|ivory|transparent|rgb\((?:25[3-5][,)]){3}"
_WHITE = re.compile(rf"{_NEARLY_WHITE}|#?(?:f[c-f]){{3}}|#?fff)")
_LIGHT = re.compile(
    _NEARLY_WHITE + r"|#?(?:[ef][0-9a-f]){3}(?![0-9a-f])|#?[ef]{3}(?![0-9a-f]))"
    r"|<w:colorw:val=\"(?:[ef].){3}\"|color\{white\}"
)
"""A color of text that is hard to see on white."""
_BACKGROUND = re.compile(
    r"(?i)(?:background(?:-color)?\s*:|bgcolor=|<w:shd\b[^<>]*w:fill=|<w:highlight\b"
    r"|\\(?:colorbox|pagecolor))"
    r"(?![\s\"']*(?:none|transparent|inherit|auto|white|#?fff))"
)
_NOT_PRINTED = r"\\(?:[hv]?phantom|invisible|hypersetup|pdfinfo|typeout)"
"""Commands of LaTeX that print nothing of their arguments."""
_IN_PRINT = re.compile(r"@media\s+print\s*\{(?:[^{}]|\{[^{}]*\})*\}")
_TINY = re.compile(
    r"<w:(?:sz|w)w:val=\"(?:\d|10)\"|fontsize\{[0-4](?:\.\d*)?\D|scalebox\{0"
    rf"|setbox|sbox|savebox|begin\{{lrbox|{_NOT_PRINTED}\{{"
)
"""Letters of Word or LaTeX that nobody reads, and what may not be printed."""


def may_be_unseen(text: str, styles: str = "") -> bool:
    """Return whether a part of a text may be unseen by its styles.

    `styles`: The style sheets and the styles of elements of a page.
    """
    on_screen = _IN_PRINT.sub("", styles.lower())
    styles = "".join(on_screen.split()).replace("!important", "")
    if _HIDES.search(styles) or _MAY_HIDE.search(styles):
        return True
    letters = "".join(text.lower().split())
    if _TINY.search(letters):
        return True
    is_light = _LIGHT.search(styles) or _LIGHT.search(letters)
    return is_light is not None and not has_background(text)


def has_background(text: str) -> bool:
    """Return whether a text has a background, on which white letters may be seen."""
    return _BACKGROUND.search(text) is not None


def _is_program(tag: str, attributes: Mapping[str, str | None]) -> bool:
    """Return whether an element may change a page, or open another one."""
    handlers = [name for name in attributes if name.startswith("on")]
    equivalent = attributes.get("http-equiv") or ""
    is_next_page = equivalent.lower() == "refresh"
    return tag == "script" or is_next_page or bool(handlers)


class _Visible(HTMLParser):
    """Write a page again without the text that nobody sees."""

    def __init__(self, shows_white: bool) -> None:
        super().__init__()
        self.shows_white = shows_white
        self.written: list[str] = []
        self.styles: list[str] = []  # of what is not hidden
        self.may_change = False  # whether a program may replace the text
        self.open = [("", False)]
        """The open elements, and whether each is hidden."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        outer, _ = self.open[-1]
        if outer == "p" and tag in _PARAGRAPHS:
            self.open.pop()
        self.written.append(f"<{tag}>")
        attributes = dict(attrs)
        self.may_change |= _is_program(tag, attributes)
        if tag in _WITHOUT_END:
            return
        style = f";{attributes.get('style')};color:{attributes.get('color')}"
        plain = "".join(style.lower().split())
        _, is_hidden = self.open[-1]
        is_hidden |= tag in _NO_TEXT or "hidden" in attributes
        is_hidden |= _HIDES.search(plain) is not None
        is_white = _WHITE.search(plain) is not None
        is_hidden |= is_white and not self.shows_white
        self.open.append((tag, is_hidden))
        if not is_hidden:
            self.styles.append(style)

    def handle_endtag(self, tag: str) -> None:
        self.written.append(f"</{tag}>")
        if any(name == tag for name, _ in self.open):
            while self.open.pop()[0] != tag:
                pass

    def handle_data(self, data: str) -> None:
        tag, is_hidden = self.open[-1]
        if tag == "style":
            self.styles.append(data)
        elif not is_hidden:
            self.written.append(html.escape(data, quote=False))


def of_page(text: str) -> tuple[str, bool]:
    """Return a page, or Markdown with elements of HTML, without its unseen text.

    Also return whether other text of it may be unseen.
    """
    if "<" not in text:
        return text, False
    page = _Visible(has_background(text))
    # The parser looks for the end of each "<", and stops at an unknown declaration.
    page.feed(re.sub(r"<(?!/?[a-zA-Z][^<>]*>)", "&lt;", text))
    page.close()
    styles = "\n".join(page.styles)
    doubt = page.may_change or may_be_unseen(text, styles)
    return "".join(page.written), doubt


_NOT_TYPESET = re.compile(rf"{_NOT_PRINTED}\s*\{{[^{{}}]*\}}")
_IN_WHITE = re.compile(
    r"\\textcolor\s*\{white\}\s*\{[^{}]*\}"
    r"|(?s:<w:r(?:\s[^<>]*)?>\s*<w:rPr>(?:(?!</w:r>).)*?"
    r"<w:(?:color w:val=\"(?:[Ff][C-Fc-f]){3}|(?:sz|w) w:val=\"[0-4])\".*?</w:r>)"
)
"""White text of LaTeX and Word, and letters of Word that nobody can read."""


def of_text(text: str) -> str:
    """Return a text without what LaTeX and Word do not show; lines keep their numbers."""
    patterns = [_NOT_TYPESET]
    if not has_background(text):
        patterns.append(_IN_WHITE)
    for pattern in patterns:
        text = pattern.sub(lambda match: "\n" * match[0].count("\n"), text)
    return text


_LINK = re.compile(
    r"(?m)^ {0,3}\[(?!\^)[^\[\]\n]+\]:[ \t]*(?:<[^<>\n]*>|[^\s<]\S*)[ \t]*"
    r"(?:[\"'(].*[\"')])?[ \t]*$"
)
"""A definition of a link in Markdown, which is not shown: ``[//]: # (a remark)``."""
_FRONT = re.compile(r"(?s)\A---[ \t]*\n.*?\n(?:---|\.\.\.)[ \t]*(?=\n|\Z)")
"""Lines about a page of Markdown, above it, which may not be shown."""
HAS_UNIT = re.compile(
    r"(?<![A-Za-z])(?i:k?g[\s·*.⋅-]{0,3}[ckm]?m(?:\b|\W{0,3}[2²])"
    r"|n[\s·*.⋅]{0,3}m[\s·*.⋅]{0,3}s)"
)
"""A unit of I_zz in a text that is not read."""


def of_markdown(text: str) -> str:
    """Return Markdown without definitions of links."""
    return _LINK.sub("", text)


def has_answer_above(text: str) -> bool:
    """Return whether lines above a page of Markdown may contain an answer."""
    front = _FRONT.match(text)
    if front is None:
        return False
    return HAS_UNIT.search(front[0]) is not None


WIDE = re.compile(r"[ \t\u00a0\u2000-\u200a\u3000]{200}")
"""More blanks than a screen is wide: nobody sees what is behind them."""


def of_line(line: str) -> str:
    """Return the part of a line that is not far outside of the screen."""
    return WIDE.split(line, maxsplit=1)[0]
