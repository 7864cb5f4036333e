"""Rendering of a post's Markdown, and that the result is always safe HTML."""

from __future__ import annotations

import re
import time
from html.parser import HTMLParser
from urllib.parse import urlsplit

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.board.content.markdown import render

KNOWN = {"quadruped", "alice", "my_robot-2"}


def known(name: str) -> bool:
    return name in KNOWN


def html(raw: str) -> str:
    return render(raw, known).strip()


class Audit(HTMLParser):
    """Parses the HTML again, independently of the sanitiser, and collects everything that should not be in it."""

    TAGS = frozenset(
        {
            *("p", "br", "hr", "em", "strong", "s", "blockquote", "pre", "code", "ul", "ol", "li", "h3", "h4", "h5"),
            *("h6", "table", "thead", "tbody", "tr", "th", "td", "a", "img"),
        }
    )
    ATTRIBUTES = frozenset({"href", "title", "src", "alt", "start", "align", "class", "rel", "loading"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.bad: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.TAGS:
            self.bad.append(f"<{tag}>")
        for name, value in attrs:
            if name not in self.ATTRIBUTES:
                self.bad.append(f"{tag} {name}")
            if name == "href" and urlsplit(re.sub(r"[\x00-\x20]", "", value or "")).scheme not in (
                "http",
                "https",
                "mailto",
                "",
            ):
                self.bad.append(f"link {value}")
            if name == "src" and not re.fullmatch(r"/images/[\w-]+(\.\w+)?", value or "", re.ASCII):
                self.bad.append(f"picture {value}")

    def handle_comment(self, data: str) -> None:
        self.bad.append(f"comment {data}")

    def handle_decl(self, decl: str) -> None:
        self.bad.append(f"declaration {decl}")


def test_common_markdown_is_shown() -> None:
    assert html("**bold** and `code`\nnext line") == "<p><strong>bold</strong> and <code>code</code><br>\nnext line</p>"
    assert html("~~gone~~") == "<p><s>gone</s></p>"
    assert html("3. c") == '<ol start="3">\n<li>c</li>\n</ol>'
    assert '<th align="right">b</th>' in html("|a|b|\n|-|-:|\n|1|2|")
    assert html("```py\n<x>\n```") == "<pre><code>&lt;x&gt;\n</code></pre>"


def test_headings_are_below_those_of_the_page() -> None:
    assert html("# One") == "<h3>One</h3>"
    assert html("###### Six") == "<h6>Six</h6>"


def test_links_are_marked_as_user_content() -> None:
    assert html("[a](https://example.org)") == '<p><a href="https://example.org" rel="nofollow noopener ugc">a</a></p>'


@pytest.mark.parametrize("target", ["javascript:alert(1)", "JaVaScRiPt:x", "data:text/html,x", "vbscript:x", "foo:bar"])
def test_links_other_than_http_and_mail_stay_text(target: str) -> None:
    assert "<a" not in html(f"[a]({target})")
    assert "<a" not in html(f"<{target}>")


def test_bare_urls_become_links_without_the_full_stop() -> None:
    assert 'href="https://example.org/a_(b)"' in html("(see https://example.org/a_(b)).")
    assert 'href="https://example.org/x"' in html("看https://example.org/x，好")
    assert "<a" not in html("`https://example.org`")


def test_pictures_of_the_forum_are_shown_and_others_are_links() -> None:
    assert html("![a](/images/ab12.jpg)") == '<p><img src="/images/ab12.jpg" alt="a" loading="lazy"></p>'
    assert html("![a](https://example.org/x.png)").startswith('<p><a href="https://example.org/x.png"')
    assert "<img" not in html("![a](/images/../robots/x) ![b](//images/x.png) ![c](images/x.png)")
    assert html("[![a](http://b/c.png)](http://d)").count("<a") == 1


def test_mentions_are_links() -> None:
    link = '<a href="/u/quadruped" class="mention" rel="nofollow noopener ugc">{}</a>'
    assert html("@quadruped walk") == f"<p>{link.format('@quadruped')} walk</p>"
    assert html("请@Quadruped前进1米") == f"<p>请{link.format('@Quadruped')}前进1米</p>"
    assert html("＠quadruped: go") == f"<p>{link.format('＠quadruped')}: go</p>"
    assert html("＠quadruped- go") == "<p>＠quadruped- go</p>", "no robot reads it as a mention"
    assert "/u/my_robot-2" in html("*@my_robot-2*, go")


@pytest.mark.parametrize(
    "text",
    [
        *("@nobody", "a@quadruped", "`@quadruped`", "~~@quadruped~~", "> @quadruped", "# @quadruped", "@@quadruped"),
        *("    @quadruped", "[@quadruped](http://x)", "@quadrupeds", "|a|\n|-|\n|@quadruped|"),
    ],
)
def test_names_in_code_links_and_addresses_are_not_mentions(text: str) -> None:
    assert "mention" not in html(text)


PIECES = r"""
< > " ' ` ``` [ ]( ) ![ javascript: data: // /images/ @alice - # | -|- ** _ ~~ \ &#x6a; &lt; script onerror= https://
mailto: style= <img <svg/onload= <!-- --> http://[::1 % * + 1. src=x
"""
markup = st.lists(
    st.sampled_from([*PIECES.split(), " ", "\n", "\n\n", "> ", "- ", "# ", "    ", "\0", "\u202e"])
    | st.text(max_size=6),
    max_size=30,
).map("".join)


@settings(max_examples=400)
@given(markup)
def test_any_text_renders_to_safe_html(raw: str) -> None:
    assert Audit(render(raw, lambda _: True)).bad == []


@settings(max_examples=200)
@given(st.text(alphabet=st.characters(exclude_categories=[]), max_size=200))
def test_any_unicode_is_accepted_even_lone_surrogates(raw: str) -> None:
    assert Audit(render(raw, known)).bad == []


@settings(max_examples=200)
@given(markup)
def test_sanitising_twice_changes_nothing(raw: str) -> None:
    """Parsing and sanitising the result again gives the same HTML, so a browser reads it as intended."""
    once = render(raw, known)
    assert render_wall(once) == once


def render_wall(text: str) -> str:
    from agentrob.board.content.markdown import _CLEANER

    return _CLEANER.clean(text)


def test_a_very_long_url_renders_quickly() -> None:
    started = time.thread_time()
    assert render("http://a" + ")" * 64_000, known).count("<a ") == 1
    assert time.thread_time() - started < 0.5


@pytest.mark.parametrize(
    "nasty", ["[", "![", "*a ", "`a", "~~a", "> ", "@a-", "&", "<", "a_*", "http://", "[a](<", "|a"]
)
def test_pathological_texts_render_quickly(nasty: str) -> None:
    started = time.thread_time()
    assert Audit(render(nasty * (20_000 // len(nasty)), lambda _: True)).bad == []
    assert time.thread_time() - started < 5
