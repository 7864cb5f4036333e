"""How Chinese speaks of times."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import date

from agentrob.language.schedule.parts import (
    At,
    Between,
    Clock,
    Day,
    Delay,
    Every,
    Except,
    Form,
    Part,
    ScheduleWords,
    Times,
    Until,
    Weekly,
    hour_within,
)

_DIGITS = {char: number for number, char in enumerate("零一二三四五六七八九")} | {"〇": 0, "两": 2}
_NUMBER = r"(?:\d{1,4}|[一二两三四五六七八九]?十[一二三四五六七八九]?|[零〇一二两三四五六七八九])"
_UNIT_S = {"秒": 1, "分": 60, "小": 3600, "钟": 3600, "天": 86400}
_LONG_UNIT = r"分钟|小时|钟头|天"
_UNIT = rf"秒钟?|{_LONG_UNIT}"
_DURATION = rf"(?:半个?(?:小时|钟头)|{_NUMBER}个?半?(?:{_UNIT}))"
_LONG_DURATION = rf"(?:半个?(?:小时|钟头)|{_NUMBER}个?半?(?:{_LONG_UNIT}))"
_PART = r"早上|早晨|清晨|凌晨|上午|中午|下午|傍晚|晚上|夜里"
#: The hours of each part of the day.
_HOURS = {
    **dict.fromkeys(("早上", "早晨"), range(4, 12)),
    "清晨": range(3, 9),
    "凌晨": range(1, 6),
    "上午": range(6, 13),
    "中午": range(11, 15),
    "下午": range(12, 19),
    "傍晚": range(16, 21),
    "晚上": range(17, 24),
    "夜里": range(20, 24),
}
#: Not the direction of a clock: 三点钟方向.
_NO_DIRECTION = r"(?!\s*(?:钟|整)?\s*的?(?:方向|方位|位置|米|度|个|步))"
#: 一点 alone is "a little".
_CLOCK = (
    rf"(?:(?:{_PART})\s*|(?!一点(?![钟整半一二三四五零\d])))(?:\d{{1,2}}:\d{{2}}(?![\d:])|{_NUMBER}(?:点钟?|时(?!候|间))"
    rf"(?:整|半|一刻|三刻|零?{_NUMBER}分?(?![米度秒步次个圈钟]))?){_NO_DIRECTION}"
)
_WEEK = r"(?:周|星期|礼拜)"
_WEEKDAY = "[一二三四五六日天]"
_DATE = rf"\d{{4}}-\d{{2}}-\d{{2}}|(?:\d{{4}}年)?{_NUMBER}月{_NUMBER}[日号]"
_ONE_DAY = (
    rf"今天|今日|明天|明日|后天|今早|今晚|明早|明晚|(?:这|本|这个)?{_WEEK}{_WEEKDAY}|下个?{_WEEK}{_WEEKDAY}|{_DATE}"
)
_WEEKLY = (
    rf"每天|每日|天天|每个?工作日|工作日|每个?周末|(?:每个?)?{_WEEK}一[到至]{_WEEK}?[二三四五六日天]"
    rf"|每个?(?:{_PART}|早|晚)|每个?{_WEEK}{_WEEKDAY}(?:[、和,，]?(?:每个?)?{_WEEK}?{_WEEKDAY}(?![点月]))*"
)


def _number(text: str) -> int:
    if text.isdigit():
        return int(text)
    if "十" not in text:
        return _DIGITS[text]
    tens, _, ones = text.partition("十")
    return (_DIGITS[tens] if tens else 1) * 10 + (_DIGITS[ones] if ones else 0)


def _seconds(text: str) -> int:
    """十分钟, 半个小时, 两个半小时."""
    unit = re.search(rf"(?:{_UNIT})$", text)
    assert unit is not None
    one = _UNIT_S[unit[0][0]]
    number = re.match(_NUMBER, text)
    if number is None:
        return one // 2
    return _number(number[0]) * one + (one // 2 if "半" in text else 0)


def _clock(text: str) -> Clock | None:
    said = re.fullmatch(
        rf"(?P<part>{_PART})?\s*(?:(?P<h>\d{{1,2}}):(?P<m>\d{{2}})"
        rf"|(?P<hour>{_NUMBER})(?:点钟?|时)(?:整|(?P<half>半)|(?P<quarter>[一三])刻|零?(?P<minute>{_NUMBER})分?)?)",
        text.strip(),
    )
    if said is None:
        return None
    hour = int(said["h"]) if said["h"] else _number(said["hour"])
    minute = int(said["m"] or 0)
    if said["half"]:
        minute = 30
    elif said["quarter"]:
        minute = 15 if said["quarter"] == "一" else 45
    elif said["minute"]:
        minute = _number(said["minute"])
    return _in_part_of_day(hour, minute, said["part"] or "", two_digits=len(said["h"] or "") == 2)


def _in_part_of_day(hour: int, minute: int, part: str, two_digits: bool) -> Clock | None:
    """The time that is meant; None if it is not clear, such as 晚上两点."""
    if hour > 23 or minute > 59:
        return None
    exact = hour > 12 or hour == 0
    if part:
        within = hour_within(hour, _HOURS[part], exact=exact)
        return Clock(within, minute, exact=True) if within is not None else None
    return Clock(hour, minute, two_digits or hour >= 8 or hour == 0, exact=exact)


def _weekday(char: str) -> int:
    return 6 if char in "日天" else "一二三四五六".index(char)


def _date(text: str) -> Day | None:
    try:
        if re.match(r"\d{4}-", text):
            return Day(date=date.fromisoformat(text))
        said = re.fullmatch(rf"(?:(\d{{4}})年)?({_NUMBER})月({_NUMBER})[日号]", text)
        assert said is not None
        month, day = _number(said[2]), _number(said[3])
        return Day(date=date(int(said[1]), month, day)) if said[1] else Day(month_day=(month, day))
    except ValueError:
        return None


def _day(text: str) -> Day | None:
    text = text.strip()
    hours = _HOURS["晚上"] if text.endswith("晚") else _HOURS["早上"] if text.endswith("早") else range(0)
    if text[0] in "今明后":
        return Day(ahead="今明后".index(text[0]), hours=hours)
    if re.fullmatch(_DATE, text):
        return _date(text)
    return Day(weekday=_weekday(text[-1]), next_week=text.startswith("下"))


def _weekly(found: re.Match[str]) -> Part | None:
    said = found[0]
    if "工作日" in said:
        return Weekly(tuple(range(5)))
    if "周末" in said:
        return Weekly((5, 6))
    if re.match("每天|每日|天天", said):
        return Weekly(())
    if part := re.fullmatch(rf"每个?({_PART}|早|晚)", said):
        return Weekly((), _HOURS[{"早": "早上", "晚": "晚上"}.get(part[1], part[1])])
    named = [_weekday(char) for char in re.sub(_WEEK, "", said) if char in "一二三四五六日天"]
    if re.search("[到至]", said):
        return Weekly(tuple(range(named[0], named[-1] + 1)))
    return Weekly(tuple(sorted(set(named))))


def _at(found: re.Match[str]) -> Part | None:
    said = [_clock(one[0]) for one in re.finditer(_CLOCK, found["clocks"])]
    clocks = tuple(clock for clock in said if clock is not None)
    return At(clocks) if clocks and len(clocks) == len(said) else None


def _between(found: re.Match[str]) -> Part | None:
    start, end = _clock(found["start"]), _clock(found["end"])
    return Between(start, end) if start is not None and end is not None else None


def _until(found: re.Match[str]) -> Part | None:
    end = _day(found["day"]) if found["day"] else _clock(found["clock"])
    return Until(end) if end is not None else None


def _every(found: re.Match[str]) -> Part:
    said = found["every"]
    return Every(_seconds(said if re.match(rf"半|{_NUMBER}", said) else "一" + said))


def _except(found: re.Match[str]) -> Part | None:
    if found["date"]:
        day = _date(found["date"])
        return Except(day=day) if day is not None else None
    return Except(tuple(_weekday(char) for char in re.findall(rf"{_WEEK}({_WEEKDAY})", found[0])))


def _form(pattern: str, read: Callable[[re.Match[str]], Part | None], leads: bool = False) -> Form:
    return Form(re.compile(pattern), read, leads)


_APART = rf"(?:每次)?(?:间隔|相隔|隔)(?P<apart>{_DURATION})"
WORDS = ScheduleWords(
    forms=(
        _form(
            rf"(?:再?过|在)?(?P<time>{_DURATION})(?:之后|以后|后)(?![退面方边转])",
            lambda m: Delay(_seconds(m["time"])),
            leads=True,
        ),
        _form(rf"(?:再?过)(?P<time>{_LONG_DURATION})(?!后)", lambda m: Delay(_seconds(m["time"])), leads=True),
        _form(_ONE_DAY, lambda m: _day(m[0])),
        _form(rf"在?(?P<clocks>{_CLOCK}(?:(?:[、,，]|和){_CLOCK})*)(?:的时候|时)?", _at),
        _form(_WEEKLY, _weekly),
        _form(rf"每隔?(?P<every>半个?(?:小时|钟头)|(?:{_NUMBER})?个?半?(?:{_UNIT}))(?:一次)?", _every),
        _form(rf"(?:从|在)?(?P<start>{_CLOCK})[到至](?P<end>{_CLOCK})(?:之间|期间)?", _between),
        _form(rf"(?:直?到|至)(?:(?P<day>{_ONE_DAY})|(?P<clock>{_CLOCK}))(?:为止|结束|止)", _until),
        _form(rf"直到(?:(?P<day>{_ONE_DAY})|(?P<clock>{_CLOCK}))", _until),
        _form(
            rf"(?:一?共)?(?P<count>{_NUMBER})次[，,]?{_APART}",
            lambda m: Times(_number(m["count"]), _seconds(m["apart"])),
        ),
        _form(
            rf"(?P<total>一共|总共|共)?(?P<count>{_NUMBER})次",
            lambda m: Times(_number(m["count"]), total=bool(m["total"])),
        ),
        _form(
            rf"除了?(?:(?P<date>{_DATE})|(?:每个?)?{_WEEK}{_WEEKDAY}(?:[、和]{_WEEK}{_WEEKDAY})*)(?:以外|之外|外)?",
            _except,
        ),
    ),
    joint=r"[\s,，、的]*",
    begin=r"[\s,，、]*(?:(?:请|麻烦|你好|你)[\s,，、]*)*",
    hints=(
        r"每(?:天|日|晚|早|周|星期|礼拜|月|年|小时|分钟|个(?:工作日|周末|小时|星期|礼拜|月|早|晚))|每隔.{0,4}(?:天|小时|分钟|秒|钟头)"
        r"|每[0-9一二两三四五六七八九十半]{1,3}个?(?:天|小时|分钟|钟头)|工作日|周末|今晚|明天|明早|明晚|后天|明日|下个?(?:周|星期|礼拜|月)"
        rf"|(?:周|星期|礼拜){_WEEKDAY}|(?:^|[，。；,;\s])(?:再?过)?{_LONG_DURATION}(?:之后|以后|后)"
        rf"|昨[天日晚]|前天|上个?(?:周|星期|礼拜|月)|{_LONG_DURATION}(?:之|以)?前|再?过一会儿?|(?:{_PART})\s*(?:\d|{_NUMBER}点)|(?<![\d:])\d{{1,2}}:\d{{2}}(?![\d:])|{_NUMBER}点(?:半|钟(?!的?方)|整|{_NUMBER}分)|晚些时候|待会儿?|一会儿?之?后"
    ),
    vague=rf"(?:再?过)?(?:好?几|若干)个?(?:{_UNIT})(?:之?后|以后)?|再?过一会儿?|(?:待|等)?一?会儿(?:之?后|以后)?",
    qualifies_before=r"(?:大概|大约|差不多|不?晚于|不?早于|最晚|最早|至少|直到|除了|除非|或者?|还是|不|别|不要|从|每|隔|前后)$",
    qualifies_after=r"(?:左右|前后|上下|许|之前|以前|前(?![进走行跑移方面])|之后|以后|后(?![退面方边转走])|多(?!少)|整?或者?|还是|除非|如果"
    r"|要是|假如|只要|直到|永远|一直|为止|开始|起(?![立来身])|到)",
    present=r"现在|马上|立刻|立即|首先|先|直到|为止|除了",
    breaks=r"[.;:!?\n。；：！？](?=\s*\S)|[,，、]|然后|接着|再",
    amount=r"\d|米|步|度|圈|公尺",
    lists=r"(?:请)?(?:你的|我的|所有的?|显示|列出|查看|看|有哪些){0,4}(?:日程|日程表|定时任务)(?:有哪些|列表)?"
    r"|(?:你)?(?:现在)?(?:有没有|有|有什么|有哪些)(?:日程|定时任务|安排)(?:吗|么)?|(?:你)?(?:接下来|后面|之后)有(?:什么|哪些)(?:日程|安排)"
    r"|下(?:一)?次(?:运行|执行)?(?:是)?(?:什么时候|几点|何时)(?:运行|执行)?",
    cancels=r"(?:请)?(?:取消|撤销)(?:掉|它|这个?|吧|所有|日程|定时任务){0,4}",
    cancels_by_name=r"(?:请)?(?:取消|撤销)(?:掉|这个?|我的|所有){0,3}(?:日程|定时任务)吧?",
    cancels_some="(?:请|帮我|麻烦)*(?:取消|撤销)(?:(?!然后|再|并|接着)[^，。；,;！!？?\\n])+",
    renews=r"(?:请|好的?[,，]?)?(?:继续|续期|延期)(?:下去|它|这个?|吧|日程|定时任务){0,3}",
)
