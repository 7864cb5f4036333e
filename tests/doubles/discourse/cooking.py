"""Render Markdown like Discourse, as far as robots need it: mentions that resolve, uploads, quotes."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape

import nh3
from markdown_it import MarkdownIt
from markdown_it.token import Token

_MENTION = re.compile(r"(?<![\w@/])@([\w.-]*\w)")
_QUOTE = re.compile(r"\[quote(?:=[^\]\n]*)?\]\n?(.*?)\[/quote\]", re.DOTALL)
_MARKDOWN = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"])
_MARKDOWN.validateLink = lambda url: not url.startswith(("javascript:", "data:"))  # type: ignore[method-assign]
_TAGS = (nh3.ALLOWED_TAGS | {"aside", "div"}) - {"script", "style"}
_ATTRIBUTES = {"a": {"href", "class"}, "img": {"src", "alt", "class"}, "aside": {"class"}, "div": {"class"}}


def cook(raw: str, known: Callable[[str], bool], upload: Callable[[str], str]) -> str:
    """Render a post; `known` tests whether a name is an account, `upload` resolves an `upload://` link."""
    tokens = _MARKDOWN.parse(_QUOTE.sub(r'<aside class="quote">\n\n\1\n\n</aside>\n', raw))
    for token in tokens:
        for child in token.children or ():
            _cook(child, known, upload)
    html = _MARKDOWN.renderer.render(tokens, _MARKDOWN.options, {})
    return nh3.clean(html, tags=_TAGS, attributes=_ATTRIBUTES, generic_attribute_prefixes={"data-"}, link_rel=None)


def _cook(token: Token, known: Callable[[str], bool], upload: Callable[[str], str]) -> None:
    if token.type == "image":
        token.attrs["src"] = upload(str(token.attrs.get("src", "")))
    elif token.type == "text" and "@" in token.content:
        token.type, text = "html_inline", escape(token.content, quote=False)
        token.content = _MENTION.sub(lambda m: _mention(m[1], known), text)


def _mention(name: str, known: Callable[[str], bool]) -> str:
    if known(name.lower()):
        return f'<a class="mention" href="/u/{name.lower()}">@{name}</a>'
    return f'<span class="mention">@{name}</span>'
