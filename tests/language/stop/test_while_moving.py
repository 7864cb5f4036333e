"""Law 13 while a robot moves: a stop word or a warning anywhere stops it, and what is plainly none does not."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.evals.stops import evaluate_stops, stops_it
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.stop.while_moving import stop_while_moving
from agentrob.language.visible_text import visible_text
from agentrob.model import Intent

ROWS = Path(__file__).with_name("stops.jsonl")
#: The first two sets of the file, by the author of the rules; the others were written without sight of them.
OWN = 427
BOUND = """
@quadruped walk 1 m and stop|@quadruped walk forward 2 m, then stop|@quadruped 往前走一米然后停下
@quadruped turn left 90 degrees and halt
"""
NOT_BOUND = """
@quadruped walk 5 m STOP|@quadruped walk 5 m. Stop!|@quadruped wait, turn left 90 degrees
@quadruped wait for me at the door
@quadruped walk 1 m and stop, careful, the cat!
"""


def _rows(text: str) -> list[str]:
    return [row for line in text.strip().splitlines() for row in line.split("|")]


def stops(text: str) -> Intent | None:
    return stop_while_moving(visible_text(text), ("quadruped",), ("humanoid",))


def test_law_13_the_sets_hold_and_are_of_both_languages() -> None:
    rows = [json.loads(line) for line in ROWS.read_text(encoding="utf-8").splitlines()]
    assert len(rows) >= 300
    found = evaluate_stops(ROWS)
    assert 0.5 < found.stops / len(rows) < 0.65
    # Those that are read otherwise are marked in the file: almost all stop where nobody wants it, "in doubt it stops".
    assert {*found.missed, *found.false} == {row["text"] for row in rows if row.get("wrong")}
    assert len(found.missed) <= 9
    assert len(found.false) <= 42


def test_law_13_no_row_of_the_own_sets_is_read_otherwise() -> None:
    rows = [json.loads(line) for line in ROWS.read_text(encoding="utf-8").splitlines()]
    own = rows[:OWN]
    assert sum(row["stop"] for row in own) == 142 + 113  # as in the table of docs/safety/understanding.md
    assert [row["text"] for row in own if row.get("wrong")] == []


BLIND_BOUND = """
walk up to the whiteboard and stop half a metre before it|turn left 90 degrees, pause, then turn back
for the next run: trot forward one metre, stop, turn left and sit down|wait 3 seconds and then wave
spin around slowly and stop facing the window|走到公交站停下|后退五步再停住|举起右手,停两秒,再放下
"""
#: Motions with their amounts, and who is to make them; a word binds the stop to them.
MEASURED = """
小车右转三十度后停下|底盘向右旋转六十度后停住|机器狗前进两米后停下|让小车倒退1.5米再停|请让小车慢慢后退四步，然后停下
左移半米后停下|小车行驶十秒钟后停下来|底盘原地旋转一圈半之后停住|机器人，前进两米，然后停下
小车先前进两米，再左转九十度，然后停下|車子前進兩米後停住|机械狗向前三步后停下不动
"""
#: Whole commands whose shape does not bind the stop, or that have no stop word at all but the words of a warning.
WHOLE_COMMANDS = """
take a photo of the chair in front of you|walk three feet ahead|walk four feet ahead and sit down
go 2 feet ahead then turn right|turn around and take a photo of what's behind you
take a picture of the table near the door|sit down and stop|wave twice and stop|turn left slowly and stop
stand up, turn around, and take a picture of what's behind you|sit down, then wait
turn left and take a photo of the wall behind the chair in front of you
坐下然后停|挥手然后停下|挥手再停|站起来然后停下|左转然后停|慢一点往前走一米|慢点走两米
"""
#: The first clause is a command that the grammar understands, and leaves the warning out as a remark.
WARNS_BESIDES = """
walk 2 m, there is a cat in front of you|go back 1 m, it is too close|turn around; there are stairs ahead of you
sit down, and there is a dog behind you|别往前走，后退一米
"""
LOOKS_BOUND = """
小车前行三秒，停下|小车前行三秒停下|小车前行三秒后停住！|小车前行三秒后停住，小心|小车三秒后停下|底盘左旋后停下|小车后停下
turn left, stop!|go to the door and stop now|walk to the wall and stop, it is falling|走到这里停下|在这里停下|往后退，停
back up, stop|go back to the door and stop right there
"""


#: What somebody near the robot calls, in words that are no stop by themselves.
CALLED = """
there's a kid|hey, there is a dog|I see a cable|turn around now, there's a wall|my baby is in there|someone's coming
you're on my foot|the cable is caught|something smells burnt|it's making a weird noise|it is limping|oops
it doesn't listen|off the carpet!|pull over|code red|have a break|I'd rather you didn't go on|the cat is right there
有个小孩|有一只猫|有烟|有焦味|绊住了|拉闸|就到这儿|滚开|走过头了|超了|搞反了|声音不对|休息|宝宝爬过去了
"""
#: Similar words that warn of nothing.
SAID = """
there's a typo in your post|there are three robots in this forum|I see what you mean|here comes the weekend
my cat would love this|the kids are at home today|people are so impressed|it's on the news|that sounds good
looks good to me|smells like coffee in here|he is on my team|what a beautiful place to be|it listens so well
有一个问题|有意思|有一天我也要买一只|超级棒|超可爱了|声音真好听|算了一下，一共走了五米|这个视频我看过了|多走走挺好的
"""
OTHER_LANGUAGES = """
¡alto!|basta ya|detente por favor|arrête!|Arrêtez tout|anhalten|Vorsicht, das Kind|fermati|stoppen bitte|pára, cuidado
стоп!|осторожно, ребёнок|ロボットストップ|止まれ|危ないよ|멈춰!|그만해
"""


@pytest.mark.parametrize("text", _rows(CALLED))
def test_law_13_what_somebody_near_the_robot_calls_stops_it(text: str) -> None:
    assert stops(text) is Intent.STOP


@pytest.mark.parametrize("text", _rows(SAID))
def test_what_people_say_beside_a_moving_robot_does_not_stop_it(text: str) -> None:
    assert stops(text) is None


@pytest.mark.parametrize("text", _rows(OTHER_LANGUAGES))
def test_law_13_a_stop_in_a_language_that_robots_do_not_speak_stops_them(text: str) -> None:
    assert stops(text) is Intent.STOP


@pytest.mark.parametrize("text", _rows(BLIND_BOUND))
def test_law_13_the_shape_of_a_command_binds_its_stop_though_the_grammar_asks_back(text: str) -> None:
    assert stops(text) is None


@pytest.mark.parametrize("text", _rows(MEASURED))
def test_law_13_measured_motions_bind_the_stop_at_their_end_whoever_is_to_make_them(text: str) -> None:
    assert stops(text) is None


@pytest.mark.parametrize("text", _rows(WHOLE_COMMANDS))
def test_law_13_a_command_that_the_grammar_understands_as_a_whole_is_no_stop(text: str) -> None:
    assert stops(text) is None
    assert stops(f"@quadruped {text}") is None


@pytest.mark.parametrize("text", _rows(WARNS_BESIDES))
def test_law_13_a_warning_beside_a_command_stops_though_the_grammar_leaves_it_out(text: str) -> None:
    assert stops(text) is Intent.STOP
    assert stops(f"@quadruped {text}") is Intent.STOP


@pytest.mark.parametrize("text", _rows(LOOKS_BOUND))
def test_law_13_a_stop_that_only_looks_bound_stops(text: str) -> None:
    assert stops(text) is Intent.STOP


def test_law_13_a_row_is_judged_for_the_robot_that_it_names() -> None:
    assert stops_it("@humanoid 别动")
    assert not stops_it("@humanoid nice")


@pytest.mark.parametrize("text", _rows(BOUND))
def test_law_13_a_stop_that_is_bound_in_a_whole_command_is_a_part_of_it(text: str) -> None:
    assert stops(text) is None


@pytest.mark.parametrize("text", _rows(NOT_BOUND))
def test_law_13_in_doubt_it_stops(text: str) -> None:
    assert stops(text) is Intent.STOP


def test_law_13_what_follows_another_robots_mention_is_for_that_robot() -> None:
    assert stops("@quadruped walk 1 m, @humanoid stop please, it falls") is None
    assert stops("stop that thing, @quadruped and @humanoid") is Intent.STOP
    assert stops("@humanoid wave, @quadruped careful!") is Intent.STOP
    assert stops("@humanoid and @quadruped that's enough") is Intent.STOP


def test_law_17_only_an_emergency_stop_of_its_own_clause_locks() -> None:
    assert stops("it burns! emergency stop!") is Intent.HALT
    assert stops("着火了，急停！") is Intent.HALT
    assert stops("omg halt it, it's going to fall") is Intent.STOP


@given(st.text())
def test_law_13_the_wide_rule_holds_the_narrow_one(text: str) -> None:
    if narrow := stop_intent(text):
        assert stop_while_moving(text) is narrow


@pytest.mark.parametrize(
    "unit",
    ["停", "stop ", "don't ", "don't stop ", "别停", "no ", "is it ", "a", "wait ", "s.t.", "the cat ", "why did it ",
     "going to ", "要", "不要", "nice ", "@humanoid ", "@quadruped walk 1 m and stop ", "can't stop laughing "],
)  # fmt: skip
def test_law_13_hostile_repetition_stays_quick(unit: str) -> None:
    start = time.process_time()
    stop_while_moving(unit * (10_000 // len(unit)) + "x", ("quadruped",), ("humanoid",))
    assert time.process_time() - start < 0.5


@pytest.mark.parametrize(
    "unit", ["转一半圈，", "转一圈再", "再后就并", "walk 1 m and ", "wait 1 s and then ", "下一，", "走到", "，"]
)
@pytest.mark.parametrize("end", ["停", "停x", " and stop x"])
def test_law_13_the_longest_posts_whose_shape_is_read_stay_quick(unit: str, end: str) -> None:
    text = "walk " + unit * (380 // len(unit)) + end
    start = time.process_time()
    stop_while_moving(text, ("quadruped",), ("humanoid",))
    stop_while_moving(text.removeprefix("walk "), ("quadruped",), ("humanoid",))
    assert time.process_time() - start < 0.5
