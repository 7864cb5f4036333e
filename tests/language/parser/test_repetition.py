"""Earlier motions are repeated, slower, elsewhere or back, only where the post is plain; the reply says which."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.parser.repetition import ParseContext, reversed_path
from agentrob.model import Capabilities, Direction, Intent, Limits, Op, Plan, Primitive
from tests.language.saying import read, short, turn, walk

PHOTO = Primitive(Op.GET_FRONT_IMAGE)
OLDER = Plan((walk(Direction.LEFT, 0.3),))
LAST = Plan((walk(Direction.FORWARD, 2.0), turn(Direction.LEFT, 90.0), PHOTO))
THREAD = ParseContext(history=(OLDER, LAST))

IN_A_THREAD = [
    ("again", "F2 l90 photo"),
    ("once more please", "F2 l90 photo"),
    ("again, twice", "F2 l90 photo F2 l90 photo"),
    ("the same but slower", "F2@0.2 l90 photo"),
    ("same thing at 0.4 m/s", "F2@0.4 l90 photo"),
    ("the same, but to the right", "F2 r90 photo"),
    ("the same but backwards", "B2 l90 photo"),
    ("same thing but 3 metres", "F3 l90 photo"),
    ("the same but 45 degrees", "F2 l45 photo"),
    ("do it again, then wave", "F2 l90 photo hello"),
    ("again please", "F2 l90 photo"),
    ("another!", "F2 l90 photo"),
    ("one more please", "F2 l90 photo"),
    ("and now back", "r90 B2"),
    ("now go back", "r90 B2"),
    ("come back", "r90 B2"),
    ("slowly come back", "r90 B2@0.2"),
    ("go back half a metre", "B0.5"),
    ("turn left 30 degrees again", "l30"),
    ("再来一次", "F2 l90 photo"),
    ("再来两次", "F2 l90 photo F2 l90 photo"),
    ("一样，但是慢一点", "F2@0.2 l90 photo"),
    ("现在回来", "r90 B2"),
]


FURTHER = {
    "photo photo": """take a photo, then take another photo|take a photo, then another|take a photo and take another
        |take a photo and then another one|take one photo, then one more|take a photo, and a second one
        |take a photo, then a second photo|take a photo of the door and another of the window
        |take a photo. Take it again|take a photo, then take a photo again|拍张照，再拍一张|先拍一张，再拍一张照片
        |拍张照，再拍一次|拍张照，再重拍一张""",
    "photo": """take a photo, take a photo|take a photo and then send me the photo|take a photo. Send me a picture.
        |take another photo|another photo please|拍张照片，发我一张照片|拍张照，再发张照片给我|再拍一张""",
    "hello hello": "wave, then another|wave and one more please|挥手，再来一个",
    "F1 F1": "walk forward 1 m, then another",
    "F1 F2": "walk forward 1 m, then another 2 m",
}


@pytest.mark.parametrize(
    ("plan", "text"), [(p, t) for p, texts in FURTHER.items() for t in texts.replace("\n        |", "|").split("|")]
)
def test_another_is_a_further_one_and_what_is_only_said_twice_is_done_once(plan: str, text: str) -> None:
    understood = read(text)
    assert short(understood.plan) == plan, understood.question


@pytest.mark.parametrize(
    "text",
    [
        "walk 1 m and take another",
        "walk 1 m, wave, then another",
        "take a photo, wave, then another",
        "one more",
        "再来一个",
    ],
)
def test_another_of_what_nobody_named_is_asked_back(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


@pytest.mark.parametrize(("text", "plan"), IN_A_THREAD)
def test_what_was_done_last_in_the_thread_is_meant(text: str, plan: str) -> None:
    understood = read(text, THREAD)
    assert short(understood.plan) == plan, understood.question


def test_what_is_done_again_is_told() -> None:
    (note,) = read("the same but slower", THREAD).plan.notes
    assert note == "`the same but slower`: walk forward 2 m at 0.2 m/s, then turn left 90 degrees, then take a photo."


@pytest.mark.parametrize(
    "text",
    [
        "just the turn again sweetie",
        "again but 2 m this time, dear",
        "do that once more my friend",
        "again but not the turn",
        "do it again, but don't turn",
        "再来一次，但是不要转",
        "再转一次",
        "再走一次",
    ],
)
def test_law_18_a_part_of_what_was_done_is_not_done_again_for_it(text: str) -> None:
    assert read(text, THREAD).intent is Intent.ASK_BACK


def test_one_more_turn_repeats_a_plan_that_was_nothing_else() -> None:
    turned = ParseContext(history=(Plan((turn(Direction.LEFT, 90.0),)),))
    assert short(read("再转一次", turned).plan) == "l90"
    assert read("再走一次", turned).intent is Intent.ASK_BACK


def test_of_many_steps_only_the_first_are_told() -> None:
    (note,) = read("walk 1 m and wave, do this twenty times").plan.notes
    assert note.count("walk") == 5
    assert note.endswith(" ….")


def test_slower_than_slow_is_half_as_fast() -> None:
    slow = ParseContext(history=(Plan((walk(Direction.FORWARD, 1.0, 0.3),)),))
    assert short(read("the same but slower", slow).plan) == "F1@0.15"


IN_A_POST = [
    ("walk 1 m and turn left 90 degrees, do this four times", "F1 l90 F1 l90 F1 l90 F1 l90"),
    ("walk 1 m, turn left 90 degrees, repeat that twice", "F1 l90 F1 l90"),
    ("wave and again", "hello hello"),
    ("walk 1 m and wave, repeat that 2 more times", "F1 hello F1 hello F1 hello"),
    ("前进半米，再来两次", "F0.5 F0.5 F0.5"),
    ("repeat that twice: walk 1 m", "F1 F1"),
    ("walk forward 2 m, take a photo and come back", "F2 photo B2"),
    ("walk forward 2 m and turn left 90 degrees, then return", "F2 l90 r90 B2"),
    ("前进一米，左转90度，重复四次", "F1 l90 F1 l90 F1 l90 F1 l90"),
    ("向前走两米再回来", "F2 B2"),
]


@pytest.mark.parametrize(("text", "plan"), IN_A_POST)
@pytest.mark.parametrize("background", [ParseContext(), THREAD])
def test_what_was_said_in_the_same_post_goes_first(text: str, plan: str, background: ParseContext) -> None:
    assert short(read(text, background).plan) == plan


UNCLEAR = """
do it|just do it|same|faster|the same but faster|the same a bit|again, turn left 90 degrees|walk 1 m, wave, again
come back 2 m twice|the same for two seconds|the same but 500 metres|the same at 90 m/s|照做
"""


@pytest.mark.parametrize("text", [t for line in UNCLEAR.strip().splitlines() for t in line.split("|")])
def test_what_is_not_plain_asks_back(text: str) -> None:
    assert read(text, THREAD).intent is Intent.ASK_BACK


@pytest.mark.parametrize(
    "text", ["again", "the same but slower", "come back", "go back", "and now back", "再来一次", "回来"]
)
def test_without_anything_done_before_it_asks_back(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


GREETINGS = "thanks again|hello again|here we go again|once again thank you|never again|I'm back|回来了|我回来了|再见"


@pytest.mark.parametrize("text", GREETINGS.split("|"))
def test_words_of_again_in_greetings_do_nothing(text: str) -> None:
    assert read(text, THREAD).intent is Intent.NOTHING


def test_another_action_is_that_action_alone() -> None:
    assert short(read("再来个后空翻", THREAD).plan) == "backflip"
    assert short(read("再来一张照片", THREAD).plan) == "photo"
    assert short(read("again wave", THREAD).plan) == "hello"


@pytest.mark.parametrize("text", ["don't do it again", "never come back", "did you do it again?", "不要再来一次"])
def test_what_is_denied_or_asked_is_not_done_again(text: str) -> None:
    assert read(text, THREAD).intent is not Intent.COMMAND


def test_a_side_is_changed_only_where_there_is_one() -> None:
    both = ParseContext(history=(Plan((turn(Direction.LEFT, 90.0), turn(Direction.RIGHT, 45.0))),))
    assert read("the same but to the right", both).intent is Intent.ASK_BACK
    assert read("the same but 30 degrees", both).intent is Intent.ASK_BACK


STEPS = st.one_of(
    st.builds(walk, st.sampled_from(Direction), st.floats(0.1, 5)),
    st.builds(turn, st.sampled_from([Direction.LEFT, Direction.RIGHT]), st.floats(1, 360)),
    st.just(PHOTO),
)


@given(st.lists(STEPS, max_size=6))
def test_the_way_back_of_the_way_back_is_the_way(steps: list[Primitive]) -> None:
    assert reversed_path(reversed_path(steps)) == [step for step in steps if step != PHOTO]


# ------------------------------------------------------------------ times and steps
@pytest.mark.parametrize(
    ("text", "plan"),
    [
        ("walk forward for two seconds", "F0.6@0.3"),
        ("slowly forward for 3 seconds", "F0.6@0.2"),
        ("go backward for 2 seconds at 0.4 m/s", "B0.8@0.4"),
        ("go left for half a minute", "L9@0.3"),
        ("往前走两秒", "F0.6@0.3"),
        ("前进3秒，速度0.2米每秒", "F0.6@0.2"),
    ],
)
def test_a_time_becomes_a_distance_and_says_so(text: str, plan: str) -> None:
    understood = read(text)
    assert short(understood.plan) == plan
    assert any("0." in note or "9 m" in note for note in understood.plan.notes)


def test_the_pace_of_the_robot_is_kept_to() -> None:
    assert short(read("walk for two seconds", ParseContext(pace_mps=0.1)).plan) == "F0.2@0.1"


def test_steps_are_asked_back_unless_the_robot_has_a_step() -> None:
    assert read("take two steps forward").intent is Intent.ASK_BACK
    assert short(read("take two steps forward", ParseContext(step_m=0.25)).plan) == "F0.5"
    assert short(read("往后退一步", ParseContext(step_m=0.25)).plan) == "B0.25"


def test_examples_stay_within_what_the_robot_can_do() -> None:
    small = Capabilities("x", frozenset({Op.MOVE, Op.TURN}), Limits(step_m=0.4, step_deg=30))
    question = read("walk backward", ParseContext(can=small)).question
    assert "`walk backward 0.4 m`" in question
    assert "1 m" not in question
    assert "at most 0.4 m" in read("walk 200 m", ParseContext(can=small)).question
    assert "at most 30 degrees" in read("turn left 9999 degrees", ParseContext(can=small)).question
