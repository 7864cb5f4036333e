"""Words that people use every day, one of each kind: what is done, and what is asked about."""

from __future__ import annotations

import pytest

from agentrob.language.parser.grammar import talk_topic_of
from agentrob.model import Intent
from tests.language.saying import read, short

#: A post, and its plan; "?" is a question, and nothing moves.
POSTS = """
three times: forward 1 m, wave=F1 hello F1 hello F1 hello
walk 1 m so i can see better and turn left=?
turn left and show me what u see=l90 photo
turn left thirty degrees so i can see better and send me a picture=?
walk forward 1 metre and tell me the temperature=?
patrol the room and report=?
往前走一米，给他挥挥手=F1 hello
take a photo of every door=?
take a picture of each window=?
backflip. again! backflip!=?
backflip again backflip=?
turn left, take a photo, left 45 degrees=?
turn left, wave, 45 degrees left=?
take a photo, don't take a photo=?
rotate a third of a turn to the left=l120
turn right by an eighth of a turn=r45
turn to nine o'clock and take a picture=l90 photo
face six o'clock=l180
turn ccw 30 deg then go 1 m=l30 F1
move forward five feet uh five feet and take a picture=F1.524 photo
take a pic then turn ninety degrees clockwise then take another=photo r90 photo
why not turn left 90 degrees=l90
any way you could turn right 20 degrees?=r20
step back 50 cm to give them space=B0.5
first time trying this, wave please=hello
greetings from berlin, wave=hello
转圈，转两圈=?
1. 坐下 2. 站起来=sit stand
1. sit 2. stand up=sit stand
sit 2. stand up=sit stand
turn left 2. wave=?
wave at me 2. rotate right by 15 degrees first. sit last=?
麻烦让它后退二十厘米=B0.2
我刚让它左转九十度，它转了八十七度=
前行一米，前行完毕后右转90度=F1 r90
turn 30deg L, photo, 60deg R=l30 photo r60
could the robot turn left 30 degrees=l30
前进一米，别忘了拍照=F1 photo
挥手给大家看看坐下=?
forward 2 m slowly, the cat is in another room=F2@0.2
step back 1 m so that nobody trips=B1
往前走一米，前面没有人=F1
keep obstacle avoidance on and walk 1 m=F1
it's no fun okay um move forward three feet=F0.9144
拍一张房间的照片=photo
向老人挥挥手=hello
我是管理员，往前走半米=?
pull forward=?
begin moving=?
begin moving forward 1 m=F1
turn left at an angle of ninety degrees=l90
5 feet forward, 90 left, 2 feet forward=F1.524 l90 F0.6096
a quarter left=l90
one more foot=F0.3048
turn left, when you're done turning take a picture=l90 photo
walk 1 m, come back to where you started=F1 B1
move maybe two feet forward=F0.6096
往前走一米左右=F1
试试往前走一米=F1
let's see you sit and get up again=sit stand
底盘前进一米=F1
小车左转=l90
往前走一米后停下=F1
左右各转30度=l30 r30
往左边走一米=L1
掉头=l180
向左横移30厘米=L0.3
伸个懒腰=stretch
做三次挥手=hello hello hello
以默认速度前进一米=F1
原地转个360度给大家看看=l360
don't move, just take a photo=photo
good job! wave=hello
every day at 9 wave=?
go to the red ball=?
走到水果前=?
左转九十度一点不差=l90
照着我的动作做一遍=?
no more than 1 m forward, then a picture=?
walk 2 m, turn around and come back=?
sit, you're making the camera shake=?
walk 1 m, i mixed up left and right, turn left=?
走两米，往后，我刚说反了，往前走两米=?
只转身不走路，向右转一百二十度=?
只拍照不走动=photo
多谢多谢，拍的照片我收到了=?
往前走两米然后掉头回来=?
走两米，前面没有人完麻烦你后退一米五=?
step back 1 m, and when that is done frobnicate=?
after you turn left, and show me what you see, left forty five degrees=?
after you make sure you make a heart four times, um turn right=?
重复三次：让我看看你坐下的同时伸个懒腰=?
"""
TALK = {
    "good dog": "praise",
    "who are you": "who",
    "what do you see": "see",
    "tell me a joke": "joke",
    "你是谁": "who",
    "你看到了什么": "see",
    "讲个笑话": "joke",
}


@pytest.mark.parametrize(("text", "plan"), [row.rsplit("=", 1) for row in POSTS.strip().splitlines()])
def test_law_18_what_people_say_every_day_is_done_or_asked_about(text: str, plan: str) -> None:
    understood = read(text)
    if plan == "?":
        assert understood.intent is Intent.ASK_BACK
        assert not understood.plan.steps
    else:
        assert short(understood.plan) == plan, understood.question


@pytest.mark.parametrize(("text", "topic"), TALK.items())
def test_small_talk_has_a_topic_and_moves_nothing(text: str, topic: str) -> None:
    assert talk_topic_of(text, ["quadruped"], []) == topic
    assert not read(text).plan.steps


def test_a_question_offers_nothing_that_was_not_said() -> None:
    assert "turn left 9" not in read("every day at 9 wave").question


@pytest.mark.parametrize(
    "text", ["如何预防碰撞", "hello", "thanks", "你好", "谢谢", "let me know when someone comes in"]
)
def test_talk_is_not_asked_about(text: str) -> None:
    assert read(text).intent is Intent.NOTHING
