"""Posts in which one robot waits for another: which parts they have, and which posts are asked about (law 18)."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.joint.parts import Choice, JointCommand, JointPart, cycle_of, depth_of
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.model import Plan
from tests.language.saying import short


def written(text: str) -> str:
    """The reading of a post: "1 rex F1; 2 bot hello after 1", "ask" or "none"."""
    found = joint_command(text)
    if not isinstance(found, JointCommand):
        return "none" if found is None else "ask"
    return "; ".join(_written(part) for part in found.parts)


def _written(part: JointPart) -> str:
    after = f" after {' '.join(map(str, part.after))}" if part.after else ""
    choice = f" {part.choice}" if part.choice is not Choice.NAMED else ""
    choice += f" to {part.near}" if part.near else ""
    return f"{part.number} {'|'.join(part.robots)}{choice} {short(part.plan)}{after}"


THEN = "1 rex F1; 2 bot hello after 1"
BOTH = "1 rex F1; 2 bot l90; 3 rex hello after 1 2; 4 bot hello after 1 2"
READ = {
    "@rex walk 1 m, then @bot wave": THEN,
    "hi, @rex walk 1 m, then have @bot wave please": THEN,
    "@rex walk 1 m. When it's done, @bot wave": THEN,
    "@rex walk 1 m and when it is done @bot wave": THEN,
    "@rex walk 1 m; once that is done @bot wave": THEN,
    "@rex walk 1 m and once it has finished, let @bot wave": THEN,
    "@rex walk 1 m. When @rex is done, @bot wave": THEN,
    "@rex walk 1 m. After that, @bot should wave.": THEN,
    "@rex walk 1 m. @bot wave after that.": THEN,
    "@rex walk 1 m first, then @bot wave": THEN,
    "@rex first walk 1 m, then @bot wave": THEN,
    "@rex walk 1 m, @bot then wave": THEN,
    "@rex 前进1米，然后 @bot 挥手": THEN,
    "@rex 前进1米，等它走完再让 @bot 挥手": THEN,
    "@rex前进1米，等@rex走完，@bot再挥手": THEN,
    "@rex 前进1米，@bot 等 @rex 走完再挥手": THEN,
    "@rex 先前进1米，再让@bot挥手": THEN,
    "@rex 前进1米，走完后@bot挥手": THEN,
    "@bot wave when @rex is done. @rex walk 1 m.": "1 bot hello after 2; 2 rex F1",
    "@rex walk 1 m. Meanwhile @bot turn left 90. Then both of you wave.": BOTH,
    "@rex walk 1 m and at the same time @bot turn left 90. After that both of you wave": BOTH,
    "@rex walk 1 m. @bot turn left 90. When both are done, both of you wave.": BOTH,
    "@rex 前进1米，同时 @bot 左转90度，然后你们俩都挥手": BOTH,
    "@rex walk 1 m and @bot wave at the same time": "1 rex F1; 2 bot hello",
    "@rex walk 1 m, then @bot wave, then @cat sit": "1 rex F1; 2 bot hello after 1; 3 cat sit after 2",
    "@rex walk 1 m, then @bot wave, meanwhile @cat sit, then @rex stretch": "1 rex F1; 2 bot hello after 1; "
    "3 cat sit after 1; 4 rex stretch after 2 3",
    "@rex walk 1 m, then @bot wave, then @rex sit": "1 rex F1; 2 bot hello after 1; 3 rex sit after 2",
    "@rex 前进1米，等它走完让@bot挥手，等它挥完再让@cat坐下": "1 rex F1; 2 bot hello after 1; 3 cat sit after 2",
    "@rex and @bot, one of you wave": "1 rex|bot any hello",
    "@rex or @bot wave": "1 rex|bot any hello",
    "@rex @bot whoever is free, take a photo": "1 rex|bot free photo",
    "@rex @bot: whoever is nearer take a photo": "1 rex|bot nearest photo",
    "@rex @bot whoever is nearer to the red ball, take a photo": "1 rex|bot nearest to red ball photo",
    "@rex @bot: the one closest to the door: wave": "1 rex|bot nearest to door hello",
    "@rex walk 1 m. @bot wave. Then whichever robot is closer to the table, wave": "1 rex F1; 2 bot hello; "
    "3 rex|bot nearest to table hello after 1 2",
    "@rex @bot 谁离门近谁去拍照": "1 rex|bot nearest to 门 photo",
    "@rex @bot 离红色的球最近的那个挥手": "1 rex|bot nearest to 红色的球 hello",
    "@rex @bot whoever is nearer to the door wave": "ask",  # who knows whether the door is a "door wave"?
    "@rex walk 1 m, then @bot or @cat wave": "1 rex F1; 2 bot|cat any hello after 1",
    "@rex @bot 你们谁有空谁挥手": "1 rex|bot free hello",
    "@rex @bot 谁离得近谁去拍照": "1 rex|bot nearest photo",
    "@rex和@bot你们中的一个挥手": "1 rex|bot any hello",
    # each at once, as before
    "@rex walk 1 m. @bot turn left 90 degrees and wave.": "none",
    "@rex and @bot wave": "none",
    "@rex @bot both of you walk 1 m": "none",
    "@rex walk 1 m, then turn left": "none",
    "@rex walk 1 m to @bot": "none",
}
ASKED = (
    "when @rex is done, @bot wave",  # done with what?
    "then @rex wave, @bot sit",
    "@bot wave after @rex has finished, @rex walk 1 m.",  # a comma on both sides
    "@rex walk 1 m. @bot wave when @rex is done, @cat sit.",
    "@rex walk 1 m, @bot turn left, when it is done, @cat sit.",
    "@rex walk 1 m, then @bot wave when it is done, @cat sit",
    "@rex walk 1 m, then @bot wave. @cat sit",  # at once, or at the end?
    "@rex wave to her and @bot then sit",
    "@rex walk 1 m, then @bot fly to the moon",
    "@rex walk 1 m, then @bot wave when the door opens",
    "@rex walk 1 m if the light is green, then @bot wave",
    "@rex walk 1 m, then @bot",
    "@rex walk 1 m, then @bot do it again",  # nobody else knows what was done before
    "@rex walk two steps, then @bot wave",  # nor how long a step is
    "@rex tomorrow at 9 walk 1 m, then @bot wave",
    "@rex walk 1 m, then @bot don't wave",
    "the floor is wet. @rex walk 1 m, then @bot wave",
    "@rex @bot @cat walk 1 m, then both of you wave",  # of three
    "@rex walk 1 m, meanwhile then @bot wave",
    "@rex walk 1 m. Meanwhile @rex wave. Then @bot sit",
    "@rex 前进1米，然后 @bot 飞起来",
    "@rex preview walk 1 m, then @bot wave",
    "preview: @rex walk 1 m, then @bot wave",
    "@rex walk 1 m, then @bot wave, but show me first",
    "@rex 前进1米，然后 @bot 挥手，先预演一下",
    "等@rex走完，@bot挥手",
)


@pytest.mark.parametrize(("text", "parts"), READ.items())
def test_a_post_to_several_robots_is_split_into_parts(text: str, parts: str) -> None:
    assert written(text) == parts


@pytest.mark.parametrize("text", ASKED)
def test_law_18_what_is_not_certain_is_asked_about(text: str) -> None:
    assert written(text) == "ask"


def _question(text: str) -> str:
    found = joint_command(text)
    assert isinstance(found, JointProblem)
    return f"{found.question} {found.example}"


def test_a_circle_is_refused_by_name() -> None:
    question = _question("@rex walk 1 m when @bot is done. @bot wave when @rex is done.")
    assert "in a circle: `rex` (`walk 1 m`) → `bot` (`wave`) → `rex` (`walk 1 m`)." in question
    assert "in a circle: `rex`" in _question("@rex wave when @rex is done. @bot sit.")


def test_five_parts_and_three_levels_are_the_most() -> None:
    six = "@rex @bot @cat @dan @eve walk 1 m, then @rex wave"
    assert "This has 6 parts." in _question(six)
    assert "Here 4 parts follow one another, and at most 3 can." in _question(
        "@rex walk 1 m, then @bot wave, then @cat sit, then @rex stretch"
    )


def test_a_question_names_what_is_not_understood_and_gives_an_example() -> None:
    question = _question("@rex walk 1 m, then @bot fly to the moon")
    assert "the part of `bot`, `fly to the moon`" in question
    assert "`@rex walk forward 1 m, then @bot wave`" in question
    assert "`@rex 前进1米，然后 @bot 挥手`" in _question("@rex 前进1米，然后 @bot 飞起来")
    assert "asks nothing of it" in _question("when @rex is done, @bot wave")


def test_the_example_of_a_question_is_understood() -> None:
    assert written("@rex walk forward 1 m, then @bot wave") == THEN
    assert written("@rex 前进1米，然后 @bot 挥手") == THEN


def test_times_grow_with_what_is_waited_for() -> None:
    found = joint_command("@rex walk 1 m, then @bot wave, then @cat sit")
    assert isinstance(found, JointCommand)
    assert found.seconds_before(1) == 0.0
    assert found.part(1).seconds > 60.0
    assert found.seconds_before(3) == pytest.approx(found.part(1).seconds + found.part(2).seconds)
    assert found.seconds == pytest.approx(sum(part.seconds for part in found.parts))


# -------------------------------------------------------------------- properties
ROBOTS = ("rex", "bot", "cat")
ACTIONS = {
    "walk forward 1 m": "F1", "turn left 90 degrees": "l90", "wave": "hello", "sit down": "sit",
    "walk back 0.5 m and wave": "B0.5 hello", "take a photo": "photo",
}  # fmt: skip
ACTIONS_ZH = {"前进1米": "F1", "左转90度": "l90", "挥手": "hello", "坐下": "sit", "拍照": "photo"}
THENS = (", then ", ". Then ", ". After that, ", "; when it is done, ", ", and then ", ". Once it has finished, let ")
THENS_ZH = ("，然后", "。接着让", "，等它走完再让", "，之后请")


@st.composite
def chains(draw: st.DrawFn) -> tuple[str, str]:
    """A post of two or three parts, one after the other, and what is to be read of it."""
    chinese = draw(st.booleans())
    actions, thens = (ACTIONS_ZH, THENS_ZH) if chinese else (ACTIONS, THENS)
    said = draw(st.lists(st.tuples(st.sampled_from(ROBOTS), st.sampled_from(sorted(actions))), min_size=2, max_size=3))
    text, parts = "", []
    for number, (robot, action) in enumerate(said, 1):
        text += (draw(st.sampled_from(thens)) if number > 1 else "") + f"@{robot} {action}"
        after = f" after {number - 1}" if number > 1 else ""
        parts.append(f"{number} {robot} {actions[action]}{after}")
    one = len({robot for robot, _ in said}) == 1
    return text, "none" if one else "; ".join(parts)


@given(chains())
def test_law_18_a_chain_is_read_as_it_was_written_or_asked_about(chain: tuple[str, str]) -> None:
    text, parts = chain
    assert written(text) in (parts, "ask"), text


@given(st.lists(st.sampled_from([
    "@rex", "@bot", "@cat", "walk 1 m", "wave", "then", "when", "is done", "it", "both of you", "one of you", ",", ".",
    "meanwhile", "or", "and", "first", "等", "走完", "再", "让", "然后", "同时", "你们俩", "挥手", "谁有空谁",
]), max_size=14))  # fmt: skip
def test_whatever_is_posted_the_parts_have_no_circle_and_stay_within_the_limits(words: list[str]) -> None:
    found = joint_command(" ".join(words))
    if isinstance(found, JointCommand):
        assert 1 <= len(found.parts) <= 5
        assert depth_of(found.parts) <= 3
        assert not cycle_of(found.parts)
        assert all(part.plan.steps for part in found.parts)


def test_a_circle_of_three_is_found() -> None:
    parts = [JointPart(n, (f"r{n}",), Plan(), "", (n % 3 + 1,)) for n in (1, 2, 3)]
    assert len(cycle_of(parts)) == 3
    assert all(b.number in a.after or a.number in b.after for a, b in pairwise(cycle_of(parts)))
