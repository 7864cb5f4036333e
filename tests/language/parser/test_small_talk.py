"""Posts that command nothing are recognised: never mind, questions, the past."""

from __future__ import annotations

import pytest

from agentrob.language.addressing import addresses
from agentrob.language.parser.grammar import MAX_CHARS, parse, small_talk_of
from agentrob.language.parser.small_talk import SmallTalk
from agentrob.model import Direction, Intent, Op
from tests.language.saying import read, short

POSTS = {
    SmallTalk.CANCEL: """never mind|Never mind!|forget it|don't bother|I changed my mind|@quadruped nevermind, thanks
        |算了|不用了|算了吧""",
    SmallTalk.QUESTION: """what do you see|is there a door|do you see a cone?|who are you|你叫什么名字？
        |天气好吗？|可以吗？""",
    SmallTalk.PAST: "yesterday you walked forward 2 m|the robot moved 2 m|昨天它往前走了三米",
    SmallTalk.GREETING: "hello|Hi there!|good morning, robot|你好|@quadruped|@quadruped 早上好呀|@dog2 @quadruped",
    SmallTalk.ASSENT: "yes|Go ahead!|please|now|yes please|@quadruped come on|开始|拜托|继续",
    SmallTalk.THANKS: "thanks, good job!|谢谢|ok|@quadruped 👍|yes, thanks|sounds good",
    None: "well done @dog2, and @quadruped|@dog2 wave, @quadruped?",
}


@pytest.mark.parametrize(
    ("kind", "text"), [(k, t) for k, texts in POSTS.items() for t in texts.replace("\n        |", "|").split("|")]
)
def test_talk_is_told_apart_and_moves_nothing(kind: SmallTalk | None, text: str) -> None:
    assert small_talk_of(text, ["quadruped"], ["dog2"]) is kind
    assert read(text).intent is Intent.NOTHING


STATUS = """is your battery full?|how full is your battery|what about your battery|do you need charging?
|are you charged|how's the battery doing?|does it need a recharge|电充满了吗|你的电池满了吗|还有电吗|电够不够用
|你现在电量怎么样"""


@pytest.mark.parametrize("text", STATUS.strip().replace("\n", "").split("|"))
def test_a_question_about_the_battery_is_one_of_the_robots_state(text: str) -> None:
    assert read(text).intent is Intent.STATUS


@pytest.mark.parametrize("text", ["I charged the phone", "what is in charge of the state", "charge forward 1 m"])
def test_words_of_the_state_elsewhere_move_nothing(text: str) -> None:
    assert not read(text).plan.steps


def test_a_command_after_a_cancel_is_a_command() -> None:
    assert read("Never mind, turn left 90 degrees").intent is Intent.COMMAND
    assert small_talk_of("Never mind, turn left 90 degrees", ["quadruped"], []) is SmallTalk.CANCEL


def test_stops_and_what_is_for_others_are_no_talk() -> None:
    assert small_talk_of("stop", ["quadruped"], []) is None
    assert small_talk_of("cancel that", ["quadruped"], []) is None
    assert small_talk_of("@quadruped wave @dog2 never mind", ["quadruped"], ["dog2"]) is None
    assert small_talk_of("never mind " * MAX_CHARS, ["quadruped"], []) is None


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("前面五米是墙", []),
        ("你后面两米是沙发", []),
        ("你後邊2.5米有人站著", []),
        ("前面五米是墙。向前走三米", [3.0]),
        ("左边一米有人，向前走两米", [2.0]),
        ("前面五米是墙向后退两米", [-2.0]),
        ("现在前方三米处有障碍物，后退一米", [-1.0]),
        ("向前三米，左转90度", [3.0, None]),
        ("there is a wall five metres ahead", []),
    ],
)
def test_what_is_said_to_be_somewhere_is_no_command(text: str, metres: list[float | None]) -> None:
    plan = parse(text, ["quadruped"], [], frozenset(Op)).plan
    asked = [s.distance_m and s.distance_m * (-1 if s.direction is Direction.BACKWARD else 1) for s in plan.steps]
    assert asked == metres


@pytest.mark.parametrize(
    "text", ["前面五米是墙吗", "前面五米是墙？", "如果前面五米是墙，左转90度", "前面五米有墙的话左转90度"]
)
def test_what_is_asked_or_supposed_to_be_somewhere_moves_nothing(text: str) -> None:
    found = parse(text, ["quadruped"], [], frozenset(Op))
    assert found.intent is not Intent.COMMAND


@pytest.mark.parametrize(
    "text",
    [
        "走在你前面",
        "走在你前面一米",
        "走在您後面兩米",
        "走在你前面2米的人",
        "跑在你左边三米",
        "坐在你前面",
        "站在你前面两米",
    ],
)
def test_who_is_near_the_robot_is_no_command_although_nobody_is_named(text: str) -> None:
    assert parse(text, ["quadruped"], [], frozenset(Op)).intent is Intent.NOTHING


@pytest.mark.parametrize(
    "text",
    [
        "走在你前面。向前走1米",
        "向前走1米。走在你前面",
        "向前走5米，走在你前面2米",
        "走在你前面2米，向前走5米",
        "走在你前面，然后拍张照",
        "左转90度，走在你前面",
        "请走在你前面一米",
    ],
)
def test_a_command_beside_somebody_near_the_robot_is_asked_back(text: str) -> None:
    assert parse(text, ["quadruped"], [], frozenset(Op)).intent is Intent.ASK_BACK


@pytest.mark.parametrize("text", ["你走在前面两米", "走在前面两米", "在你前面走两米", "往你前面走两米"])
def test_a_walk_ahead_is_a_command(text: str) -> None:
    assert [s.distance_m for s in parse(text, ["quadruped"], [], frozenset(Op)).plan.steps] == [2.0]


@pytest.mark.parametrize(
    ("spoken_to", "text"),
    [
        (True, "@rex you did well"),
        (True, "Look, @rex, over there"),
        (True, "hey @rex nice work"),
        (True, "well done @rex"),
        (True, "你好 @rex"),
        (True, "@max @rex hello"),
        (False, "I like how @rex looks."),
        (False, "Yesterday I showed @rex to my class"),
        (False, "@max, wave at @rex"),
        (False, "nobody is named here"),
    ],
)
def test_who_speaks_to_a_robot_is_told_from_who_speaks_about_it(spoken_to: bool, text: str) -> None:
    assert addresses(text, ("rex",)) is spoken_to


TALK = """what's up|nice to meet you, I'm Ana|you rock|lol you're funny|long time no see!|congratulations on the release
why did the chicken cross the road? to get to the other side!|best robot ever|are we dancing at the party or what
could you theoretically carry 10 kg|where you come from?|anyone up for a walk at five?
it rained so we cancelled the walk
my G1 waves with the wrong hand|took two pictures, both fine|last night's run: four turns, eight photos, zero falls
ok admin, please lock this thread|mum can you take a picture of me and grandpa|did Ben ever return your drill?
Hey Jonas, turn your monitor a bit to the right|battery died after 40 minutes
the front left leg squeaks when it stands up
好久不见，想你了|今天天气真不错|后空翻翻得真漂亮，我儿子看了十遍|左转九十度一点不差，厉害厉害|听说新版本能后空翻了
你一次最多能走几米|转一圈要用多少电|为什么你走路会响|怎么才能当操作员|老王，你先往前走两步，我跟上|张工，麻烦把日志发我邮箱
视频里那台G1先挥手再转身，然后就卡住了|歌词里唱的是“向前走，莫回头”|会议纪要：下周测试左转和右转各五十次|同意楼上"""


@pytest.mark.parametrize("text", [text for line in TALK.splitlines() for text in line.split("|")])
def test_talk_is_told_by_its_form_and_nobody_asks_what_it_wants(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.NOTHING, understood.question
    assert not understood.plan.steps


WISHES = """i want you to sing a song|you should go to the kitchen|the box needs to be lifted|could you water the plants
can you carry this bag?|my dog is cute, go to the kitchen|nice work, now walk in a triangle|hello, bring me a beer
I'm standing well behind you, forward 2 metres|I was told not to ask for backflips, so just wave
what a day! frobnicate the wall|I'm tired, follow me
跳得真好，去厨房|今天天气真好，去厨房看看|我想让你唱歌|你真棒，帮我拿杯水|数一数屋里有几个人|去三号会议室看看灯关了没
谁举手你就走到谁跟前|听说你会唱歌，唱一首"""


@pytest.mark.parametrize("text", [text for line in WISHES.splitlines() for text in line.split("|")])
def test_a_wish_beside_talk_or_in_the_form_of_talk_is_asked_back(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


def test_praise_does_not_swallow_a_command_after_it() -> None:
    assert read("跳得真好，再来一个后空翻").intent is not Intent.NOTHING
    assert read("well done, wave again").intent is Intent.COMMAND


PRAISE = """nice wave!|Great dance|really nice stretch, thanks|wow, lovely wave there buddy|good job with the dance
|bad turn|nice walk!|excellent backflip|漂亮的挥手！|挥手不错|坐得真乖|转身真帅|好厉害的转圈|比心好可爱|哇，跳得真棒"""
#: What is asked for beside praise, or in its words.
REQUESTED_KINDLY = {
    "a nice wave please": "hello",
    "nice wave please": "hello",
    "a great big wave": "hello",
    "Nice wave! Now walk 1 m": "F1",
    "great dance, now sit": "sit",
    "terrible dance, sit": "sit",
    "nice, wave": "hello",
    "来个漂亮的挥手": "hello",
    "走得好，坐下": "sit",
    "转圈真漂亮，再转一圈": "l360",
}


@pytest.mark.parametrize("text", PRAISE.replace("\n|", "|").split("|"))
def test_law_18_praise_of_an_action_does_not_ask_for_it(text: str) -> None:
    assert read(text).intent is Intent.NOTHING


@pytest.mark.parametrize(("text", "plan"), REQUESTED_KINDLY.items())
def test_an_action_is_requested_in_kind_words_or_beside_praise(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan
