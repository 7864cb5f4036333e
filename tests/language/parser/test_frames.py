"""Commands within sentences that make no command of them: denied, conditional, asked, told, delayed, withdrawn.

None of them may move the robot, in a thread in which something was done before too.
"""

from __future__ import annotations

import pytest

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.model import Direction, Intent, Plan
from tests.language.saying import OPS, read, short, walk

THREAD = ParseContext(history=(Plan((walk(Direction.LEFT, 3.0),)),))
COMMANDS = """
walk forward 1 m|turn left 90 degrees|go back 2 feet|sit down|wave twice|do a backflip|turn around|come back
do it again|walk for two seconds|strafe left 30 cm|turn left
"""
COMMANDS_ZH = """
前进一米|左转九十度|后退两米|坐下|挥手两次|来个后空翻|掉头|回来|再来一次|走两秒|向左平移30厘米|左转
"""
FRAMES = """
don't {}|do not {}|never {}|please don't {}|you must not {}|you should not {}|you shouldn't {}
I told you not to {}|if you can see me, {}|if it is free {}|{} if it is free|{} when I say so
{} unless there is a cat|unless I say so {}|until noon {}|once I am there {}|did you {}?|did you {}|will it {}
he told me to {}|she said {}|yesterday I saw you {}|why did you {}|I saw it {}|I {} every day|we {} tomorrow
what if you {}|what would happen if you {}|do you think you should {}|I don't think you should {}
I doubt you can {}|avoid to {}|stop before you {}|no need to {}|there is no need to {}|it is forbidden to {}
it's not safe to {}|imagine you {}|pretend to {}|let's not {}|can you not {}|please never {}|nobody said {}
I would never {}|I wouldn't {}|you can't {}|you cannot {}|he can {}|they want you to {}|he wants you to {}
my cat can {}|is it ok to {}|is it possible to {}|should I {}|should you {}|may I {}|how do I make you {}
how do you {}|the manual says {}|as the manual says, {}|the command was {}|for example {}|e.g. {}|like {}?
{} or not|{} or sit|either {} or sit|maybe {}|perhaps {}|later {}|in an hour {}|in 5 minutes {}|tomorrow {}
at noon {}|{} tomorrow|{} later|{} in an hour|{} in 5 minutes|{} at noon|after lunch {}|{} after lunch
before you go {}|without moving {}|instead of sitting {}|rather than {}|don't ever {}|under no circumstances {}
refuse to {}|cancel {}|undo {}|forget {}|ignore {}|not {}|{} not|{}, not|{} never|{}, just kidding
after they left {}|when he has gone {}|as soon as he moved away {}|I wanted you to {}
{} just kidding|{}, no|{}. No.|{}? no|no {}|{} no|{} never mind|{} - never mind
"""
FRAMES_ZH = """
不要{}|别{}|不许{}|请不要{}|千万别{}|你不能{}|我没让你{}|如果安全就{}|要是可以，{}|{}，如果安全的话|等我说了再{}
除非我说，否则{}|你昨天{}了吗|你{}了吗|他说{}|他让你{}|我看见它{}|我每天{}|为什么你要{}|会不会{}|是不是要{}
能不能不{}|不用{}|没必要{}|不应该{}|禁止{}|假如你{}|比如{}|例如{}|{}或者坐下|要么{}要么坐下|也许{}|可能{}|明天{}
一会儿{}|五分钟后{}|等五秒{}|饭后{}|取消{}|忘了{}|不{}|{}，算了|{}，不|{}？不|{}就算了|你为什么{}|它会{}
我想知道怎么{}|怎么让你{}|谁让你{}的|是谁{}的|没人的话，{}|没有人的话{}|等人走了再{}|我来了就{}|他走了以后{}|门开了就{}
"""
PLAIN = """
walk forward 1 m|turn left 90 degrees|go back 2 feet|sit down|wave twice|do a backflip|turn around
strafe left 30 cm|take a photo|back up half a metre|move forward one and a half metres
"""
PLAIN_ZH = """
前进一米|左转九十度|后退两米|坐下|挥手两次|来个后空翻|掉头|向左平移30厘米|拍张照片|往前走一米五
"""
POLITE = """
please {}|{} please|{}, please!|could you {}?|could you please {}?|can you {}|would you {} please|will you {}?
hey robot, {}|Hey @robot, {}|@robot {}|@robot: {}|@robot, please {}|robot {}|ok {}|okay now {}|now {}
alright, {}|so {}|well, {}|um {}|uh, {}|{} thanks|{}, thank you!|thanks! {}|good job! {}|great, now {}
perfect. {}|I want you to {}|I'd like you to {}|I would like you to {}|I need you to {}|let's {}|we should {}
you should {}|try to {}|go ahead and {}|just {}|simply {}|kindly {}|first {}|then {}|and then {}|next, {}
finally, {}|{} now|{} right now|{} immediately|{} for me|{} if you can|{} when you're ready|**{}**|*{}*|- {}
1. {}|“{}”|{}.|{}!|{} 🙂|🐕 {}|hello! {}|hi there, {}|good morning robot, {}|yes {}|yes, {}|sure, {}|actually {}
oh and {}|also {}|do me a favor and {}|would you be so kind to {}|feel free to {}|be a good dog and {}
good boy, {}|carefully {}|I think you should {}|maybe you could {}|you can {} now|time to {}|your task: {}
command: {}|task: {}|please, robot, {}|ok robot please {} thank you|can you please {} for us?|{} pls|pls {}
plz {}|{} asap|quickly {}|{} again|it's time to {}|do this: {}|do the following: {}|here is your command: {}
{} and let me know when you're done|{}, tell me when finished
"""
POLITE_ZH = """
请{}|请你{}|麻烦{}|麻烦你{}|{}，谢谢|谢谢，{}|{}吧|{}！|{}。|能{}吗|能不能{}|可以{}吗？|你能{}吗|帮我{}|帮忙{}
机器人，{}|小狗{}|好的，{}|好，{}|现在{}|那就{}|先{}|然后{}|再{}|接着{}|最后{}|你好，{}|嗯，{}|我想让你{}
我要你{}|我希望你{}|你应该{}|快{}|赶快{}|马上{}|立刻{}|慢慢{}|**{}**|“{}”|- {}|1. {}|{}，好吗|{}好不好|{}行吗
{}就行|{}就可以了|直接{}|只要{}|请问可以{}吗|辛苦了，{}|任务：{}|命令：{}|拜托{}|给我{}|你{}|你给我{}|来，{}
{}，走完告诉我|{}，好了跟我说一声|完成后通知我，{}|喂，{}|@robot {}|@robot，{}|@robot请{}
"""


def _rows(text: str) -> list[str]:
    return [row for line in text.strip().splitlines() for row in line.split("|")]


def _moved(frame: str, commands: str) -> list[str]:
    posts = [frame.format(command) for command in _rows(commands)]
    return [post for post in posts if read(post, THREAD).plan.moves]


@pytest.mark.parametrize("frame", _rows(FRAMES))
def test_what_makes_no_command_of_a_command_moves_nothing(frame: str) -> None:
    assert _moved(frame, COMMANDS) == []


@pytest.mark.parametrize("frame", _rows(FRAMES_ZH))
def test_what_makes_no_command_of_a_chinese_command_moves_nothing(frame: str) -> None:
    assert _moved(frame, COMMANDS_ZH) == []


CONDITIONS = """
after they left {}|when he has gone {}|as soon as he moved away {}|if nobody's there {}|没人的话{}|没有人的话，{}
等人走了再{}|等没人了{}|要是没人就{}|他走了以后{}|我喊了你就{}|门开了就{}|我妈进来的时候{}
"""


@pytest.mark.parametrize("frame", _rows(CONDITIONS))
def test_law_18_a_command_under_a_condition_is_asked_about_and_never_passed_over(frame: str) -> None:
    commands = ("walk forward 1 m", "turn left 90 degrees") if frame.isascii() else ("走一米", "左转90度")
    for command in commands:
        understood = read(frame.format(command))
        assert understood.intent is Intent.ASK_BACK, (command, understood)


@pytest.mark.parametrize("command", [*_rows(COMMANDS), *_rows(COMMANDS_ZH)])
def test_the_same_commands_alone_move(command: str) -> None:
    assert parse(command, ["quadruped"], [], OPS, THREAD).intent is Intent.COMMAND


