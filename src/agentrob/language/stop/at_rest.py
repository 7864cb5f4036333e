"""The narrow stop rule: the first clause of a post is only stop words, apart from mentions, politeness and punctuation.

It is separate from the grammar on purpose, so that no change to the grammar can weaken a stop. When in doubt a robot
stops ("stop?", "no stop"), but text that merely contains a stop word does not stop it ("walk 2 m and stop", "don't
stop", 停车场).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from agentrob.language.complexity import nfkc
from agentrob.language.registry import known
from agentrob.language.visible_text import OMITTED, mentions, visible_text, without_mentions
from agentrob.model import Intent

_HAN = r"[\u3400-\u9fff]"
_STOP_EN = """
stop|stop it|stop that|stop this|stop there|stop here|stop everything|stop all|stop moving|stop walking|stop turning
stop going|stop turning left|stop turning right|stop turning around|stop walking forward|stop walking backward
stop moving forward|stop moving backward|stop going forward|stop going back
stop driving|stop the robot|stop the dog|full stop|stop motion|stop all motion|stop the motion|freeze
halt|halt it|kill switch|abort|abort it|abort that|abort mission|cease|stand still|stay still|hold still|hold it
hold your position
do not move|don't move|dont move|whoa|quit|quit it|quit moving|cancel|cancel that|cancel it|cancel everything
cancel all
"""
#: Law 17: only an explicit emergency stop locks the robot; "halt" is an ordinary stop.
_HALT_EN = "emergency stop|emergency-stop|e-stop|estop|e stop|emergency halt"
_POLITE_EN = """
please|pls|plz|now|right now|at once|immediately|instantly|asap|quickly|quick|just|robot|dog|doggy|hey|hi|hello|ok
okay|no|oh|oh no|oh god|everyone|everybody|all|you|sir|must|thanks|thank you|for god's sake|and|then|wait|nope|yo
urgent|urgently|both|all of you|both of you|guys|i said|can you|could you|would you|will you|already|fully
completely|here|there
"""
_STOP_ZH = """
停下來|別動|別動了|不要動|不許動|不准動|站著別動|停止移動|停止動作|別走了
停|停下|停下来|停止|停住|停一下|停一停|停手|别动|别动了|不要动|不要动了|不许动|不准动|不动|站住|站着别动|定住|住手
打住|别走了|不要走了|别再走了|停止移动|停止前进|停止运动|停止行走|停止动作|停止任务|停止一切|中止|终止|取消|暂停
"""
_HALT_ZH = "急停|緊急停止|緊急停下|紧急停止|紧急停下|紧急停机|紧急制动"
_POLITE_ZH = """
請|請你|快點|馬上|現在|麻煩|給我
请|请你|麻烦|麻烦你|你|您|快|快点|赶快|赶紧|马上|立刻|立即|现在|给我|全部|都|吧|啊|呀|了|啦|嘛|哦|喂|嘿|嗨|好|好了
不行|哎|哎呀|机器人|小狗|就|先|谢谢|原地
"""
_STOP_SYMBOLS = frozenset("🛑✋⛔")


def _phrases(*lists: str) -> frozenset[str]:
    return frozenset(phrase for words in lists for line in words.split("\n") for phrase in line.split("|") if phrase)


@dataclass(frozen=True)
class StopWords:
    """The stop words of all languages as sets; language files add to the built-in lists and cannot remove from them."""

    halt: frozenset[str]
    stop: frozenset[str]
    polite: frozenset[str]
    longest: int
    longest_han: int


@cache
def stop_words() -> StopWords:
    """Return the built-in stop words together with those of the language files."""
    locales = known().values()
    halt = _phrases(_HALT_EN, _HALT_ZH, *(t.halt for t in locales))
    stop = _phrases(_STOP_EN, _STOP_ZH, *(t.stop for t in locales)) | halt
    polite = _phrases(_POLITE_EN, _POLITE_ZH, *(t.polite for t in locales)) - stop
    spaced = max(p.count(" ") for p in stop | polite) + 1
    return StopWords(halt, stop, polite, spaced, max(len(p) for p in stop | polite if re.match(_HAN, p)))


_CLAUSE_END = re.compile(
    r"[,;.!?¡¿:\n，。！？；、：…—–()]+|\s-+\s|\b(?:and|then|but|or)\b|然后|接着|(?<![别不要])再(?!见)", re.IGNORECASE
)
_LETTER = r"[^\W\d_\u3400-\u9fff]"
_WORD = re.compile(rf"{_LETTER}+(?:['-]{_LETTER}+)*|{_HAN}+|[^\s\w*_~'\"]|\w")
_LONG_RUN = re.compile(r"([a-z])\1{2,}")


def stop_intent(visible: str) -> Intent | None:
    """Return `Intent.STOP` or `Intent.HALT` if the text is a stop (law 13), otherwise None.

    `visible` comes from `visible_text`. Only an explicit emergency stop is a `HALT` (law 17), which also blocks all
    motion until the robot's owner releases it.
    """
    for clause in _clauses(without_mentions(visible)):
        verdict = _read_clause(clause)
        if verdict is not _EMPTY:
            return verdict if isinstance(verdict, Intent) else None
    return None


_EMPTY = object()


def _read_clause(clause: str) -> Intent | object | None:
    """Return STOP or HALT, `_EMPTY` for a clause of politeness only, and None for anything else."""
    said: list[str] = []
    for phrase in _segments(clause):
        if phrase is None:
            return None
        said.append(phrase)
    lists = stop_words()
    if any(phrase in lists.halt for phrase in said):
        return Intent.HALT
    return Intent.STOP if any(phrase in lists.stop or phrase in _STOP_SYMBOLS for phrase in said) else _EMPTY


def _segments(clause: str) -> Iterator[str | None]:
    """Split a clause into stop words and politeness, longest first; yield None at the first other word."""
    plain = clause.casefold().replace("’", "'").replace(OMITTED, " ")
    words = _WORD.findall(_LONG_RUN.sub(r"\1", plain))
    lists = stop_words()
    at = 0
    while at < len(words):
        if re.match(_HAN, words[at]):
            yield from _han_segments(words[at])
            at += 1
            continue
        for length in range(min(lists.longest, len(words) - at), 0, -1):
            phrase = " ".join(words[at : at + length])
            if phrase in lists.stop or phrase in lists.polite or phrase in _STOP_SYMBOLS:
                yield phrase
                at += length
                break
        else:
            yield None
            return


def _han_segments(run: str) -> Iterator[str | None]:
    """Split a Chinese run, which has no spaces, into known words in linear time; yield None if that is impossible."""
    lists = stop_words()
    word_before: list[str | None] = [""] + [None] * len(run)  # by position; None where no cutting leads
    for end in range(1, len(run) + 1):
        for start in range(max(0, end - lists.longest_han), end):
            word = run[start:end]
            if word_before[start] is not None and (word in lists.stop or word in lists.polite):
                word_before[end] = word
                break
    at = len(run)
    while at > 0:
        word = word_before[at] or ""
        yield word or None
        at = at - len(word) if word else 0


def _clauses(text: str) -> Iterator[str]:
    at = 0
    for end in _CLAUSE_END.finditer(text):
        yield text[at : end.start()]
        at = end.end()
    yield text[at:]


#: Limits on the length and mentions of a post that counts as only a stop.
_ONLY_CHARS, _ONLY_NAMES = 120, 3


def is_only_stop(raw: str) -> bool:
    """Return whether a body says stop and nothing else.

    It must be short, and every clause as typed, not only the visible ones, must be stop words and politeness. No rate
    limit holds for such a post (law 15), so it must carry nothing else.
    """
    if len(raw) > _ONLY_CHARS or stop_intent(visible_text(raw)) is None:
        return False
    typed = nfkc(raw)
    if len(mentions(typed)) > _ONLY_NAMES:
        return False
    said = (_read_clause(clause) for clause in _clauses(without_mentions(typed)))
    return all(meant is not None for meant in said)
