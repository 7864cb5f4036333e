"""Convert the Markdown of a post to safe HTML, without scripts, styles or pictures from other sites.

Two layers, each enough against scripts: the Markdown parser does not pass HTML through, and its output is sanitised by
nh3 (a real HTML parser) with a short list of allowed elements.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from html import escape
from typing import Any

import nh3
from markdown_it import MarkdownIt
from markdown_it.token import Token

from agentrob.language.visible_text import ADDRESS, shown_mentions, without_invisible

IsAccount = Callable[[str], bool]

#: The forum's own pictures; any other picture becomes a link, so that no other site learns who reads a post.
OWN_IMAGE = re.compile(r"/images/[A-Za-z0-9_-]+(\.(jpg|jpeg|png))?\Z")
_ADDRESS = re.compile(ADDRESS, re.IGNORECASE)
#: An allowed scheme, or no scheme at all (then one of / ? # comes before the first colon).
_SAFE_LINK = re.compile(r"(https?:|mailto:|[^:/?#]*([/?#]|\Z))", re.IGNORECASE)
#: Names in these elements are quoted or decoration, not addressed to anybody (law 3).
_NOT_SAID = ("blockquote", "heading", "table")
#: The note above a body that is shown as typed.
TOO_COMPLEX = "This post is shown as plain text: its markup takes too long to render."
#: The page has its own h1 and h2, so a heading in a post begins at h3.
_HEADING_SHIFT = 2

_CLEANER = nh3.Cleaner(
    tags={
        *("p", "br", "hr", "em", "strong", "s", "blockquote", "pre", "code", "ul", "ol", "li"),
        *("h3", "h4", "h5", "h6", "table", "thead", "tbody", "tr", "th", "td", "a", "img"),
    },
    clean_content_tags={"script", "style"},
    attributes={"a": {"href", "title"}, "img": {"src", "alt", "title"}, "ol": {"start"}},
    tag_attribute_values={"th": {"align": {"left", "center", "right"}}, "td": {"align": {"left", "center", "right"}}},
    allowed_classes={"a": {"mention"}},
    set_tag_attribute_values={"img": {"loading": "lazy"}},
    attribute_filter=lambda tag, name, value: (
        None if (tag, name) == ("img", "src") and not OWN_IMAGE.match(value) else value
    ),
    url_schemes={"http", "https", "mailto"},
    link_rel="nofollow noopener ugc",
)


def render(raw: str, is_account: IsAccount) -> str:
    """Safe HTML of a post's Markdown (CommonMark, tables, strikethrough, line breaks kept, bare addresses linked).

    `is_account` says whether a name (lower case) is an account; `@name` of such a one becomes a link to it where it is
    said in a paragraph or list, not where it is quoted, struck out, code, a heading or in a table. Never raises.
    """
    return Parsed(raw).html(is_account)


class Parsed:
    """A parsed post: the names that it may mention, and its HTML once it is known which of them are accounts."""

    def __init__(self, raw: str) -> None:
        self._env: dict[str, Any] = {}
        self._tokens = _MARKDOWN.parse(without_invisible(raw.encode("utf-8", "replace").decode()), self._env)
        for token in self._tokens:
            for child in token.children or ():
                if child.type == "text":
                    child.content = without_invisible(child.content)  # also characters that were written as entities

    def names(self) -> Iterator[str]:
        """The names (lower case) that `html` may ask about, possibly more and with repetitions."""
        for token in self._tokens:
            for child in token.children or ():
                for name, _, _ in shown_mentions(child.content) if child.type == "text" else ():
                    yield name

    def html(self, is_account: IsAccount) -> str:
        """Return safe HTML, as `render` does. Call it only once."""
        _polish(self._tokens, is_account)
        return _CLEANER.clean(_MARKDOWN.renderer.render(self._tokens, _MARKDOWN.options, self._env))


def as_plain_text(raw: str) -> str:
    """Safe HTML that shows a body as it was typed, for one whose Markdown takes too long to render."""
    lines = escape(raw.encode("utf-8", "replace").decode()).splitlines()
    return f"<p><em>{TOO_COMPLEX}</em></p>\n<p>{'<br>'.join(lines)}</p>\n"


def _polish(tokens: list[Token], is_account: IsAccount) -> None:
    """Finish parsing: demote headings, turn alignment into an attribute, replace pictures, link names."""
    not_said = 0
    for token in tokens:
        not_said += token.nesting * token.type.startswith(_NOT_SAID)
        if token.type in ("heading_open", "heading_close"):
            token.tag = f"h{min(6, int(token.tag[1]) + _HEADING_SHIFT)}"
        elif token.type in ("th_open", "td_open") and "style" in token.attrs:
            token.attrs["align"] = str(token.attrs.pop("style")).removeprefix("text-align:")
        elif token.type == "inline" and token.children:
            token.children = list(_inline(_MARKDOWN, token.children, _nobody if not_said else is_account))


def _inline(md: MarkdownIt, tokens: list[Token], is_account: IsAccount) -> Iterator[Token]:
    links = struck = 0  # the nesting depth of links and of struck-out text
    for token in tokens:
        links += (token.type == "link_open") - (token.type == "link_close")
        struck += (token.type == "s_open") - (token.type == "s_close")
        if token.type == "image":
            yield from _picture(token, inside_link=links > 0)
        elif token.type == "text" and not links:
            yield from _linked(md, token.content, _nobody if struck else is_account)
        else:
            yield token


def _picture(token: Token, inside_link: bool) -> Iterator[Token]:
    """Return the picture if it is the forum's own, otherwise a link to it."""
    src = str(token.attrs.get("src", ""))
    if OWN_IMAGE.match(src):
        yield token
        return
    label = "".join(child.content for child in token.children or ()).strip() or src
    if inside_link or not src:
        yield _text(label)
    else:
        yield from _link(src, label)


