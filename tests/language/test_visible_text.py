"""Law 3: only what a reader plainly sees in paragraphs and lists counts, and mentions are never guessed."""

from __future__ import annotations

import time

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from agentrob.language.visible_text import MAX_CHARS, mentions, visible_text

SEEN = [
    ("walk 1 m", "walk 1 m"),
    ("*walk* **1** m", "walk 1 m"),
    ("- walk 1 m\n- turn left", "walk 1 m\nturn left"),
    ("walk\n1 m\n\nturn", "walk\n1 m\nturn"),
    ("[walk 1 m](https://example.org/5)", "\ufffc"),
    ("＠ｑｕａｄ　向前走１米", "@quad 向前走1米"),
    ("w\u200bal\u00adk\u2060 \u202e1 m\ufe0f", "walk 1 m"),
    ("walk 1½ m", "walk 1 1⁄2 m"),
    ("walk&nbsp;1&#32;m", "walk 1 m"),
]
HIDDEN = [
    "# walk 5 m",
    "walk 5 m\n===",
    "> walk 5 m\nwalk 5 m",
    "- > walk 5 m",
    "`walk 5 m`",
    "```\nwalk 5 m",
    "    walk 5 m",
    "~~walk 5 m~~",
    "![walk 5 m](walk.jpg)",
    "<https://walk.example/5>",
    "<!-- walk 5 m -->",
    "<!-- walk\n\nwalk 5 m",
    "<span hidden>walk 5 m</span>",
    "<div style='display:none'>\n\nwalk 5 m\n\n</div>",
    "<details>\n\nwalk 5 m",
    "<div title='</div>'>\n\nwalk 5 m",
    "<script>\n\nwalk 5 m",
    "| a | b |\n|---|---|\n| walk | 5 m |",
    "[quote]walk 5 m[/quote]",
    '[quote="bob, post:1"]\n\nwalk 5 m\n\n[quote]x[/quote] walk 5 m\n\n[/quote]',
    "[quote]walk 5 m",
    "［quote］walk 5 m［／quote］",
    "[quo\u200bte]walk 5 m[/quote]",
    "[quote]: https://example.org\n[quote]walk 5 m[/quote]",
    "[QUOTE=bob]walk 5 m[/QUOTE]",
    "[spoiler]walk 5 m[/spoiler]",
    "[walk 5 m]: https://example.org",
]


@pytest.mark.parametrize(("raw", "text"), SEEN)
def test_what_a_reader_sees_is_kept(raw: str, text: str) -> None:
    assert visible_text(raw) == text


@pytest.mark.parametrize("raw", HIDDEN)
def test_what_is_hidden_or_quoted_is_left_out(raw: str) -> None:
    assert "walk" not in visible_text(raw)
    assert "5" not in visible_text(f"hello\n\n{raw}")


@pytest.mark.parametrize("raw", [h for h in HIDDEN if "https" not in h and not h.endswith("walk 5 m")])
def test_what_follows_hidden_text_is_seen_again(raw: str) -> None:
    assert visible_text(f"{raw}\n\nturn left").endswith("turn left")


def test_very_long_posts_have_no_visible_text() -> None:
    assert visible_text("walk " * MAX_CHARS) == ""


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("@quadruped walk", ("quadruped",)),
        ("@Quadruped, @dog2 and @quadruped", ("quadruped", "dog2")),
        ("@quadruped's turn", ("quadruped",)),
        ("(@quadruped)", ("quadruped",)),
        ("@quadruped.", ("quadruped",)),
        ("请@quadruped向前走", ("quadruped",)),
        ("bob@quadruped.com", ()),
        ("see x/@quadruped/y", ()),
        ("@quadruped/repo", ()),
        ("@quadruped@other", ()),
        ("@@quadruped", ()),
        ("é@quadruped", ()),
        ("@quadrupеd", ()),  # a Cyrillic letter
        ("@quadrupeԁ", ()),  # a Cyrillic letter at the end
        ("@quadruped\u0301", ()),
        ("@1quadruped", ()),
        ("@" + "q" * 33, ()),
        ("@q", ()),
    ],
)
def test_mentions_are_whole_ascii_handles(text: str, names: tuple[str, ...]) -> None:
    assert mentions(text) == names


@given(st.text(max_size=300))
def test_any_text_has_a_clean_visible_text(raw: str) -> None:
    text = visible_text(raw)
    assert not set(text) & set("\u200b\u202e\u2066\ufeff\r\x00")
    assert all(name == name.lower() and name.isascii() for name in mentions(text))


@given(
    st.text(
        st.sampled_from("aZé9走，。 *_`~<>&|!.,;:?'\"()-+=#/$%^{}°½²…–\u00a0\u3000\u200b\u0301\u2028@[x"), max_size=30
    )
)
@example("walk 1 m")
@example("a  b http://x.y/z  ")
def test_a_line_without_markup_reads_as_the_markdown_parser_reads_it(line: str) -> None:
    assert visible_text(line) == visible_text(f"\n{line}")  # a line feed always takes the parser


@given(
    st.lists(
        st.sampled_from([*HIDDEN, *(raw for raw, _ in SEEN), "<", "`", "[", "]", "*", "\n\n", "</div>"]), max_size=8
    )
)
def test_any_mixture_of_markup_is_read(parts: list[str]) -> None:
    assert isinstance(visible_text("".join(parts)), str)


@pytest.mark.parametrize(
    "unit",
    ["<", "[", "![", "*a ", "`", ">", "- ", "<a ", "<!--", "</", "[quote]", "<div>\n\n", "[a]: x\n", "@a", "a|", "&#"],
)
def test_hostile_repetition_stays_quick(unit: str) -> None:
    raw = (unit * MAX_CHARS)[:MAX_CHARS]
    start = time.process_time()
    mentions(visible_text(raw))
    assert time.process_time() - start < 1.0


MARKUP = [
    "<![",
    "]]>",
    "]>",
    "<!--",
    "-->",
    "<!",
    "<?",
    "&#",
    ";",
    "<",
    ">",
    "</",
    "/>",
    "div",
    "x",
    "[",
    "]",
    "`",
    "\n",
    " ",
]


@given(st.lists(st.sampled_from(MARKUP) | st.characters(), max_size=40).map("".join))
@example("hello\n\n<div>\n<![x[ y ]]>\n</div>")
def test_no_markup_makes_it_raise(text: str) -> None:
    assert isinstance(visible_text(text), str)


def test_what_follows_markup_that_cannot_be_followed_is_hidden() -> None:
    assert visible_text("hello\n\n<div>\n<![x[ y ]]>\n</div>\n\nwalk 5 m").startswith("hello")
    assert "walk" not in visible_text("hello\n\n<div>\n<![x[ y ]]>\n</div>\n\nwalk 5 m")
