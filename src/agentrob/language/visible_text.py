"""Extract the text of a post that counts: what a reader plainly sees in paragraphs and lists, and whom it mentions.

Everything that can hide words is left out: headings, code, quotes, strikethrough, HTML and all text inside HTML
elements, image descriptions, links with their text, tables, `[quote]…[/quote]` and similar tags. Where it is unclear
whether something is hidden (a tag, a quote or, at the start of a block, a comment that is never closed), the rest is
left out too, so that a robot does less, never more. A `<!--` that is never closed within a line is not a comment in
Markdown: readers see it and what follows, so both count, and the grammar cannot parse such a mark.

Words left out of the middle of a line leave a mark (U+FFFC) that the grammar cannot parse: "`don't` walk 1 m" is not a
command to walk. The board renders posts with the same functions: `without_invisible` removes the same characters, and
`shown_mentions` finds the same mentions.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from functools import lru_cache
from html import unescape
from html.parser import HTMLParser

from markdown_it import MarkdownIt
from markdown_it.token import Token

from agentrob.language.complexity import nfkc, parsing_us

#: Longer posts have no visible text, so that parsing stays fast.
MAX_CHARS = 10_000
#: Neither do posts whose markup would take longer to parse: stops would wait meanwhile (law 15).
MAX_PARSING_US = 30_000

#: Replaces words that inline code or HTML hides within a visible line.
OMITTED = "\ufffc"

_MARKDOWN = MarkdownIt("commonmark", {"html": True}).enable(["strikethrough", "table"])
_PARAGRAPHS = ("paragraph_open",)
_HIDING_BLOCKS = ("blockquote", "table", "heading")
VOID_TAGS = frozenset(
    ["area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"]
)
_BBCODE = re.compile(
    r"\[(/?)(quote|code|s|strike|del|spoiler|details|hide|hidden|noparse)\b[^\[\]\n]*\]", re.IGNORECASE
)
# Letters and symbols that are not drawn, beyond the categories Cf, Cc, Cs, Co and Cn.
_BLANKS = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\uffa0")


#: One line without markup: it begins with a letter and contains no character that may begin markup within a line.
_PLAIN = re.compile(r"[^\W\d_][^\x00-\x1f\x7f*_`~\[\]<>&\\|@＠﹫]*")
# Characters that are not drawn, or that reverse the reading order of a line. Joiners and selectors stay between letters
# and emoji that need them, and are removed beside characters that are ASCII or become ASCII in NFKC.
_LATIN = "[!-~\u2100-\u218f\u2460-\u24ff\uff01-\uff5e\U0001d400-\U0001d7ff]"
_UNSEEN = re.compile(
    "[\u00ad\u034f\u061c\u180e\u200b\u200e\u200f\u202a-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\U000e0000-\U000e007f]"
    f"|(?<={_LATIN})[\u200c\u200d\ufe00-\ufe0f]+|[\u200c\u200d\ufe00-\ufe0f]+(?={_LATIN})"
)
#: A bare address, which is shown as a link.
ADDRESS = r"(?<![A-Za-z0-9])(?P<url>https?://[^\s<>\"'`|\\^{}\u3000-\u303f\uff00-\uffef]+)"
_ADDRESS = re.compile(ADDRESS, re.IGNORECASE)
_TURNING = re.compile("[\u202a-\u202e\u2066-\u2069]")
_NUMBER = re.compile(r"\d[\d.,:/]*\d")
# Mark in `_Walker.out` where a mention begins or ends a run of text; `without_invisible` removes both from a post.
_BEGINS, _ENDS = "\ufff9", "\ufffb"
#: What may follow a mention at the end of a run, so that the next run would make it a part of something longer.
_BESIDE = frozenset(["", ".", "/", "\\", ":"])
_JOINED = re.compile(f"(?<=\\S){_BEGINS}(?=\\S)|(?<=\\S){_ENDS}(?=[\\w@＠-]|[/\\\\.:]\\w)")


def without_invisible(text: str) -> str:
    """Return the text without invisible characters and those that change the reading order, for display and parsing."""
    return text if text.isascii() else _UNSEEN.sub("", _UNSEEN.sub("", text))


def shown_mentions(run: str) -> Iterable[tuple[str, int, int]]:
    """Yield the mentions in one run of shown text (without emphasis, links or code) as handle, start, end.

    Plain URLs mention nobody.
    """
    plain = _ADDRESS.sub(lambda m: OMITTED * len(m[0]), run) if "://" in run else run
    return mention_spans(plain if plain.isascii() else "".join(map(_letter, plain)))


@lru_cache(maxsize=4096)
def _letter(char: str) -> str:
    """Return the character in NFKC if that is one character, so that positions in the text stay the same."""
    composed = unicodedata.normalize("NFKC", char)
    return composed if len(composed) == 1 and not _is_compound_digit(char) else char


def visible_text(raw: str) -> str:
    """Return the visible text of a Markdown body in paragraphs and lists, NFKC-normalised and with mentions."""
    return _visible(raw) if readable(raw) else ""


def readable(raw: str) -> bool:
    """Return whether a body is short and simple enough that its visible text is read."""
    return len(raw) <= MAX_CHARS and parsing_us(raw, MAX_PARSING_US) <= MAX_PARSING_US


@lru_cache(maxsize=64)  # one post is asked about several times in a row
def _visible(raw: str) -> str:
    walker = _Walker()
    shown = without_invisible(raw)
    if _PLAIN.fullmatch(shown):
        walker.line(shown.strip())
    else:
        walker.blocks(_MARKDOWN.parse(shown))
    text = _JOINED.sub(OMITTED, "".join(walker.out))
    if len(nfkc(text)) > MAX_CHARS:  # some characters are up to 18 in NFKC
        return ""
    shown = _without_bbcode(normalized(text)).strip()
    return f"{shown} {OMITTED}" if _is_turned(raw, shown) else shown


def _is_turned(raw: str, shown: str) -> bool:
    """Return whether a number may be displayed in reverse, 93 as 39.

    Forums whose pages are not ours display the characters that do this. A mark is then added, and the robot asks back.
    """
    return _NUMBER.search(shown) is not None and _TURNING.search(raw if "&" not in raw else unescape(raw)) is not None


# A handle must not continue in letters that only look Latin; Chinese, written without spaces, may follow directly.
_HANDLE = re.compile(r"@([A-Za-z][A-Za-z0-9_-]{1,31})(?![A-Za-z0-9_@-]|[/\\.][A-Za-z0-9_]|:[0-9])")
_NO_MENTION_AFTER = frozenset("@/\\.+%=&#~-")


def mentions(visible: str) -> tuple[str, ...]:
    """Return the handles after an @, lower case, each once in order; not those in e-mail addresses, paths or longer
    words.
    """
    found = (name for name, _, _ in mention_spans(visible))
    return tuple(dict.fromkeys(found))


def mention_spans(visible: str) -> Iterable[tuple[str, int, int]]:
    """Yield every mention as (handle, start, end); `visible[start]` is the @."""
    for match in _HANDLE.finditer(visible):
        before = visible[match.start() - 1] if match.start() else " "
        after = visible[match.end()] if match.end() < len(visible) else " "
        if before in _NO_MENTION_AFTER or _joins_words(before) or _joins_words(after):
            continue
        yield match[1].lower(), match.start(), match.end()


def without_mentions(visible: str) -> str:
    """Return the text with each mention replaced by a space."""
    text, at = [], 0
    for _, start, end in mention_spans(visible):
        text.append(visible[at:start])
        at = end
    return " ".join([*text, visible[at:]])


def _joins_words(char: str) -> bool:
    """Return whether a character would form one word with its neighbour: letters, digits, marks, but not CJK."""
    if "\u3040" <= char <= "\u30ff" or "\u3400" <= char <= "\u9fff" or "\uac00" <= char <= "\ud7af":
        return False
    return char == "_" or unicodedata.category(char)[0] in "LNM"


class _Walker:
    """Collect the text of visible paragraphs from Markdown tokens, in reading order."""

    def __init__(self) -> None:
        self.out: list[str] = []
        self._html = _OpenElements()

    def line(self, text: str) -> None:
        """Take a paragraph of one line without markup."""
        self.out += [_run(text), "\n"]

    def blocks(self, tokens: Iterable[Token]) -> None:
        hidden = 0
        in_paragraph = False
        for token in tokens:
            if token.type.startswith(_HIDING_BLOCKS):
                hidden += token.nesting
            elif token.type in _PARAGRAPHS:
                in_paragraph = True
            elif token.type == "html_block":
                self._html.feed(token.content)
            elif token.type == "inline":
                # Inline tags of hidden blocks count too: they may open an element that hides what follows.
                self._inline(token.children or [], hidden=hidden > 0 or not in_paragraph)
            elif token.type == "paragraph_close":
                in_paragraph = False
                self.out.append("\n")

    def _inline(self, children: list[Token], hidden: bool) -> None:
        struck = 0
        link_start = 0
        for token in children:
            in_html = self._html.depth > 0
            visible = not (hidden or struck or in_html)
            if token.type == "html_inline":
                self._html.feed(token.content)
                self.out.append(" " if visible else "")
            elif token.type in ("s_open", "s_close"):
                struck += token.nesting
            elif token.type == "link_open":
                link_start = len(self.out)
            elif token.type == "link_close":
                self._without_link(link_start)
            elif visible and token.type == "text":
                self.out.append(_run(without_invisible(token.content)))
            elif (visible and token.type == "code_inline") or (in_html and token.type == "text" and not hidden):
                self.out.append(OMITTED)
            elif visible and token.type in ("softbreak", "hardbreak"):
                self.out.append("\n")
            elif visible and token.type not in ("em_open", "em_close", "strong_open", "strong_close"):
                self.out.append(" ")  # pictures hide their words but still separate those around them

    def _without_link(self, link_start: int) -> None:
        """Remove the words of a link, which are never a command.

        A link reference named "quote" would swallow the brackets of a [quote], so put those back.
        """
        text = "".join(self.out[link_start:])
        bracketed = f"[{normalized(text).strip()}]"
        if _BBCODE.fullmatch(bracketed):
            self.out[link_start:] = [bracketed]
        elif text.strip():
            self.out[link_start:] = [OMITTED]


def _run(text: str) -> str:
    """Return a run of text as it is parsed: without plain URLs, with an @ only where the board renders a mention."""
    kept, at = [], 0
    for _, start, end in shown_mentions(text):
        kept += [_disarmed(text[at:start]), _BEGINS * (start == 0), text[start:end], _ENDS * (text[end:] in _BESIDE)]
        at = end
    return "".join([*kept, _disarmed(text[at:])])


def _disarmed(text: str) -> str:
    shown = _ADDRESS.sub(OMITTED, text) if "://" in text else text
    return re.sub("[@＠﹫](?=.)", lambda m: m[0] + OMITTED, shown)


class _OpenElements(HTMLParser):
    """Track which HTML elements are open; text inside any of them is left out."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=False)
        self._open: list[str] = []
        self._lost = False

    @property
    def depth(self) -> int:
        """The number of open elements; an unfinished comment, script or tag counts as one."""
        return len(self._open) + bool(self.rawdata) + self._lost

    def feed(self, data: str) -> None:
        """Parse more markup; never raises. After markup that the parser cannot follow, everything counts as hidden."""
        if self._lost:
            return
        try:
            super().feed(data)
        except Exception:  # the parser asserts and fails on some malformed declarations
            self._lost = True

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID_TAGS:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)  # browsers ignore the slash of <div/>

    def handle_endtag(self, tag: str) -> None:
        if tag in self._open:
            last = len(self._open) - 1 - self._open[::-1].index(tag)
            del self._open[last:]


def normalized(text: str) -> str:
    """Return NFKC text without invisible and bidirectional characters, with plain spaces and line feeds."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return re.sub(" {2,}", " ", text)
    # NFKC would make 11⁄2 of 1½ and 22 of 2²: such digits stay apart from their neighbours.
    text = "".join(f" {c} " if not c.isascii() and _is_compound_digit(c) else c for c in text)
    shown = "".join(filter(None, map(_shown, nfkc(text))))
    return re.sub(" {2,}", " ", nfkc(shown))


@lru_cache(maxsize=1024)
def _is_compound_digit(char: str) -> bool:
    kind = unicodedata.decomposition(char).partition(">")[0]
    return kind in ("<fraction", "<super", "<sub", "<circle", "<compat", "<square") and any(
        c.isdigit() for c in unicodedata.normalize("NFKC", char)
    )


@lru_cache(maxsize=4096)
def _shown(char: str) -> str:
    if (char.isascii() and char.isprintable()) or char == "\n":
        return char
    if char in "\t\r\v\f\u2028\u2029\x85":
        return " " if char == "\t" else "\n"
    category = unicodedata.category(char)
    if category == "Zs":
        return " "
    if category in ("Cf", "Cc", "Cs", "Co", "Cn") or char in _BLANKS or _is_selector(char):
        return ""
    return char


def _is_selector(char: str) -> bool:
    """Return whether a character is a variation selector, which only changes how the one before it is drawn."""
    return "\u180b" <= char <= "\u180f" or "\ufe00" <= char <= "\ufe0f" or "\U000e0100" <= char <= "\U000e01ef"


def _without_bbcode(text: str) -> str:
    """Remove `[quote]…[/quote]` and the like, nested ones too; an unclosed one hides everything after it."""
    kept: list[str] = []
    depth = 0
    at = 0
    for tag in _BBCODE.finditer(text):
        if depth == 0:
            kept.append(text[at : tag.start()] + "\n")
        depth = max(0, depth + (-1 if tag[1] else 1))
        at = tag.end()
    if depth == 0:
        kept.append(text[at:])
    return "".join(kept)