def _changed(frame: str, commands: str) -> list[str]:
    posts = {command: frame.replace("@robot", "@quadruped").format(command) for command in _rows(commands)}
    return [post for command, post in posts.items() if _actions(post) != _actions(command)]


def _actions(text: str) -> list[tuple[object, ...]]:
    return [(step.op, step.direction, step.distance_m, step.degrees) for step in read(text).plan.steps]


@pytest.mark.parametrize("frame", _rows(POLITE))
def test_manners_and_hesitations_change_nothing(frame: str) -> None:
    assert _changed(frame, PLAIN) == []


@pytest.mark.parametrize("frame", _rows(POLITE_ZH))
def test_manners_and_hesitations_change_nothing_in_chinese(frame: str) -> None:
    assert _changed(frame, PLAIN_ZH) == []


TOGETHER = """
wave as you walk 1 m|as you turn left, take a photo|wave when walking 1 m|walk 1 m, waving on the way
walk 1 m and on the way back wave|走一米，同时左转|走一米的同时挥手|边走一米边挥手|挥着手走一米
"""


@pytest.mark.parametrize("text", _rows(TOGETHER))
def test_law_18_what_is_to_be_done_at_the_same_time_is_asked_about(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


CUT_SHORT = """
walk l 1 m|step rig 1 m|walk bck 1 m|walk n 1 m|turn r 90|walk > 1 m|walk 1 m -->|走 > 1米|walk a metre and a bit
"""


@pytest.mark.parametrize("text", _rows(CUT_SHORT))
def test_law_18_a_side_that_is_cut_short_and_a_comparison_are_not_passed_over(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


WARNED = """
walk 1 m, it isn't safe|walk 1 m, not safe|it won't be safe, walk 1 m|the way isn't clear, walk 1 m
walk 1 m, it doesn't look safe|walk 1 m if the way is clear|walk 1 m, the floor is not dry yet|走一米，不安全
walk 1 m, don't touch the red line|don't mind the cables, walk 1 m|走一米，不要碰红线
walk 1 m, not yet|don't execute this, walk 1 m|walk 1 m, I object|walk 1 m per day|走一米，忽略这条|走一米，慢着
走一米，我反对|走一米，没地板|走一米，不稳|走一米，路不通|后面没人的话，后退一米
"""


@pytest.mark.parametrize("text", _rows(WARNED))
def test_laws_13_and_18_a_warning_beside_a_command_is_asked_about(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


CLEAR = {
    "walk 1 m, the way is clear": "F1",
    "nothing behind you, walk back 1 m": "B1",
    "walk back 1 m, nobody is behind you": "B1",
    "You have plenty of space. Walk 2 m.": "F2",
    "the floor is dry, walk 1 m": "F1",
    "后面没人，后退一米": "B1",
    "地板是干的，走一米": "F1",
}


@pytest.mark.parametrize(("text", "plan"), CLEAR.items())
def test_a_clear_path_changes_nothing_and_is_noted(text: str, plan: str) -> None:
    understood = read(text)
    assert short(understood.plan) == plan
    assert any("Left out as a remark" in note or "闲话" in note for note in understood.plan.notes)


OTHERS = """
I love @quadruped's wave|@quadruped's wave was great|我喜欢@quadruped的挥手|@quadruped 的舞很好看
@quadruped 我能走一米吗？|@quadruped 我可以坐下吗|@quadruped heat wave|@quadruped sand please|@quadruped shit, left 1 m
"""


@pytest.mark.parametrize("text", _rows(OTHERS))
def test_law_18_what_is_said_of_a_robot_or_of_oneself_and_words_like_commands_move_nothing(text: str) -> None:
    assert parse(text, ["quadruped"], [], OPS).intent in (Intent.NOTHING, Intent.ASK_BACK)


MISPLACED = """
walk 1 m, first sit|walk 1 m. First of all wave.|finish with a photo, walk 1 m|walk 1 m, finish with a photo, turn left
"""


@pytest.mark.parametrize("text", _rows(MISPLACED))
def test_law_18_a_first_step_that_is_not_said_first_and_a_last_one_that_is_not_last_are_asked_about(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK
