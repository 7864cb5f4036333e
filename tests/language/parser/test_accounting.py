"""Law 18, all or a question: every clause of a post is done, told as left out, or asked back; none is swallowed."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.language.parser.grammar import parse
from agentrob.language.remarks.verbs import VERBS
from agentrob.model import Intent
from tests.language.parser import generated_posts
from tests.language.parser.generated_posts import merged
from tests.language.saying import OPS, read, short
from tests.sizes import size

DONE = {
    "three times: forward 1 m, wave": "F1 hello F1 hello F1 hello",
    "three times: 1 m forward, wave": "F1 hello F1 hello F1 hello",
    "spin clockwise 180 and show me what u see": "r180 photo",
    "turn left and show me what u see": "l90 photo",
    "take a picture and let me know what you see": "photo",
    "往前走一米，给他挥挥手": "F1 hello",
    "给客人们鼓掌，然后坐下": "clap sit",
    "前进一米，别忘了拍照": "F1 photo",
    "take a photo and post it": "photo",
    "turn left 90 degrees\nturn around": "l90 l180",
    "前进一米，拍照发给我": "F1 photo",
    "前进一米，记得挥手": "F1 hello",
    "walk forward 1 m, don't forget the picture": "F1 photo",
    "walk forward 1 m and never forget to wave": "F1 hello",
    "可以拍张照片给我看看吗？": "photo",
    "往前走一米，让我看看": "F1 photo",
    "走一米，顺便拍个照": "F1 photo",
    "走一米顺带打个招呼": "F1 hello",
    "坐下再起来吧": "sit stand",
    "can't you wave": "hello",
    "walk 2 m and tell us how far you really went": "F2",
    "turn left 90 degrees and report the measured angle": "l90",
    "repeat the following twice: forward 50 cm, wave": "F0.5 hello F0.5 hello",
    "won't you walk forward 1 m and wave": "F1 hello",
}


@pytest.mark.parametrize(("text", "plan"), DONE.items())
def test_law_18_every_action_of_a_post_is_in_its_plan(text: str, plan: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert short(understood.plan) == plan


ASKED = {
    "walk 1 m so i can see better and turn left": "i can see better and turn left",
    "turn thirty degrees so i can see better and send me a picture": "i can see better and send me a picture",
    "turn left 30 degrees so i can see better and send me a picture": "i can see better and send me a picture",
    "walk 1 m so he can see you and sing": "he can see you and sing",
    "walk forward 1 metre and tell me the temperature": "tell me the temperature",
    "Tell me the temperature. Walk forward 1 metre.": "Tell me the temperature",
    "walk forward 1 metre, then tell him the temperature": "tell him the temperature",
    "turn left, let me know when you're hungry": "let me know when you're hungry",
    "patrol the room and report": "report",
    "turn left and report": "report",
    "wave at sunrise": "wave at sunrise",
    "turn left not quite 90 degrees": "not quite",
    "walk 1 m and help": "help",
    "turn left and what do you see": "what do you see",
    "Turn left. What do you see?": "What do you see",
    "Walk forward 1 m as the manual said. Turn left.": "Walk forward 1 m as the manual said",
    "前进一米，给他做个后空翻": "他做个后空翻",
    "给他做个后空翻": "他做个后空翻",
    "前进两米，把那个箱子打开": "那个箱子打开",
    "前进一米，他会看着再左转": "他会看着再左转",
    "嗨起来！": "嗨起来",
    "turn left, left 90 degrees": "turn left",
    "turn left and left 90 degrees": "turn left",
    "walk 1 m and post it": "post it",
    "前进一米，发给我": "发给我",
    "帮他挥手": "他挥手",
    "有人就停，走两米": "有人就停",
    "前进一米，我很无聊，往前走一米": "我很无聊,往前走一米",
    "让我看看你坐下": "坐下",
    "看看你坐下": "坐下",
    "挥手给大家看看坐下": "挥手给大家看看坐下",
    "坐下给大家看看": "坐下给大家看看",
    "turn another ten inches to your right": "turn",
    "turn ten inches to the right": "turn",
}


@pytest.mark.parametrize(("text", "words"), ASKED.items())
def test_law_18_a_clause_that_is_not_understood_is_quoted_and_nothing_moves(text: str, words: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK
    assert f"`{words}`" in understood.question
    assert not understood.plan.steps


def test_law_18_an_order_beside_a_walk_is_never_swallowed_whatever_its_verb() -> None:
    swallowed = []
    for verb in sorted(VERBS):
        understood = read(f"walk forward 1 m. {verb} the box.")
        denied = any("Not done, as you said" in note for note in understood.plan.notes)
        if understood.intent is not Intent.ASK_BACK and len(understood.plan.steps) < 2 and not denied:
            swallowed.append(verb)
    assert swallowed == []


WITH_HAVE = """
have a rest|have a turn left|have a walk|have a look around|have a good look around|have the box|have a drink
"""


@pytest.mark.parametrize("order", WITH_HAVE.strip().split("|"))
def test_law_18_an_order_that_begins_with_have_is_no_remark(order: str) -> None:
    understood = read(f"walk forward 1 m and {order}")
    assert understood.intent is Intent.ASK_BACK, understood.plan.notes


LEFT_OUT = {
    "walk forward 1 m and have a nice day": "have a nice day",
    "walk forward 1 m and have fun": "have fun",
    "I'm bored. Walk forward 1 m.": "I'm bored",
    "walk forward 1 m, i will watch": "i will watch",
    "turn left so i can see the door": "i can see the door",
    "Yesterday you walked 2 m. Turn left.": "Yesterday you walked 2 m",
    "What a day! Turn left.": "What a day",
    "help, walk forward 1 m": "help",
    "我很无聊。前进一米": "我很无聊",
}


@pytest.mark.parametrize(("text", "words"), LEFT_OUT.items())
def test_law_18_a_remark_beside_a_command_is_told_as_left_out(text: str, words: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert len(understood.plan.steps) == 1
    (note,) = [n for n in understood.plan.notes if "Left out" in n or "闲话" in n]
    assert f"`{words}`" in note


def test_law_18_what_was_denied_is_told_as_not_done() -> None:
    assert "Not done, as you said: `don't wave`." in read("walk forward 1 m and don't wave").plan.notes
    assert "按您说的没有做：`不要挥手`。" in read("前进一米，不要挥手").plan.notes


IN_ORDER = """
@quadruped walk forward 1 metre, then @dog2 wave|when @quadruped is done, @dog2 wave|@quadruped, then @dog2 wave
@dog2 wave when @quadruped is done|@quadruped walk 1 m. After that @dog2 wave.|@dog2 wave after @quadruped has walked
@quadruped walk 1 m, @dog2 wave afterwards|@quadruped walk 1 m first, @dog2 wave|as soon as @quadruped sits, @dog2 clap
@quadruped前进一米，然后@dog2挥手|等@quadruped走完，@dog2挥手|@quadruped前进一米后@dog2挥手
@quadruped 前进一米，@dog2 再挥手|@dog2 等@quadruped走完再挥手
"""
SIDE_BY_SIDE = {
    "@quadruped walk 1 m. @dog2 wave.": ("F1", "hello"),
    "@quadruped walk 1 m and @dog2 wave": ("F1", "hello"),
    "@quadruped and @dog2 wave, then sit": ("hello sit", "hello sit"),
    "@quadruped first walk 1 m, then wave. @dog2 sit": ("F1 hello", "sit"),
    "@quadruped 先前进一米，再挥手。@dog2 坐下": ("F1 hello", "sit"),
    "@quadruped 前进一米，@dog2 挥手": ("F1", "hello"),
    "okay, then @quadruped wave": ("hello", ""),
}


def _both(text: str) -> list[tuple[Intent, str]]:
    heard = [parse(text, [me], [other], OPS) for me, other in (("quadruped", "dog2"), ("dog2", "quadruped"))]
    return [(understood.intent, short(understood.plan)) for understood in heard]


@pytest.mark.parametrize("text", [t for line in IN_ORDER.strip().splitlines() for t in line.split("|")])
def test_law_18_an_order_between_robots_is_asked_back_by_each_of_them(text: str) -> None:
    assert _both(text) == [(Intent.ASK_BACK, "")] * 2


@pytest.mark.parametrize(("text", "plans"), SIDE_BY_SIDE.items())
def test_robots_that_are_told_side_by_side_each_do_their_part(text: str, plans: tuple[str, str]) -> None:
    assert tuple(plan for _, plan in _both(text)) == plans


def test_law_18_what_was_said_to_one_robot_before_another_is_named_is_not_taken_for_the_other() -> None:
    understood = parse("walk forward 1 metre, then @dog2 wave", ["dog2"], ["quadruped"], OPS)
    assert understood.intent is Intent.ASK_BACK


# ------------------------------------------------------------------ posts made of parts whose plan is known
# No motion without its amount or side: whether what follows completes it ("turn, left 90 degrees") is anybody's guess.
#: An action as people say it: (words, plan). An empty plan: it has to be asked back.
Action = tuple[str, str]


def _actions(table: str) -> list[Action]:
    return [tuple(row.split("=")) for row in table.replace("\n", "|").split("|")]  # type: ignore[misc]


EN = _actions(
    """walk forward 1 m=F1|walk forward one metre=F1|go back half a metre=B0.5|move forward 3 feet=F0.9144
