"""On a forum whose pages are not ours, what its page shows is held against what is read of a post (law 3)."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.forums.nodebb.posts import mentions_in
from agentrob.language.rendered_text import MAX_ELEMENTS, MAX_HTML, rendering_differs

_BOB = (
    '<a class="plugin-mentions-user plugin-mentions-a" href="/user/bob" aria-label="Profile: bob">@<bdi>bob</bdi></a>'
)
_DOG = '<a class="mention" href="/u/dog">@dog</a>'


@pytest.mark.parametrize(
    ("raw", "html"),
    [
        ("@bob walk 1 m", f'<p dir="auto">{_BOB} walk 1 m</p>\n'),
        ("@Dog **walk** 1.5 m, don't stop", f"<p>{_DOG} <strong>walk</strong> 1.5 m, don’t stop</p>"),
        ("@bob walk", '<p><a class="mention plugin-mentions-user" href="https://a.b/uid/7">@bob</a> walk</p>'),
        ("@dog @nobody walk", f'<p>{_DOG} <span class="mention">@nobody</span> walk</p>'),
        ("@dog @all walk", f'<p>{_DOG} <a class="mention-group" href="/groups/all">@all</a> walk</p>'),
        ("@all go", '<p><a class="mention plugin-mentions-group" href="/groups/all">@<bdi>all</bdi></a> go</p>'),
        ("@bob 走一米\n然后挥手", f'<p dir="auto">{_BOB} 走一米<br />\n然后挥手</p>'),
        ("- walk 1 m\n- wave", '<ul dir="auto">\n<li>walk 1 m</li>\n<li>wave</li>\n</ul>'),
        ("3. walk\n4. wave", '<ol start="3">\n<li>walk</li>\n<li>wave</li>\n</ol>'),
        ("see [this](https://a.b) and `code`", '<p>see <a href="https://a.b">this</a> and <code>code</code></p>'),
        ("# Title\n\n> said\n\nwalk", "<h1>Title</h1><blockquote><p>said</p></blockquote><p>walk</p>"),
        ("~~no~~ walk ![x](/y.png)", '<p><s>no</s> walk <img src="/y.png" alt="x"></p>'),
        ('"walk" -- 1 m...', "<p>“walk” – 1 m…</p>"),
        ("ｗａｌｋ 1½ m", "<p>ｗａｌｋ 1½ m</p>"),
        ("", ""),
    ],
)
def test_law_3_a_page_that_shows_the_words_that_are_read(raw: str, html: str) -> None:
    assert not rendering_differs(raw, html)


@pytest.mark.parametrize(
    ("raw", "html"),
    [
        ("@dog walk 1 m", f"<p>{_DOG} walk 9 m</p>"),  # a word that an admin replaces
        ("@dog walk", f"<p>{_DOG} ■■■■</p>"),
        ("@dog walk 1 m", f'<p>{_DOG} walk <span class="spoiler">1 m</span></p>'),
        ("@dog walk 1 m", f"<p>{_DOG} <span hidden>walk 1 m</span></p>"),
        ("@dog walk 1 m", f'<p class="d-none">{_DOG} walk 1 m</p>'),
        ("@dog walk 1 m", f"<details><summary>more</summary><p>{_DOG} walk 1 m</p></details>"),
        ("@dog <b>don't</b> walk", f"<p>{_DOG} &lt;b&gt;don't&lt;/b&gt; walk</p>"),  # shown as it was typed
        ("@dog :wave:", f'<p>{_DOG} <img class="emoji" title=":wave:" alt=":wave:"></p>'),
        ("@dog walk 1.5 m", f"<p>{_DOG} walk 15 m</p>"),
        ("@dog walk 1 m", f"<p>{_DOG} walk 1 m and sit</p>"),
        ("@dog walk 1 m", ""),
        ("walk", "<![walk"),
        ("walk", "<p>walk" + " " * MAX_HTML),
    ],
)
def test_law_3_a_page_that_shows_other_words(raw: str, html: str) -> None:
    assert rendering_differs(raw, html)


@pytest.mark.parametrize(
    "piece", ["<i x>", "</i>", "<i x></b>", "<", "<p", "<!--", "<![", "&#x", "<a href='", "<p>", "x<br>"]
)
def test_law_15_no_page_takes_long_to_be_read(piece: str) -> None:
    began = time.process_time()
    for _ in range(5):
        rendering_differs("walk", piece * (MAX_HTML // len(piece)))
        rendering_differs("walk", (piece * (2 * MAX_ELEMENTS // max(1, piece.count("<"))))[:MAX_HTML])
        rendering_differs("walk", "<i x>" * MAX_ELEMENTS + "</i>" * MAX_ELEMENTS)
    assert time.process_time() - began < 0.5


def test_a_page_with_many_elements_is_read() -> None:
    assert not rendering_differs("a " * 998, f"<p>{'<b>a</b> ' * 998}</p>")
    assert rendering_differs("a " * 998, f"<p>{'<b>a</b> ' * 997}b</p>")


@given(st.text(max_size=200), st.text(max_size=200))
def test_whatever_a_forum_makes_of_a_post_it_is_held_against_it(raw: str, html: str) -> None:
    assert rendering_differs(raw, html) in (True, False)


@pytest.mark.parametrize(
    ("link", "names"),
    [
        (_BOB, ("bob",)),
        ('<a class="mention plugin-mentions-user plugin-mentions-a" href="https://a.b/uid/7">@bob</a>', ("bob",)),
        ('<a class="mention plugin-mentions-group plugin-mentions-a" href="/groups/bob">@bob</a>', ()),
        ('<a href="https://a.b/user/bob">@bob</a>', ()),
        (f"<blockquote>{_BOB}</blockquote>", ()),
    ],
)
def test_law_1_links_to_accounts_are_mentions_on_nodebb_and_links_to_groups_are_none(
    link: str, names: tuple[str, ...]
) -> None:
    assert mentions_in(f"<p>{link} walk</p>") == names
