"""Law 13: a stop is a post whose first clause is only stop words, and nothing else is."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.parser.grammar import parse
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.visible_text import visible_text
from agentrob.model import Intent, Op

STOPS = """
stop|Stop!|STOP!!!|stop now|stop now, please|please stop|@quadruped stop|@quadruped, please stop.|stop, turn left
stop. Then walk 2 m|ok stop|hey robot stop right now|no, stop!|stop stop stop|stoooop|freeze|abort|don't move
do not move
stop turning left|please stop walking forward
stop moving|stand still|cancel|can you stop?|**stop**|stop `now`|`x` stop|stop <b>now</b>|🛑|stop it|whoa
halt|Halt!|please halt|please halt now!|halt it|stop, halt|kill switch
停|停！|停下|停下来|请停下|停止|别动|不要动|站住|马上停下|快停下|立刻停止|停停停|@quadruped 停|停，然后拍照
请你停一下|停止移动|暂停|取消
"""
HALTS = "emergency stop|Emergency stop!!|e-stop now|estop|e stop|please emergency stop|急停|紧急停止|@quadruped 急停！"
NO_STOPS = """
walk 2 m and stop|don't stop|do not stop|never stop|please don't stop|stop sign ahead|stopping distance|bus stop
nonstop
stop the music|stop for 5 seconds and walk|where do you stop|walk, stop|I said don't stop|go to the stop
stop walking into walls
it stopped|full|ok|please||hello|help|turn left
别停|不要停|停车场|不停|停车场在哪|走两米再停|别停下|不许停|停止播放音乐|没停|停电了|公交停靠站|向前走，停|你好
"""


def _rows(text: str) -> list[str]:
    return [row for line in text.strip().splitlines() for row in line.split("|")]


@pytest.mark.parametrize("text", _rows(STOPS))
def test_a_stop_stops(text: str) -> None:
    assert stop_intent(visible_text(text)) in (Intent.STOP, Intent.HALT)
    assert parse(visible_text(text), ["quadruped"], [], frozenset(Op)).intent is stop_intent(visible_text(text))


@pytest.mark.parametrize("text", _rows(HALTS))
def test_law_17_an_explicit_emergency_stop_locks(text: str) -> None:
    assert stop_intent(visible_text(text)) is Intent.HALT


@pytest.mark.parametrize("text", _rows(STOPS))
def test_law_17_nothing_else_locks(text: str) -> None:
    assert stop_intent(visible_text(text)) is Intent.STOP


@pytest.mark.parametrize("text", _rows(NO_STOPS))
def test_words_that_only_contain_a_stop_are_none(text: str) -> None:
    assert stop_intent(visible_text(text)) is None


@given(st.sampled_from(_rows(NO_STOPS)[:10]), st.sampled_from(["walk 1 m", "turn left", "拍照"]))
def test_a_stop_later_in_a_post_is_none(no_stop: str, command: str) -> None:
    assert stop_intent(f"{command}, {no_stop}") is None
    assert stop_intent(f"{command}. stop") is None


@given(st.text())
def test_any_text_is_read(text: str) -> None:
    assert stop_intent(text) in (None, Intent.STOP, Intent.HALT)


@given(st.text(alphabet="停下止别动不要快请了x,", max_size=60))
def test_denied_stops_are_never_stops(text: str) -> None:
    assert stop_intent(f"别停{text}") is None


@pytest.mark.parametrize("unit", ["停", "stop ", "停停下", "s", "please ", "@quadruped ", "don't ", ",", "请"])
def test_hostile_repetition_stays_quick(unit: str) -> None:
    start = time.process_time()
    stop_intent(unit * (10_000 // len(unit)) + "x")
    assert time.process_time() - start < 0.5