def _linked(md: MarkdownIt, text: str, is_account: IsAccount) -> Iterator[Token]:
    """The text, with accounts and bare web addresses as links."""
    done = 0
    found = [(m.start(), m["url"], "") for m in _ADDRESS.finditer(text)]
    found += [(start, "", name) for name, start, _ in shown_mentions(text)]
    for start, address, called in sorted(found):
        if address:
            url = _without_tail(address)
            href, shown, css = md.normalizeLink(url), url, ""
            if not md.validateLink(href):
                continue
        else:
            if not is_account(called):
                continue
            href, shown, css = f"/u/{called}", text[start : start + len(called) + 1], "mention"
        yield _text(text[done:start])
        yield from _link(href, shown, css)
        done = start + len(shown)
    yield _text(text[done:])


def _without_tail(url: str) -> str:
    """Return a URL without punctuation that ends the sentence."""
    end, unopened = len(url), url.count(")") - url.count("(")
    while end and (url[end - 1] in ".,;:!?*_~]" or (url[end - 1] == ")" and unopened > 0)):
        end -= 1
        unopened -= url[end] == ")"
    return url[:end]


def _nobody(_name: str) -> bool:
    return False


def _text(content: str) -> Token:
    return Token("text", "", 0, content=content)


def _link(href: str, shown: str, css: str = "") -> Iterator[Token]:
    attrs: dict[str, str | int | float] = {"href": href}
    if css:
        attrs["class"] = css
    yield Token("link_open", "a", 1, attrs=attrs)
    yield _text(shown)
    yield Token("link_close", "a", -1)


def _valid_link(url: str) -> bool:
    return bool(_SAFE_LINK.match(url.strip()))


def _parser() -> MarkdownIt:
    md = MarkdownIt("commonmark", {"html": False, "breaks": True}).enable(["table", "strikethrough"])
    md.validateLink = _valid_link  # type: ignore[method-assign]
    return md


_MARKDOWN = _parser()