step 20 cm to the left=L0.2|strafe right 30 cm=R0.3|turn left=l90|turn left 90 degrees=l90
rotate right by 45 degrees=r45
spin clockwise 180=r180|turn around=l180|wave=hello|wave at me=hello|take a photo=photo|send me a picture=photo
show me what you see=photo|snap a pic=photo|sit down=sit|stand up=stand|clap=clap|shake hands=shake|make a heart=heart
stretch=stretch|do a backflip=backflip|forward 1 m=F1|left 90 degrees=l90|sing a song=|open the door=|report=
tell me the temperature=|walk to the kitchen=|frobnicate=|meander 2 m=|patrol the room=|let me know=
patrol=F1 l180 F1 l180|dance=l30 r60 l30 hello heart|walk a square=F0.5 l90 F0.5 l90 F0.5 l90 F0.5 l90
show me your teeth=|turn ten inches to the right="""
)
ZH = _actions(
    """前进一米=F1|往前走一米=F1|向前走50厘米=F0.5|后退半米=B0.5|向左平移30厘米=L0.3|左转=l90|左转90度=l90|向右转45度=r45|掉头=l180
挥手=hello|挥挥手=hello|给他挥挥手=hello|打个招呼=hello|拍照=photo|拍张照片=photo|发一张照片=photo|坐下=sit|站起来=stand
鼓掌=clap|握手=shake|比心=heart|伸个懒腰=stretch|来个后空翻=backflip|唱首歌=|打开门=|告诉我温度=|去厨房=|汇报=
巡逻一圈=F1 l180 F1 l180|跳个舞=l30 r60 l30 hello heart|走一个正方形=F0.5 l90 F0.5 l90 F0.5 l90 F0.5 l90
给他做个后空翻=|把那个箱子打开=|让我看看你坐下="""
)
#: Words around an action that do not change it.
EN_FRAMES = """{}|{}|{}|{}|please {}|{} please|could you {}|can you please {}|don't forget to {}|remember to {}|now {}
i want you to {}|kindly {}|just {}|{} for me|{} if you can|be sure to {}|make sure to {}|also {}|finally {}
you should {}|go ahead and {}|{} thanks|ok {}|would you {}|try to {}"""
ZH_FRAMES = """{}|{}|{}|{}|请{}|请你{}|帮我{}|别忘了{}|不要忘记{}|记得{}|麻烦你{}|你{}|先{}|{}吧|{}，谢谢|我想让你{}
最后{}|务必{}"""
EN_JOINS = ", |, then |. |. Then | and | and then |; |\n|, and |! |, after that | then |, and also | followed by "
ZH_JOINS = "，|，然后|。|，再|，接着|；|\n|，并|，最后|然后|，随后|！|，之后|并且|，还要"
#: What may follow an action: a purpose or a remark, left out; only what is told as such.
EN_ASIDES = " so i can see better| so that we can film it| because i am bored|, i will watch|, it's fun"
ZH_ASIDES = "，我看着|，我很无聊|，这样很好"
EN_TIMES = {" twice": 2, " three times": 3, " two times": 2}
ZH_TIMES = {"两次": 2, "三次": 3, "两遍": 2}
GESTURES = ("hello", "sit", "stand", "clap", "shake", "heart", "stretch", "backflip")


@st.composite
def posts(draw: st.DrawFn) -> tuple[str, list[str] | None]:
    """A post of one to three actions, and the steps it means; None where a part of it is beyond the grammar."""
    chinese = draw(st.booleans())
    actions = ZH if chinese else EN
    frames = (ZH_FRAMES if chinese else EN_FRAMES).replace("\n", "|").split("|")
    joins = (ZH_JOINS if chinese else EN_JOINS).split("|")
    times: dict[str, int] = ZH_TIMES if chinese else EN_TIMES
    asides = (ZH_ASIDES if chinese else EN_ASIDES).split("|")
    text, beyond = "", False
    steps: list[str] = []
    count = draw(st.integers(1, 3))
    for at in range(count):
        said, plan = draw(st.sampled_from(actions))
        repeated = 1
        if plan in GESTURES and draw(st.integers(0, 4)) == 0:
            words: str = draw(st.sampled_from(sorted(times)))
            said, repeated = said + words, times[words]
        said = draw(st.sampled_from(frames)).format(said)
        if draw(st.integers(0, 7)) == 0:
            said += draw(st.sampled_from(asides))
        text += (draw(st.sampled_from(joins)) if at else "") + said
        beyond |= not plan
        steps += plan.split() * repeated
    ahead = draw(st.sampled_from(["", "", "", "", "", "twice: ", "three times: "])) if not chinese else ""
    if ahead:
        text, steps = f"{ahead}{text}", steps * (2 if ahead == "twice: " else 3)
    return text, None if beyond else steps


def _merged(steps: Sequence[str]) -> list[str]:
    """Two pictures on end are one: nothing has changed between them."""
    return [step for at, step in enumerate(steps) if step != "photo" or steps[at - 1 : at] != ["photo"]]


def _is_all_or_a_question(text: str, steps: list[str] | None) -> bool:
    understood = read(text)
    if understood.intent is not Intent.COMMAND:
        return not understood.plan.steps
    done = short(understood.plan).split()
    return steps is not None and _merged(done) == _merged(steps)


@given(posts())
@settings(max_examples=400, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
def test_law_18_a_post_of_several_actions_is_exactly_its_plan_or_a_question(post: tuple[str, list[str] | None]) -> None:
    assert _is_all_or_a_question(*post), (post, short(read(post[0]).plan))


@pytest.mark.slow
@given(posts())
@settings(max_examples=size(1_500, 10_000), derandomize=True, suppress_health_check=[HealthCheck.too_slow])
def test_law_18_thousands_of_posts_are_exactly_their_plans_or_a_question(post: tuple[str, list[str] | None]) -> None:
    assert _is_all_or_a_question(*post), (post, short(read(post[0]).plan))


@given(posts())
@settings(max_examples=300, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
def test_a_post_of_several_actions_is_never_met_with_silence(post: tuple[str, list[str] | None]) -> None:
    assert read(post[0]).intent is not Intent.NOTHING or post[1] is None


# ------------------------------------------------------------------ generated posts (see `generated_posts`)
def test_law_18_no_action_of_a_generated_post_is_dropped_added_or_moved() -> None:
    wrong = []
    for post in generated_posts.posts(size(2_500, 40_000)):
        understood = read(post.text)
        if understood.intent is Intent.COMMAND:
            done = merged(short(understood.plan).split())
            if done not in {merged(plan) for plan in post.plans}:
                wrong.append((post.text, done))
        elif understood.plan.steps:
            wrong.append((post.text, short(understood.plan)))
    assert not wrong, f"{len(wrong)} posts, for example {wrong[:5]}"


#: A remark and a request without a pause between them, as the generator found them.
JOINED_TO_A_REMARK = (
    "那就向左平移一米，大家都在看完告诉我温度",
    "记得挥手，免得绊倒人和找我的钥匙",
    "请站起来，我很无聊，然后往前走半米，大家都在看完拍张照片",
    "站起来，免得绊倒人完发一张照片，随后给他挥挥手",
    "记得朝前走一米五，前面没有人和握手，不要伸个懒腰",
    "麻烦你挥手，这样很好完数椅子",
)


@pytest.mark.parametrize("text", JOINED_TO_A_REMARK)
def test_law_18_a_request_that_joins_a_remark_is_asked_about(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


#: Constructs that people use every day; a question about them is the exception.
PLAIN = {"join", "politeness", "reminder", "count", "order word", "remark"}
MOST_ASKED = 0.2


def test_a_question_about_plain_posts_is_the_exception() -> None:
    plain = [
        post for post in generated_posts.posts(size(2_500, 40_000)) if post.plans and PLAIN.issuperset(post.constructs)
    ]
    asked = sum(read(post.text).intent is not Intent.COMMAND for post in plain)
    assert asked <= MOST_ASKED * len(plain)


COUNTS = {
    "sit twice and wave": "sit sit hello",
    "wave, then sit twice": "hello sit sit",
    "walk 1 m and wave twice": "F1 hello hello",
    "sit twice and stand twice": "sit sit stand stand",
    "wave and take two photos": "hello photo photo",
    "挥手两次，再坐下": "hello hello sit",
    "forward 0.4 m, then half a metre forward": "F0.4 F0.5",
}


@pytest.mark.parametrize(("text", "plan"), COUNTS.items())
def test_a_count_belongs_to_the_action_beside_it(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan


BOTH_OR_ONE = ["sit and stand 2 times", "wave and sit three times", "挥手和鼓掌两次", "sit, stand, 2 times"]


@pytest.mark.parametrize("text", BOTH_OR_ONE)
def test_a_count_that_may_be_meant_for_two_actions_is_asked_back(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


PUT_FIRST = {
    "sit down, but first walk 1 m": "F1 sit",
    "stretch once, but first do a backflip": "backflip stretch",
    "sit last, back up a foot first": "B0.3048 sit",
    "show me what you see, but first strafe right 2 m": "R2 photo",
    "walk 2 m, nobody is here, but first wave": "hello F2",
    "wave, and sit down beforehand": "sit hello",
    "stand up once done sending me a picture": "photo stand",
    "坐下，但是先前进一米": "F1 sit",
    "坐下前先挥手": "hello sit",
    "坐下以前拍照": "photo sit",
    "转身，免得绊倒人，先站起来": "stand l180",
    "最后鼓掌，先右转": "r90 clap",
}


@pytest.mark.parametrize(("text", "plan"), PUT_FIRST.items())
def test_law_18_a_action_that_is_said_to_come_first_is_never_done_later(text: str, plan: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK or short(understood.plan) == plan


@pytest.mark.parametrize(
    "text",
    [
        "shake hands so i can see better spin 90 degrees clockwise",
        "90 degrees left, it's fun ten feet forward",
        "wave at me, the cat is in another room and then frobnicate",
        "show me what you see forward 3 feet",
        "往右移动1米，我很无聊以后捡球",
        "握手，好让大家看见完给他做个后空翻",
        "stand up & walk 1 m, and repeat everything once",
        "move one metre to the left frobnicated",
        "move 10 feet to the left, the floor is clean after clapping",
        "turn right so the kids can see you & frobnicate",
        "before you walk 1 m, do a backflip, and do all of that twice",
        "右转，天气真好并且数椅子",
    ],
)
def test_law_18_a_action_within_or_after_a_remark_is_asked_back(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


@pytest.mark.parametrize(
    ("text", "plan"),
    [
        ("走50厘米以后向大家问好", "F0.5 hello"),
        ("走50厘米后向大家问好", "F0.5 hello"),
        ("走五十厘米好吗后向大家问好", "F0.5 hello"),
        ("向前走两米后左转", "F2 l90"),
        ("现在给他挥挥手，随后右转45度，免得绊倒人", "hello r45"),
        ("不如打个招呼，之后站起来", "hello stand"),
        ("往后走两米", "B2"),
        ("后两米", "B2"),
    ],
)
def test_after_is_told_from_backward(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan
