"""How English speaks of times."""

from __future__ import annotations

import re
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

_NAMED = (
    "one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen "
    "eighteen nineteen twenty"
)
_NUMBERS = {word: number for number, word in enumerate(_NAMED.split(), 1)}
_NUMBERS |= {"a": 1, "an": 1, "thirty": 30, "forty": 40, "forty-five": 45, "fifty": 50, "sixty": 60, "ninety": 90}
_COUNTED = r"\d{1,5}|forty[- ]five|" + "|".join(sorted(_NUMBERS, key=len, reverse=True))
_UNITS = {"s": 1, "m": 60, "h": 3600, "d": 86400}
_UNIT = r"seconds?|secs?|minutes?|mins?|hours?|hrs?|h|days?"
_LONGER_UNIT = r"minutes?|mins?|hours?|hrs?|h|days?"
_WEEKDAYS = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_WEEKDAY = r"(?:mon|tues|wednes|thurs|fri|satur|sun)day|mon|tues?|wed|thur?s?|fri|sat|sun"
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_MONTH = (
    r"january|february|march|april|may|june|july|august|september|october|november|december|"
    r"jan|feb|mar|apr|jun|jul|aug|sept?|oct|nov|dec"
)
_DATE = (
    rf"\d{{4}}-\d{{2}}-\d{{2}}|(?:the )?\d{{1,2}}(?:st|nd|rd|th)?(?: of)? (?:{_MONTH})"
    rf"|(?:{_MONTH}) \d{{1,2}}(?:st|nd|rd|th)?"
)
_HALF = r"(?:a\.?m\b\.?|p\.?m\b\.?|in the (?:morning|afternoon|evening)|at night)"
#: The hours of a part of the day; what else is said with it is asked about.
_HOURS = {
    "morning": range(1, 12),
    "afternoon": range(12, 19),
    "evening": range(17, 24),
    "night": range(18, 24),
}
_PART_OF_DAY = f"(?:{'|'.join(_HOURS)})"
_OCLOCK = r"o['’]?\s?clock"
_HOUR_WORD = "one|two|three|four|five|six|seven|eight|nine|ten|eleven|twelve"
#: Not the beginning of an amount: "at 0.5 m/s", "at 5 metres".
_NO_AMOUNT = (
    r"(?![\w:/%°]|\.\d|\s*(?:/|%|°|(?:m|cm|mm|km|in|inch|inches|ft|feet|foot|met(?:er|re)s?|centimet(?:er|re)s?"
    r"|yards?|degrees?|deg|mps|kmh|kph|steps?|times?|percent|seconds?|minutes?|hours?|per)\b))"
)
_CLOCK = (
    rf"(?:(?:noon|midnight)\b|\d{{1,2}}:\d{{2}}(?:\s?{_HALF})?{_NO_AMOUNT}"
    rf"|(?:\d{{1,2}}|{_HOUR_WORD})(?:\s?{_OCLOCK})?(?:\s?{_HALF})?{_NO_AMOUNT})"
)
#: Not "or": which of them is meant?
_AND = r"\s*(?:,\s*and|,|and|&)\s+"
_DAYS = rf"(?:{_WEEKDAY})(?:{_AND}(?:{_WEEKDAY}))*"
_PLURALS = rf"(?:(?:mon|tues|wednes|thurs|fri|satur|sun)days)(?:{_AND}(?:mon|tues|wednes|thurs|fri|satur|sun)days)*"
_RANGE = rf"(?:{_WEEKDAY})s?\s*(?:to|till|until|through|-|–)\s*(?:{_WEEKDAY})s?"
#: "An hour and a half" is not an hour.
_NO_MORE = rf"(?!\w|\s*(?:,|and)?\s*(?:a half|a quarter|half|\d|(?:{_COUNTED})\s(?:{_UNIT})\b))"
_DURATION = rf"(?:half an hour|(?:{_COUNTED})\s?(?:{_UNIT})){_NO_MORE}"
_LONG_DURATION = rf"(?:half an hour|(?:{_COUNTED})\s?(?:{_LONGER_UNIT})){_NO_MORE}"
_ONE_DAY = (
    r"today|tonight|tomorrow(?: (?:morning|afternoon|evening|night))?|this (?:morning|afternoon|evening)"
    r"|(?:the )?day after tomorrow"
    rf"|(?:on |this )?(?:{_WEEKDAY})(?: (?:morning|afternoon|evening|night))?|(?:on )?(?:{_DATE})"
)


def _number(word: str) -> int:
    word = word.lower().replace(" ", "-")
    return int(word) if word.isdigit() else _NUMBERS[word]


def _seconds(text: str) -> int:
    """ "10 minutes", "an hour", "half an hour"."""
    text = text.lower().strip()
    if text.startswith("half"):
        return 1800
    found = re.fullmatch(rf"({_COUNTED})\s?({_UNIT})", text)
    assert found is not None
    return _number(found[1]) * _UNITS[found[2][0]]


def _clock(text: str) -> Clock | None:
    text = text.lower().strip()
    if text in ("noon", "midnight"):
        return Clock(12) if text == "noon" else Clock(0, midnight=True)
    found = re.match(rf"(\d{{1,2}}|{_HOUR_WORD})(?::(\d{{2}}))?", text)
    assert found is not None
    hour, minute, rest = _number(found[1]), int(found[2] or 0), text[found.end() :]
    if minute > 59 or hour > 24:
        return None
    if half := re.search(r"\b([ap])\.?m", rest):
        return Clock(hour % 12 + (12 if half[1] == "p" else 0), minute, exact=True) if 1 <= hour <= 12 else None
    exact = hour > 12 or hour == 0 or found[1].startswith("0")
    if hours := _hours(rest):
        within = hour_within(hour, hours, exact=exact)
        return Clock(within, minute, exact=True) if within is not None else None
    if hour == 24:
        return Clock(0, midnight=True) if minute == 0 and found[2] is not None else None
    sure = len(found[1]) == 2 or hour >= 8 or hour == 0
    return Clock(hour, minute, sure and not re.match(r"\s?o", rest), exact=exact, bare=found[2] is None)


def _hours(text: str) -> range:
    """The hours of the part of the day that a text names; empty if it names none."""
    return next((hours for word, hours in _HOURS.items() if word in text), range(0))


def _day_number(word: str) -> int:
    return next(n for n, day in enumerate(_WEEKDAYS) if day.startswith(word.lower()[:3]))


def _days(text: str) -> tuple[int, ...]:
    return tuple(sorted({_day_number(found[0]) for found in re.finditer(_WEEKDAY, text, re.IGNORECASE)}))


def _date(text: str) -> Day | None:
    if re.match(r"\d{4}-", text):
        try:
            return Day(date=date.fromisoformat(text))
        except ValueError:
            return None
    day = re.search(r"\d{1,2}", text)
    month = re.search(_MONTH, text, re.IGNORECASE)
    assert day is not None
    assert month is not None
    return Day(month_day=(_MONTHS.index(month[0].lower()[:3]) + 1, int(day[0])))


def _day(text: str) -> Day | None:
    text = re.sub(r"^(?:on|this) (?!morning|afternoon|evening)", "", text.lower().strip())
    hours = _hours(text)
    if "day after tomorrow" in text:
        return Day(ahead=2)
    if text.startswith(("today", "tonight", "this ")):
        return Day(ahead=0, hours=hours)
    if text.startswith("tomorrow"):
        return Day(ahead=1, hours=hours)
    if re.fullmatch(_DATE, text):
        return _date(text)
    return Day(weekday=_day_number(text), hours=hours)


def _at(found: re.Match[str]) -> Part | None:
    said = [_clock(one[0]) for one in re.finditer(_CLOCK, found["clocks"], re.IGNORECASE)]
    clocks = tuple(clock for clock in said if clock is not None)
    return At(clocks) if clocks and len(clocks) == len(said) else None


def _weekly(found: re.Match[str]) -> Part | None:
    said = found[0].lower()
    return None if (days := _weekly_days(said)) is None else Weekly(days, _hours(said))


def _weekly_days(said: str) -> tuple[int, ...] | None:
    if re.search(_RANGE, said):
        days = [_day_number(one[0]) for one in re.finditer(_WEEKDAY, said)]
        return tuple(range(days[0], days[-1] + 1)) if len(days) == 2 and days[0] < days[1] else None
    if re.search("weekday|work", said):
        return tuple(range(5))
    if "weekend" in said:
        return 5, 6
    return _days(said) if re.search(_WEEKDAY, re.sub(r"\b(?:every|each) day|daily", "", said)) else ()


def _every(found: re.Match[str]) -> Part | None:
    said = found["every"].lower()
    if said.startswith(("half", "quarter")):
        return Every(1800 if said.startswith("half") else 900)
    number, unit = re.match(rf"(?:{_COUNTED})\b", said), re.search(rf"(?:{_UNIT})$", said)
    assert unit is not None
    count = 2 if said.startswith("other") else _number(number[0]) if number else 1
    return Every(count * _UNITS[unit[0][0]])


def _between(found: re.Match[str]) -> Part | None:
    start, end = _clock(found["start"]), _clock(found["end"])
    return Between(start, end) if start is not None and end is not None else None


def _until(found: re.Match[str]) -> Part | None:
    end = _day(found["day"]) if found["day"] else _clock(found["clock"])
    return Until(end) if end is not None else None


def _times(found: re.Match[str]) -> Part | None:
    said = found["count"].lower()
    count = {"once": 1, "twice": 2}.get(said) or _number(re.sub(r"\s*times$", "", said))
    apart_s = _seconds(found["apart"]) if found.groupdict().get("apart") else 0
    return Times(count, apart_s, total=bool(re.search(r"\bin (?:all|total)$", found[0], re.IGNORECASE)))


def _except(found: re.Match[str]) -> Part | None:
    if found["date"]:
        day = _date(found["date"])
        return Except(day=day) if day is not None else None
    return Except(_days(found[0].lower()))


def _form(pattern: str, read: object, leads: bool = False) -> Form:
    return Form(re.compile(rf"(?<![\w-])(?:{pattern})(?![\w-])", re.IGNORECASE), read, leads)  # type: ignore[arg-type]


_COUNT = rf"(?P<count>twice|(?:{_COUNTED}) times)"
WORDS = ScheduleWords(
    forms=(
        _form(
            rf"(?:in|after) (?P<time>{_DURATION})(?:['’]s?)?(?: time)?(?: from now)?",
            lambda m: Delay(_seconds(m["time"])),
            leads=True,
        ),
        _form(rf"in (?P<time>{_LONG_DURATION})(?: from now)?", lambda m: Delay(_seconds(m["time"]))),
        _form(rf"(?P<time>{_DURATION}) (?:from now|later)", lambda m: Delay(_seconds(m["time"])), leads=True),
        _form(rf"(?P<time>{_LONG_DURATION}) from now", lambda m: Delay(_seconds(m["time"]))),
        _form(_ONE_DAY, lambda m: _day(m[0])),
        _form(rf"at (?P<clocks>{_CLOCK}(?:{_AND}(?:at )?{_CLOCK})*)", _at),
        _form(
            rf"(?:every|each) (?:{_PART_OF_DAY}|(?:day|weekday|work(?:ing )?day|weekend|{_DAYS})(?: {_PART_OF_DAY})?)"
            rf"|daily|on (?:weekdays|work(?:ing )?days"
            rf"|weekends|{_PLURALS})|(?:from |(?:every day )?from )?(?:{_RANGE})|{_PLURALS}",
            _weekly,
        ),
        _form(
            rf"every (?P<every>(?:half(?: an)?|quarter(?: of an)?)[ -]hour|(?:(?:{_COUNTED}|other) )?(?:{_UNIT}))"
            rf"{_NO_MORE}",
            _every,
        ),
        _form("hourly", lambda _: Every(3600)),
        _form(rf"between (?P<start>{_CLOCK}) and (?P<end>{_CLOCK})", _between),
        _form(rf"from (?P<start>{_CLOCK}) (?:to|till|until) (?P<end>{_CLOCK})", _between),
        _form(rf"(?:until|till) (?:(?P<day>(?:the )?(?:{_ONE_DAY}))|(?P<clock>{_CLOCK}))", _until),
        _form(rf"{_COUNT},? (?P<apart>{_DURATION}) apart", _times),
        _form(rf"(?:for (?=\w+ times))?{_COUNT}(?: in (?:all|total))?", _times),
        _form(rf"except (?:for )?(?:on )?(?:(?P<date>{_DATE})|{_PLURALS}|{_DAYS})", _except),
    ),
    joint=r"[\s,]*(?:\band\b\s*)?",
    begin=r"[\s,]*(?:(?:please|ok|okay|hi|hey|hello)\b[\s,!]*)*",
    hints=(
        rf"\b(?:every|each) (?:(?:other|second|{_COUNTED}) )?(?:day|week|month|year|morning|afternoon|evening|night"
        rf"|noon|weekday|work(?:ing )?day|weekend|hour|minute|min|{_WEEKDAY})s?\b"
        r"|\b(?:daily|hourly|weekly|monthly|nightly|tomorrow|tonight|o'?clock in the|from now on|noon|midnight)\b"
        rf"|\b(?:once|twice|{_COUNTED}(?: times)?) (?:a|per) (?:day|week|hour|month|minute)\b"
        rf"|\b(?:in|after|within) (?:{_COUNTED}|half an|a few|some|a couple of|several) ?(?:{_LONGER_UNIT})\b"
        rf"|\bat \d{{1,2}}:\d{{2}}\b|\bat \d{{1,2}} ?(?:a\.?m|p\.?m)\b|\d{{1,2}}:\d{{2}} ?(?:a\.?m|p\.?m|o'?clock)\b"
        rf"|\b(?:on|next|this|until|till|by|before) (?:{_WEEKDAY})s?\b|\b(?:{_WEEKDAY[: _WEEKDAY.index('|mon')]})s?\b"
        rf"|\b(?:{_COUNTED}) ?(?:{_LONGER_UNIT}) (?:apart|later|from now)\b"
        r"|\bnext (?:week|month|year|hour)\b|\blater today\b"
        rf"|\b(?:every|each|on the) \d{{1,2}}(?:st|nd|rd|th)\b|\b(?:day before )?yesterday\b"
        rf"|\b(?:{_COUNTED}|half an|a few) ?(?:{_LONGER_UNIT}) ago\b"
    ),
    vague=rf"(?:in|after|within) (?:(?:the next )?(?:a )?(?:few|couple(?: of)?|some|several)(?: more)? (?:{_UNIT})"
    rf"|the next (?:{_UNIT})|a (?:little )?(?:bit|while|moment|jiffy)(?! of\b))\b",
    qualifies_before=r"\b(?:about|roughly|approximately|circa|before|after|by|until|till|than|between|past|since|except"
    r"|unless|if|when|every|each|next|last|not|or|from|(?<!turn )(?<!look )(?<!spin )(?<!walk )(?<!go )around)$",
    qualifies_after=r"(?:or\b|ish\b|sharp\b|at the (?:latest|earliest)\b|not\b|but\b|unless\b|if\b|when(?:ever)?\b"
    r"|while\b|before\b|after\b|from\b|by\b|to \d|start(?:ing|s)?\b|begin(?:ning|s)?\b|as of\b|provided\b"
    r"|for ?ever\b|always\b|indefinitely\b|for (?:\w+ ){0,2}(?:day|week|month|year)s?\b"
    r"|(?:utc|gmt|bst|ist|jst|msk|[pmce][sd]t|[cew]e[ts]t?|a[ce][sd]t)\b|(?:[\w/'’]+ ){1,3}time\b"
    r"|in (?:the )?(?:[a-z]+ ){0,2}(?:time ?zone|utc|gmt)\b|-?\d+ times\b)",
    present=r"\b(?:now|right away|immediately|at once|already|straight away|first|until|till|except|between)\b",
    breaks=r"[.;:!?\n](?=\s*\S)|,|\bthen\b",
    amount=r"\d|\b(?:met(?:er|re)s?|feet|foot|steps?|degrees?)\b",
    lists=r"(?:please )?(?:(?:show|list|what are)(?: me)? )?(?:the |your |my |all ){0,3}schedules?(?: please)?"
    r"|what(?:'s| is| do you have| have you got) (?:on your schedule|scheduled)"
    r"|(?:what|when)(?:'s| is| are) (?:your|the) next (?:scheduled )?runs?"
    r"|(?:do you have|are there|have you got) any schedules",
    cancels=r"(?:please )?(?:cancel|cancelled|call it off|unschedule)"
    r"(?: (?:it|this|that|all|(?:the |this |that |all ){0,3}(?:schedules?|runs?)))?(?: please)?",
    cancels_by_name=r"(?:please )?(?:cancel|unschedule|delete|remove|end) (?:(?:the|this|that|my|all) ){0,3}schedules?"
    r"(?: please)?",
    cancels_some=r"(?:(?:please|can you|could you) )?(?:cancel|unschedule) (?:(?!\b(?:and|then|but)\b)[^,;!?\n])+",
    renews=r"(?:please |yes,? )?(?:keep (?:it |this )?(?:on|going)|(?:renew|continue|extend)"
    r"(?: (?:it|this|that|(?:(?:the|this|that|my) )?schedule))?)(?: please)?",
)
