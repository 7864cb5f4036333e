"""A harmless remark beside a command passes the screen; one about the floor, a load or sleeping people is asked
back."""

from __future__ import annotations

import pytest

from agentrob.language.registry import language_of
from agentrob.model import Decision, Direction, Op, Plan, Primitive, Verdict
from agentrob.screening.text.described_hazards import hazard_in_path
from agentrob.screening.text.elsewhere import masked
from agentrob.screening.text.side_remarks import RULE, doubtful_remark

PLAN = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),))


def rule_of(remark: str) -> str | None:
    """Return the rule that objects to walking one metre beside this remark."""
    language = language_of(remark)
    text = f"{remark}，往前走一米" if language == "zh" else f"{remark}, walk forward 1 m"
    verdict = hazard_in_path(text, PLAN, language) or doubtful_remark(text, PLAN, language)
    return verdict.rule if verdict else None


@pytest.mark.parametrize(
    "remark",
    [
        "nobody is behind you",
        "the way is clear",
        "后面没人",
        "the cat is in another room",
        "keep obstacle avoidance on",
        "nobody is in the hallway",
        "there is no one around",
        "the stairs are closed",
        "the stairs are on the other side of the building",
        "the puddle has been mopped up",
        "my kids are at school",
        "my cat loves you",
        "my flatmate ate my yoghurt",
        "我跟男朋友异地三年",
        "this is for the physics class",
        "the tea is ready",
        "my students are watching the stream right now",
        "my colleagues are following along",
        "to each their own",
        "he's my grandson",
        "我就是来看狗的",
        "I had pizza for lunch",
        "没人没车",
        "楼梯在另一头",
        "爸爸上班去了",
        "障碍物都挪开啦",
        "楼梯口装了门而且锁着",
        "机器狗真可爱",
        "加油",
        "我想发朋友圈",
        "给大家看看",
        "给同学们瞧瞧",
        "让观众朋友们见识一下",
    ],
)
def test_a_harmless_remark_passes(remark: str) -> None:
    assert rule_of(remark) is None


@pytest.mark.parametrize(
    "remark",
    [
        "there's a step",
        "there is no space",
        "it's narrow",
        "it will break",
        "I'm standing there",
        "you are limping",
        "you're low on battery",
        "because one leg is broken",
        "因为你好像不稳",
        "a pot of soup is on your back",
        "there is a hot pot of soup on your back",
        "my phone is on your head",
        "you are carrying a glass of wine",
        "you are still plugged in",
        "the cable is wrapped around your legs",
        "your left leg looks broken",
        "the floor was just mopped",
        "there is oil on the floor",
        "the tiles are slick",
        "the baby is asleep on the rug",
        "grandma is napping",
        "there's a boiling kettle on the floor",
        "my brother is doing handstands",
        "our neighbour is carrying a mirror through",
        "my dad dropped his plates",
        "they have no idea",
        "I hope she trips",
        "I put a glass there",
        "there is a step down after one metre",
        "我会按住他",
        "孩子们把玩具扔得到处都是",
        "sneak up on her",
        "tickle him",
        "prove her wrong lol",
        "while the kettle boils",
        "绊他一下",
        "她不想入镜",
        "@quadruped她在睡觉",
        # These only resemble reassurances.
        "nobody is holding the ladder",
        "the dog is upstairs and the floor is wet",
        "the operator is at lunch",
        "the fire exit is locked",
        "the stop button is locked",
        "there is no railing here",
        "my grandma hates it when you scare her",
        "他们在给大家看看",
        "给大家看看，她睡着了",
        "你背上放着一杯水",
        "我的手机在你头上",
        "你还插着电",
        "你的前腿好像松了",
        "地板刚拖过",
        "地上有油",
        "宝宝在睡觉",
        "没人扶着梯子",
        "没有护栏",
        "保安不在",
        "管理员出门了",
    ],
)
def test_a_remark_that_may_change_the_danger_is_asked_about(remark: str) -> None:
    assert rule_of(remark) == RULE


# ---------------------------------------------------------------------- the parts of a post
def verdict_of(text: str, plan: Plan = PLAN) -> Verdict | None:
    return doubtful_remark(text, plan, language_of(text))


def test_a_question_repeats_the_clause_that_it_is_about_in_the_language_of_the_post() -> None:
    english, chinese = (
        verdict_of("walk forward 1 m. The floor is wet. Thanks!"),
        verdict_of("往前走一米。地上有油。谢谢"),
    )
    assert english is not None
    assert chinese is not None
    assert (english.decision, chinese.decision) == (Decision.ASK_BACK, Decision.ASK_BACK)
    assert "`the floor is wet`" in english.reason
    assert "地上有油" in chinese.reason
    assert "motion" not in chinese.reason


def test_beside_gestures_that_can_harm_nobody_nothing_is_asked() -> None:
    hello = Primitive(Op.HELLO)
    assert verdict_of("the floor is wet, wave", Plan((hello, Primitive(Op.CLAP)))) is None
    assert verdict_of("the floor is wet, wave and walk", Plan((hello, *PLAN.steps))) is not None
    assert verdict_of("they have no idea, take a photo", Plan((Primitive(Op.GET_FRONT_IMAGE),))) is not None


@pytest.mark.parametrize(
    "text",
    [
        "walk to the man",  # commands
        "wave to the woman",  # actions: other rules check whom they name
        "take a photo of the children",
        "say hello to her",
        "don't hit anybody",  # care
        "be careful with the cat",
        "so that nobody trips",
        "小心别踩到猫",
        "跟她打招呼",
        "stop at the edge of the carpet",  # a safe edge
        "a child is behind you",  # has a place: the path is checked
        "I'm your neighbour",  # an introduction
        "good boy",  # praise
        "my wife says hi",
    ],
)
def test_commands_actions_care_and_introductions_are_no_remarks(text: str) -> None:
    assert verdict_of(f"{text}, walk forward 1 m") is None


def test_a_long_clause_about_others_is_asked_about_however_harmless_it_begins() -> None:
    assert verdict_of("walk forward 1 m. I would like sunny weather " + "very " * 50) is None
    remark = "to annoy my sister"
    assert verdict_of(f"walk forward 1 m. {remark}") is None
    assert verdict_of(f"walk forward 1 m. {remark}" + " again" * 35) is not None


@pytest.mark.parametrize(
    ("elsewhere", "remains"),
    [
        ("the cat is upstairs", " "),
        ("the cat is upstairs today", " "),
        ("nobody is here", " "),
        ("the puddle has been mopped up now", " "),
        ("nobody is holding the ladder", "nobody is holding the ladder"),
        ("the cat is upstairs and asleep", "the cat is upstairs and asleep"),
        ("没有人", " "),
        ("没有人看着", "没有人看着"),
    ],
)
def test_what_is_elsewhere_is_masked_and_the_rest_of_the_clause_stays(elsewhere: str, remains: str) -> None:
    assert masked(elsewhere) == remains


AT_THE_ROBOT = """
I'm holding your leg|I am touching you|I'm leaning on you|we're sitting on you|I'm standing next to you
I'm kneeling beside you|I'm about to step over the robot|we walk behind you
I'm still fixing your leg|I'm working on your motor|I'm carrying you|I've got you in my arms|we are standing around you
I tied a rope to you|I tied you up|I chained you to the radiator|I unscrewed your leg|I removed your battery cover
it is under you|the rope is tied to your leg|something is stuck between your legs|I smell gas
I'm coming to you|we are running towards you|I'm crossing in front of you|you're upside down
我正在修你|我在给你换电池|我给你系了根绳子|我向你走过去|我扶着你
"""
AT_ITS_FEET = """
I dropped my phone in front of you|I lost my ring on the floor|there are cables everywhere
the kids left their shoes all over the hallway|some screws are lying around|there's lego all over the floor
地上全是乐高|地上都是线|小心我的脚|停止按钮坏了|你的摄像头被挡住了|我蒙住了你的眼睛|灯关了|我看不见你|我们在船上
"""
NOT_AT_THE_ROBOT = """
I'm proud of you|I'm filming you|I'm looking at you|I'm waiting for you|I'm with you|I'm at home|I'm in bed with a cold
I'm sitting on the sofa watching you|I'm holding my coffee and watching you|I'm standing in line at the bakery
I dropped my ice cream today|I left my umbrella at work|there are robots everywhere these days
我看着你|我在家|我在拍你|我为你骄傲
"""


@pytest.mark.parametrize("remark", [r for line in AT_THE_ROBOT.strip().splitlines() for r in line.split("|")])
def test_law_7_it_does_not_move_before_who_writes_of_touching_it_has_said_that_it_is_harmless(remark: str) -> None:
    assert rule_of(remark) in (RULE, "way.somebody")


@pytest.mark.parametrize("remark", [r for line in AT_ITS_FEET.strip().splitlines() for r in line.split("|")])
def test_law_7_things_on_the_floor_and_covered_sensors_are_asked_about(remark: str) -> None:
    assert rule_of(remark) in (RULE, "way.thing", "way.something")


@pytest.mark.parametrize("remark", [r for line in NOT_AT_THE_ROBOT.strip().splitlines() for r in line.split("|")])
def test_what_people_say_of_themselves_elsewhere_passes(remark: str) -> None:
    assert rule_of(remark) is None


@pytest.mark.parametrize(
    ("remark", "step", "passes"),
    [
        ("I'm under you", Primitive(Op.SIT), False),
        ("I'm holding your paw", Primitive(Op.HELLO), False),
        ("my son is petting you", Primitive(Op.HEART), False),
        ("我正抱着你", Primitive(Op.HELLO), False),
        ("I'm standing in front of you", Primitive(Op.HELLO), True),
        ("we are right next to you", Primitive(Op.GET_FRONT_IMAGE), True),
        ("I'm holding your leg", Primitive(Op.GET_FRONT_IMAGE), True),
    ],
)
def test_a_gesture_waits_for_who_touches_the_robot_and_a_photo_for_nobody(
    remark: str, step: Primitive, passes: bool
) -> None:
    plan, language = Plan((step,)), language_of(remark)
    found = hazard_in_path(remark, plan, language) or doubtful_remark(remark, plan, language)
    assert (found is None) is passes


@pytest.mark.parametrize(
    ("text", "op"),
    [
        ("stretch you are on a shelf", Op.STRETCH),
        ("take a photo she is naked", Op.GET_FRONT_IMAGE),
        ("take a photo (she is naked)", Op.GET_FRONT_IMAGE),
    ],
)
def test_a_remark_is_asked_about_without_a_pause_before_it_too(text: str, op: Op) -> None:
    plan = Plan((Primitive(op),))
    verdict = hazard_in_path(text, plan, "en") or doubtful_remark(text, plan, "en")
    assert verdict is not None
