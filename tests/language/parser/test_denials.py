"""A motion that one post both requests and denies is asked about; one that it only denies is not made (law 18)."""

from __future__ import annotations

import pytest

from agentrob.model import Intent
from tests.language.saying import read, short

CONTRADICTED = """
walk 1 m, don't walk|walk 1 m. don't walk|walk 1 m, great, don't walk|don't walk, walk 1 m|walk 1 m but do not go
walk 1 m, don't move|walk 1 m, don't walk forward|walk 1 m, don't walk 1 m|walk 1 m, you shouldn't walk|walk 1 m, don't
walk 1 m, no don't walk|walk 1 m, please don't do it|walk 1 m and don't you dare walk|walk 1 m without walking
run 1 m, don't run|go back 1 m, don't go back|forward 1 m, don't walk|strafe left 1 m, don't strafe
turn left, don't turn left|turn left. never turn left|don't turn left, turn left|turn left 90 degrees, don't turn
left 90 degrees, don't turn|turn around, don't turn around|turn left, wave, don't turn
wave, don't wave|wave, no don't|sit, don't sit|take a photo, don't take a photo
前进一米，太好了，不要走|前进一米，别走|前进一米。别走|前进一米，不要往前走|前进一米但是不要走|不要走，走一米
前进一米，不许走|后退一米，别退|向左平移一米，不要平移|左转，不要左转|左转，别转|左转90度，不要转|不要左转，左转
掉头，不要掉头|挥手，不要挥手|挥手，别|坐下，别坐|拍照，别拍|跑一米，不要跑
"""
DENIED_BESIDES = {
    "walk 1 m, don't run": "F1",
    "don't run, walk 1 m": "F1",
    "walk 1 m, don't turn": "F1",
    "walk 1 m, don't walk backward": "F1",
    "don't walk backward, walk forward 1 m": "F1",
    "walk 1 m, don't go back": "F1",
    "walk 1 m, don't walk 2 m": "F1",
    "walk 1 m, don't go too far": "F1",
    "walk 1 m, don't walk into the wall": "F1",
    "turn left, don't turn right": "l90",
    "don't turn right, turn left": "l90",
    "turn left, don't walk": "l90",
    "turn left 90, don't turn 180": "l90",
    "前进一米，不要跑": "F1",
    "不要跑，走一米": "F1",
    "前进一米，不要后退": "F1",
    "前进一米，不要走两米": "F1",
    "走一米就好，别多走": "F1",
    "左转，不要右转": "l90",
    "左转，不要走": "l90",
    "move left 0.5 m and don't worry": "L0.5",
    "往前走一米，别介意错别字": "F1",
    "走一米，别撞到桌子": "F1",
    "左转90度，不要转180度": "l90",
}
#: Limits of a motion that the robot cannot keep to.
LIMITED = """
walk forward 2 m but do not go the whole way|turn left but don't turn past the door|walk 1 m, do not swing wide
wave but don't raise your paw all the way|turn around but never face the window|walk 1 m but don't leave the carpet
go forward 1 m, never cross the red line|wave but do not leave your spot
walk 1 m, avoid the carpet|wave but avoid the vase|walk forward 2 m, avoiding the stairs
转身，但别转到底|挥挥手，别举过头|前进两米，不要走满|前进两米，但不许踩线|左转，别转过墙角|向前一米，别出地毯
"""
ELSEWHERE = """
take a photo of the cup from above|take a photo from the other side|take a picture of the room from the corner
show me the view from the window|walk 1 m and take a photo from below
"""
#: What a camera that looks ahead does not show, and the command that is offered instead.
ASIDE = {
    "take a look to your left": "turn left 90 degrees, then take a photo",
    "have a quick look to the right": "turn right 90 degrees, then take a photo",
    "have a look behind you": "turn left 180 degrees, then take a photo",
    "take a photo of your left side": "turn left 90 degrees, then take a photo",
    "take a picture of what is behind you": "turn left 180 degrees, then take a photo",
    "walk 1 m and have a look to your left": "walk forward 1 m, then turn left 90 degrees, then take a photo",
    "turn right and take a photo of what's on your left": "turn right 90 degrees, then turn left 90 degrees, then take",
    "拍一下你身后": "向左转180度，然后拍张照",
}
IN_VIEW = {
    "have a look": "photo",
    "have a look at the door": "photo",
    "walk 1 m and take a good look at the shelf": "F1 photo",
    "take a photo of what's ahead of you": "photo",
    "take a photo of the back of the box": "photo",
    "take a picture of the people on the left side of the table": "photo",
    "turn around and take a photo of what's behind you": "l180 photo",
    "turn left and take a photo of what's on your left": "l90 photo",
    "转身拍一下你身后": "l180 photo",
}


@pytest.mark.parametrize("text", [t for line in CONTRADICTED.strip().splitlines() for t in line.split("|")])
def test_law_18_what_is_asked_for_and_denied_moves_nothing(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK, short(understood.plan)
    assert not understood.plan.steps


@pytest.mark.parametrize(("text", "plan"), DENIED_BESIDES.items())
def test_another_motion_than_the_denied_one_is_done(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan


@pytest.mark.parametrize("text", [t for line in LIMITED.strip().splitlines() for t in line.split("|")])
def test_law_18_what_is_limited_in_unknown_words_moves_nothing(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK, short(understood.plan)
    assert not understood.plan.steps
    last = text.replace(",", "，").split("，")[-1].split(" but ")[-1].removeprefix("但").strip()
    assert f"`{last}`" in understood.question, "it quotes the limit"


@pytest.mark.parametrize("text", [t for line in ELSEWHERE.strip().splitlines() for t in line.split("|")])
def test_law_18_a_photo_from_another_place_is_asked_back(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK, short(understood.plan)
    assert not understood.plan.steps


@pytest.mark.parametrize("place", ["here", "where you stand", "your camera", "this angle", "your position"])
def test_a_photo_from_where_the_robot_is_is_taken(place: str) -> None:
    assert short(read(f"take a photo from {place}").plan) == short(read("take a photo").plan)


@pytest.mark.parametrize(("text", "offer"), ASIDE.items())
def test_law_18_a_photo_of_another_side_is_asked_back_with_the_turn_before_it(text: str, offer: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK, short(understood.plan)
    assert f"`{offer}" in understood.question


@pytest.mark.parametrize(("text", "plan"), IN_VIEW.items())
def test_a_photo_of_what_the_robot_faces_is_taken(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan
