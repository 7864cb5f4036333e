"""Posts that ask for a preview, and posts that only speak of one."""

from __future__ import annotations

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.config.robots import RobotConfig
from agentrob.language.addressing import part_for
from agentrob.language.previews.reading import asking_for_preview, rehearsed_part, rehearsed_text, speaks_of_preview
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import Intent
from agentrob.robots.unitree.go2 import Go2
from agentrob.wiring.plan import plan_text


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("preview walk 3 m and turn left", "walk 3 m and turn left"),
        ("Preview: walk 3 m", "walk 3 m"),
        ("please preview walk 2 m", "walk 2 m"),
        ("can you preview turn left?", "turn left"),
        ("rehearse: wave", "wave"),
        ("dry run: walk 1 m", "walk 1 m"),
        ("do a dry run of walk 2 m", "walk 2 m"),
        ("preview of walk 1 m", "walk 1 m"),
        ("show me first: walk 3 m", "walk 3 m"),
        ("show me first what happens if you walk 3 m", "walk 3 m"),
        ("walk 3 m, but show me first", "walk 3 m"),
        ("walk 3 m. Show me first!", "walk 3 m"),
        ("walk 3 m but only preview it", "walk 3 m"),
        ("walk 1 m as a preview", "walk 1 m"),
        ("walk 1 m in the simulator", "walk 1 m"),
        ("preview", ""),
        ("预演 向前走三米", "向前走三米"),
        ("先预演一下向前走三米", "向前走三米"),
        ("请先预演向前走2米，然后左转", "向前走2米，然后左转"),
        ("先演示挥手", "挥手"),
        ("先给我看看向前走三米", "向前走三米"),
        ("向前走三米，先演示一下", "向前走三米"),
        ("向前走三米，但是先给我看看", "向前走三米"),
        ("向前走三米 预演", "向前走三米"),
        ("模拟挥手", "挥手"),
    ],
)
def test_a_preview_is_split_from_its_command(text: str, command: str) -> None:
    assert rehearsed_text(text) == command


@pytest.mark.parametrize(
    "text", ["walk 3 m", "take a photo", "show me your tricks", "向前走三米", "演示挥手", "给我看看"]
)
def test_other_posts_ask_for_no_preview(text: str) -> None:
    assert rehearsed_text(text) is None
    assert not speaks_of_preview(text, text)


@pytest.mark.parametrize(
    "text",
    ["previews are great, walk 1 m", "don't preview, walk 1 m", "show it to me first, walk 1 m", "walk, 然后预演左转"],
)
def test_what_speaks_of_a_preview_and_is_none_is_noticed(text: str) -> None:
    assert rehearsed_text(text) is None
    assert speaks_of_preview(text, text)


def test_words_before_the_first_mention_count() -> None:
    assert speaks_of_preview("walk 1 m", "preview: @quadruped walk 1 m. @humanoid wave")
    assert not speaks_of_preview("walk 1 m", "@quadruped walk 1 m. @humanoid preview wave")


@given(
    st.sampled_from(["preview", "rehearse", "simulate", "dry run", "预演", "模拟"]),
    st.text(max_size=40),
    st.text(max_size=40),
)
def test_words_of_a_preview_are_never_overlooked(word: str, before: str, behind: str) -> None:
    text = f"{before} {word} {behind}"
    assert rehearsed_text(text) is not None or speaks_of_preview(text, text)


@pytest.mark.parametrize(
    "text", ["@quadruped walk 1 m", "@quadruped 向前走一米", "1. @quadruped walk 1 m\n2. wave", "@a wave. @b sit"]
)
def test_a_request_in_front_asks_every_robot_for_a_preview(text: str) -> None:
    asked = asking_for_preview(text)
    assert asked.endswith(text)
    for name, others in (("quadruped", ()), ("a", ("b",)), ("b", ("a",))):
        if f"@{name} " in text:
            assert rehearsed_part(part_for(asked, (name,), others), asked)
    assert asking_for_preview(asked) == asked


@pytest.mark.parametrize("text", ["walk 3 m, but show me first", "walk 3 m. show me first", "向前走三米，先演示一下"])
def test_law_18_who_cannot_preview_does_not_move_for_a_preview(text: str) -> None:
    addressee = Addressee(("go2",), (), Go2.describe(RobotConfig(simulated=True)))
    understood = asyncio.run(RulesMind().understand(text, addressee))
    assert understood.intent is Intent.ASK_BACK
    assert plan_text(text, "go2")["intent"] == "preview"
