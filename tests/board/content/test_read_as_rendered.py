"""A robot reads exactly the mentions and the text that the board renders (law 3)."""

from __future__ import annotations

import re
from html import unescape

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from agentrob.board.content.markdown import render
from agentrob.language.parser.grammar import parse
from agentrob.language.visible_text import OMITTED, mentions, visible_text
from agentrob.model import Intent, Op

ACCOUNTS = frozenset({"quad", "quadruped", "dog2"})
_PIECES = (
    "@quadruped",
    "@quad",
    "＠quadruped",
    "＠ｑｕａｄ",
    "@dog2",
    "@",
    "quad",
    "ruped",
    "**",
    "*",
    "_",
    "\u200b",
    "\u200d",
    "\u202e",
    "\u2066",
    "\u00ad",
    "&#8203;",
    "&#x202e;",
    "&#64;quad",
    "é",
    "前",
    "http://a.b/@quad",
    "[@quad](/x)",
    "[quad]",
    "(",
    ")",
    ".",
    "/",
    "`@quad`",
    "~~@quad~~",
    "> @quad\n\n",
    "# @quad\n\n",
    "|",
    " ",
    " ",
    " ",
    "\n",
    "\n\n",
    "- ",
    "walk",
    "93",
    "-",
    "_",
    "'s",
    "!",
    "![@quad](/images/1.png)",
    "<https://a.b/@quad>",
    "\\",
    "😀",
    "@𝐪𝐮𝐚𝐝",
    "½",
    "²",
)


def linked(html: str) -> set[str]:
    return set(re.findall(r'<a href="/u/([^"]+)" class="mention"', html))


@settings(max_examples=400)
@given(st.lists(st.sampled_from(_PIECES), max_size=12).map("".join))
@example("@quadruped²")
@example("@quadruped- walk")
@example("@quad-**ruped**")
@example("@quadruped.~~@quad~~quad")
@example("@quadruped/**quad**")
@example("@quadruped:**93**")
@example("＠ｑｕ\u200dａｄ")
@example("é＠ｑｕａｄ\u200d＠ｑｕａｄ")
def test_law_3_a_robot_reads_exactly_the_mentions_that_the_board_links(raw: str) -> None:
    read = {name for name in mentions(visible_text(raw)) if name in ACCOUNTS}
    shown = linked(render(raw, ACCOUNTS.__contains__))
    assert read <= shown, raw
    if "<" not in raw:  # what looks like HTML is shown as typed, and is not read
        assert read == shown, raw


@settings(max_examples=300)
@given(st.lists(st.sampled_from(["walk", "93", "39", " ", "m", "\u202e", "\u202c", "\u2066", "\u2069", "\u200f",
       "&#x202e;", "&#8237;", "\u061c", "前进", "é", "**", "*", "."]), max_size=12).map("".join))  # fmt: skip
def test_law_3_text_is_read_as_rendered(words: str) -> None:
    raw = f"say {words}"
    page = unescape(re.sub(r"<[^>]*>", "", render(raw, lambda _: False)))
    assert not set(page) & set("\u202e\u202d\u202c\u2066\u2069\u200f\u061c\u200b")
    shown = " ".join(page.split())
    assert (
        " ".join(visible_text(raw).replace(OMITTED, "").split()) == shown
        or "e\u0301" in raw
        or page.startswith(("* ", "- "))
    )


@pytest.mark.parametrize(
    ("raw", "name"),
    [
        ("@quad**rup**ed walk 1 m", "quadruped"),
        ("**@quad**ruped walk 1 m", "quadruped"),
        ("@quad[ruped](/x) walk 1 m", "quadruped"),
        ("[@quadruped](/x) walk 1 m", "quadruped"),
        ("https://a.b/?@quadruped walk 1 m", "quadruped"),
        ("@quadruped- walk 1 m", "quadruped"),
        ("@quadruped-", "quadruped"),
        ("@quadruped_ walk 1 m", "quadruped"),
        ("＠quadruped－ walk 1 m", "quadruped"),
        ("@quad-**ruped** walk 1 m", "quad-ruped"),
        ("@quadruped-/etc walk 1 m", "quadruped"),
        ("@quadruped-é walk 1 m", "quadruped"),
    ],
)
def test_law_3_a_name_that_is_not_linked_is_not_a_mention(raw: str, name: str) -> None:
    assert name not in linked(render(raw, ACCOUNTS.__contains__))
    assert name not in mentions(visible_text(raw))


@pytest.mark.parametrize(
    "raw",
    [
        "@quad\u200bruped walk 1 m",
        "＠ｑｕａｄｒｕｐｅｄ walk 1 m",
        "@𝐪𝐮𝐚𝐝𝐫𝐮𝐩𝐞𝐝 walk 1 m",
        "@quadrupe\u217e walk 1 m",
        "@quad&#8203;ruped walk",
        "**@quadruped** go",
    ],
)
def test_law_3_every_mention_that_a_robot_reads_is_linked(raw: str) -> None:
    assert linked(render(raw, ACCOUNTS.__contains__)) == {"quadruped"}
    assert mentions(visible_text(raw)) == ("quadruped",)


def test_law_3_link_text_is_not_a_command_and_leaves_a_placeholder() -> None:
    assert visible_text("@quadruped [walk 5 m](https://example.org)") == f"@quadruped {OMITTED}"
    assert "5" not in visible_text("@quadruped walk [5](/x) m")


def test_digits_after_a_direction_override_are_shown_in_reading_order() -> None:
    raw = "@quadruped turn \u202e93\u202c degrees"
    assert "turn 93 degrees" in render(raw, lambda _: False)
    # Other forums show 39; on all of them the mark at the end makes a robot ask back.
    assert visible_text(raw) == f"@quadruped turn 93 degrees {OMITTED}"

    def intent(text: str) -> Intent:
        return parse(visible_text(text), ("quad",), (), frozenset(Op)).intent

    assert intent("@quad turn left 90 degrees") is Intent.COMMAND
    for turned in ("@quad turn left \u202e09\u202c degrees", "@quad turn left &#8238;09&#8236; degrees"):
        assert intent(turned) is Intent.ASK_BACK
