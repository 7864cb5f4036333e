"""Excerpts of posts: the first sentences of prose, the part with the words of a search, the parts of a robot's report.

Both read the HTML that is stored with a post, and of a long post only a part, because pages are rendered on the event
loop, which the stop button needs too. They return plain text, which templates must escape.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape, unescape

import nh3

from agentrob.board.search.search import terms
from agentrob.language.messages.catalog import say
from agentrob.language.registry import known

#: Characters of HTML that an excerpt is made from, in which a hit is looked for, and that are shown around it.
EXCERPT_FROM, SEARCHED, AROUND_FROM = 3_000, 131_072, 8_000
#: The most characters of an excerpt. One that does not end with a sentence is cut, unless less than this would remain.
LENGTH, LEAST = 140, 50
#: Replaces the text of a post that has none.
_NAMED = {"<table": "(a table)", "<pre": "(code)"}
_PICTURE = "(a picture)"

_HIDDEN = {"table", "pre"}
_ASIDE = {"blockquote", "h3", "h4", "h5", "h6"}
_CLEANERS = {
    prose: nh3.Cleaner(
        tags={"p", "li", "em", *(() if prose else _ASIDE)},
        clean_content_tags=_HIDDEN | (_ASIDE if prose else set()),
        attributes={},
        link_rel=None,
    )
    for prose in (True, False)
}
_BLOCK = re.compile(r"</?(?:p|li|blockquote|h[3-6])>")
_EMPHASIS = re.compile(r"</?em>")
#: A paragraph that is emphasised as a whole is small print, such as the times and the trace of a report.
_SMALL_PRINT = re.compile(r"<em>(?:(?!</em>).)*</em>", re.DOTALL)
#: The heading of the details in each language (`#### Details` in Markdown), which pages show as a fold.
_DETAILS = re.compile(
    "<h6>(" + "|".join(sorted({re.escape(escape(say("agent.details", language))) for language in known()})) + ")</h6>"
)
_SENTENCE_END = re.compile(r"[.!?…]+(?=\s)|[。！？]+")


def excerpt(html: str) -> str:
    """The first sentences of a post, in one line: without tables, pictures and code, and without quotations, headings
    and small print if anything else is said. Of a robot's report only what stands above its table."""
    parts = report_parts(html[:EXCERPT_FROM])
    html = parts.lead if parts.heading else html[:EXCERPT_FROM]
    text = _joined(_paragraphs(html, prose=True)) or _joined(_paragraphs(html, prose=False))
    if not text:
        return next((name for tag, name in _NAMED.items() if tag in html), _PICTURE)
    if len(text) <= LENGTH:
        return text
    ends = [end.end() for end in _SENTENCE_END.finditer(text[: LENGTH + 1]) if LEAST <= end.end() <= LENGTH]
    return text[: ends[-1]] if ends else text[:LENGTH].rstrip() + "…"


def around(html: str, query: str, length: int = 200) -> tuple[tuple[str, bool], ...]:
    """The part of a post with the words of a query, in pieces, each with whether it is such a word.

    The excerpt of the post if its words are only in its title, in tables, in code, in the details of a report or beyond
    `SEARCHED` characters.
    """
    words = sorted(terms(query), key=len, reverse=True)
    if not words:
        return ((excerpt(html), False),)
    parts = report_parts(html)
    html = (parts.lead + parts.rest)[:SEARCHED]
    pattern = re.compile("|".join(map(_beginning, words)), re.IGNORECASE)
    begin = _window(html, words)
    window = html[begin : begin + AROUND_FROM]
    plain = _joined(_paragraphs(window, prose=False))
    first = pattern.search(plain)
    if first is None:
        return ((excerpt(html), False),)
    start = max(0, first.start() - length // 3)
    if start:  # at a word, if the language separates words
        start = plain.find(" ", start, first.start()) + 1 or start
    shown = plain[start : start + length]
    pieces, done = [("…", False)] if begin or start else [], 0
    for match in pattern.finditer(shown):
        pieces += [(shown[done : match.start()], False), (match[0], True)]
        done = match.end()
    pieces += [(shown[done:], False)]
    pieces += [("…", False)] if start + length < len(plain) or begin + len(window) < len(html) else []
    return tuple(piece for piece in pieces if piece[0])


def _window(html: str, words: Sequence[str]) -> int:
    """Where the part of a long post begins that holds the first of the words: at a paragraph, if one is near."""
    if len(html) <= AROUND_FROM:
        return 0
    pattern = "|".join(_beginning(escape(word, quote=False)) for word in words)
    found = re.search(rf"(?:{pattern})(?![^<>]*>)", html, re.IGNORECASE)  # not within a tag
    if found is None:
        return 0
    paragraph = html.rfind("<p>", 0, found.start())
    near = found.start() - AROUND_FROM // 2
    if paragraph >= near:
        return paragraph
    return 0 if _within_hidden(html, found.start()) else near


def _within_hidden(html: str, at: int) -> bool:
    return any(html.rfind(f"<{tag}", 0, at) > html.rfind(f"</{tag}>", 0, at) for tag in _HIDDEN)


def _paragraphs(html: str, *, prose: bool) -> Iterator[str]:
    """The paragraphs and list items as plain text without tables and code; for `prose` also without asides."""
    for block in _BLOCK.split(_CLEANERS[prose].clean(html)):
        if prose and _SMALL_PRINT.fullmatch(block.strip()):
            continue
        if text := " ".join(unescape(_EMPHASIS.sub("", block)).split()):
            yield text


def _joined(paragraphs: Iterator[str]) -> str:
    """Paragraphs in one line, with a dot between those that do not end with a sentence."""
    line = ""
    for text in paragraphs:
        if line:
            line += " " if line[-1] in ".!?…:。！？：" else " · "
        line += text
    return line


def _beginning(word: str) -> str:
    """A pattern that matches a word only at its beginning: `to` does not match in `photo`."""
    written = word.strip("@") or word
    return ("" if not written[0].isascii() else r"(?<![A-Za-z0-9\u00c0-\u024f])") + re.escape(written)


# -------------------------------------------------------------------- reports of robots
@dataclass(frozen=True, slots=True)
class ReportParts:
    """Safe HTML: `lead` says what happened, `rest` begins with the table of steps, `details` follow the heading
    `heading`. All but `lead` may be empty."""

    lead: str
    rest: str = ""
    details: str = ""
    heading: str = ""


def report_parts(html: str) -> ReportParts:
    """The parts of a report; a post of another form is all `lead`."""
    above, *found = _DETAILS.split(html, maxsplit=1)
    heading, details = found if found else ("", "")
    at = above.find("<table")
    lead, rest = (above, "") if at < 0 else (above[:at], above[at:])
    if not all(map(_is_whole, (lead, rest, details))):
        return ReportParts(html)
    return ReportParts(lead, rest, details.strip(), heading)


def _is_whole(html: str) -> bool:
    """Whether no quotation or list begins or ends in another part."""
    return all(html.count(f"<{tag}") == html.count(f"</{tag}>") for tag in ("blockquote", "ul", "ol"))
