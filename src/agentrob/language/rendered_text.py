"""Compare a post's Markdown with the HTML that another forum renders from it (law 3; pure).

`visible_text` reads the Markdown of a post as our board shows it. Other forums have their own Markdown, plugins and
word filters, so for them the rendered HTML is compared with the text that was read. Where the page shows other words, a
mark is added that the grammar cannot parse, and the robot asks back.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser
from urllib.parse import unquote

from agentrob.language.visible_text import OMITTED, VOID_TAGS, normalized, visible_text
from agentrob.model import Post

#: Limits on HTML length, element count and nesting. HTML beyond them is not read, so that stops do not wait for it
#: (law 15), and counts as different.
MAX_HTML, MAX_ELEMENTS, MAX_DEPTH = 30_000, 1_000, 50
#: Elements whose text is shown as is, if they have no attributes other than these.
_FLOW = frozenset(["p", "ul", "ol", "li", "em", "strong", "b", "i", "bdi"])
_ATTRIBUTES = frozenset(["dir", "start"])
_BLOCKS = frozenset(["p", "ul", "ol", "li"])
#: Links that mention a group; their text is shown.
_GROUPS = frozenset(["mention-group", "plugin-mentions-group"])
_WORD = re.compile(r"\d+(?:[.,:/]\d+)*|[^\W\d_]+")


def text_in(post: Post) -> str:
    """Return the visible text of a post, with a mark at its end if its page shows other words."""
    text = visible_text(post.raw)
    return f"{text} {OMITTED}".lstrip() if post.rendering_differs else text


def rendering_differs(raw: str, html: str) -> bool:
    """Return whether the words of a post's Markdown differ from those its HTML shows in paragraphs and lists.

    Links are ignored. Returns True when in doubt; never raises.
    """
    if len(html) > MAX_HTML or html.count("<") > 2 * MAX_ELEMENTS:  # a begin and an end of each
        return True
    page = _Page()
    try:
        page.feed(html)
        if "<" in page.rawdata:  # a tag that is never closed
            return True
        page.close()
    except Exception:  # the parser fails on some malformed declarations, and we on too many elements
        return True
    return _words(normalized("".join(page.out))) != _words(visible_text(raw))


def is_mention(attributes: dict[str, str]) -> bool:
    """Return whether a link on a NodeBB or Discourse page mentions an account."""
    classes = set(attributes.get("class", "").split())
    return bool({"plugin-mentions-user", "mention"} & classes) and not _GROUPS & classes


def mention_of(attributes: dict[str, str]) -> str:
    """Return the account (lower case) that a mention link names; "" if the link has a number instead of a name."""
    page, _, name = attributes.get("href", "").rstrip("/").rpartition("/")
    return "" if page.endswith("/uid") else unquote(name).lower()


def _words(text: str) -> list[str]:
    return _WORD.findall(text.casefold())


class _Page(HTMLParser):
    """Collect the text of paragraphs and lists; a space stands for anything else."""

    def __init__(self) -> None:
        super().__init__()
        self.out: list[str] = []
        self._others: list[str] = []
        self._elements = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._elements += 1
        if self._elements > MAX_ELEMENTS or len(self._others) > MAX_DEPTH:
            raise ValueError("too many elements")
        has = {name: value or "" for name, value in attrs}
        if tag in VOID_TAGS:
            self.out.append(" ")
        elif self._others:
            self._others.append(tag)
        elif not _is_text(tag, has):
            self.out.append(f"@{mention_of(has)}" if tag == "a" and is_mention(has) else " ")
            self._others.append(tag)
        elif tag in _BLOCKS:
            self.out.append("\n")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag: str) -> None:
        if tag in self._others:
            last = len(self._others) - 1 - self._others[::-1].index(tag)
            del self._others[last:]
        elif tag in _BLOCKS:
            self.out.append("\n")

    def handle_data(self, data: str) -> None:
        if not self._others:
            self.out.append(data)


def _is_text(tag: str, has: dict[str, str]) -> bool:
    classes = has.get("class", "").split()
    if tag == "span" and classes == ["mention"]:  # a name that no account has
        return True
    if tag == "a" and (_GROUPS & set(classes) or (is_mention(has) and not mention_of(has))):
        return True
    return tag in _FLOW and has.keys() <= _ATTRIBUTES
