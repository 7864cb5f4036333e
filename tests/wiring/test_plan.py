"""Sentences whose time is not clear or not possible: none of them moves a robot, now or later.

Most were written before the grammar was looked at. What the grammar asks about each is in
`tests/language/schedule/test_reading.py`, as far as it matters.
"""

from __future__ import annotations

import pytest

from agentrob.wiring.plan import describe_plan, plan_text

UNCLEAR = """
every 31st wave
on the 31st of every month at 9:00 wave
at 25:00 wave
at 9:75 wave
tomorrow at 25:00 wave
tomorrow at 13 pm wave
tomorrow at 0 am wave
next week sometime wave
sometime next week wave
sometime tomorrow wave
in -3 minutes wave
in 0 minutes wave
in minus three minutes wave
every second wave
every 2 seconds wave
every other minute wave
tomorrow yesterday at 9:00 wave
yesterday at 9:00 wave
yesterday wave
last friday at 9:00 wave
5 minutes ago wave
on 30 February at 9:00 wave
on February 31 at 9:00 wave
on 2026-02-30 at 9:00 wave
on 2026-13-01 at 9:00 wave
on 2020-01-01 at 9:00 wave
in a few minutes wave
in a while wave
wave in a few minutes
in a couple of minutes wave
in some minutes, wave
in a bit wave
in the next few minutes wave
in the next hour wave
within an hour wave
tonight at 12 wave
tonight at 1 wave
tomorrow night at 3 wave
tomorrow morning at 15:00 wave
tomorrow at 24:00 wave
in some hours wave
soon wave
later wave
later today wave
wave later
one day wave
at some point wave
around 9:00 tomorrow wave
tomorrow at about 9:00 wave
tomorrow before 9:00 wave
tomorrow after 9:00 wave
by tomorrow at 9:00 wave
no later than 17:00 wave
in 10 to 15 minutes wave
in 10 or 15 minutes wave
in 5 minutes or so wave
in 1.5 hours wave
in 2,5 hours wave
in two and a half hours wave
in 10 minutes and 30 seconds wave
in 1000000 minutes wave
every 0 minutes wave
every -5 minutes wave
every 5 to 10 minutes wave
every 1.5 hours wave
every few hours wave
every so often wave
every now and then wave
every time it rains wave
every morning wave
every morning at 25:00 wave
every evening wave
every night wave
every weekday wave
every weekday morning wave
every weekday but friday at 9:00 wave
every weekday at 9:00 unless it rains wave
every second tuesday at 9:00 wave
every first monday of the month at 9:00 wave
every month wave
every year on 24 December at 9:00 wave
every quarter wave
every fortnight at 9:00 wave
biweekly wave
twice daily wave
three times a week wave
every day at dawn wave
at sunset wave
tomorrow at lunch wave
tomorrow at half past wave
at the full hour wave
every full hour wave
on the hour wave
tomorrow at 9 tomorrow at 10 wave
tomorrow on friday at 9:00 wave
today and tomorrow at 9:00 wave
monday or tuesday at 9:00 wave
every day at 9 or 10:00 wave
every day at 9:00 not on sundays wave
every day at 9:00 until yesterday wave
every day at 9:00 until 2020-01-01 wave
every day at 9:00 until further notice wave
every day at 9:00 forever wave
every day at 9:00 for a week wave
every day at 9:00 for 3 days wave
every day at 9:00 starting tomorrow wave
from tomorrow every day at 9:00 wave
every hour 0 times wave
every hour -1 times wave
0 times, an hour apart, wave
100 times, an hour apart, wave
three times, a second apart, wave
three times, an hour apart, every day at 9:00 wave
every 15 minutes between 9 and 9 wave
every 15 minutes between 25:00 and 26:00 wave
every 15 minutes between noon and morning wave
every 15 minutes from 9 wave
between 9 and 17 wave
every day between 9 and 17 wave
when it gets dark wave
when I come home wave
if it is 9:00 wave
not tomorrow at 9:00 wave
don't wave tomorrow at 9:00
tomorrow at 9:00 do not wave
wave now and tomorrow at 9:00
wave tomorrow at 9:00 and at 10:00 sit
walk 1 m in 10 minutes
first wave, then at 15:30 sit
wave at 15:30 then sit
at 15:30 UTC wave
at 15:30 CET wave
tomorrow at 9:00 London time wave
tomorrow at 9:00 in New York wave
in 10 minutes tomorrow wave
at 9:00 in 10 minutes wave
the day before tomorrow at 9:00 wave
in the morning wave
this weekend wave
at the weekend at 9:00 wave
next month on the 3rd at 9:00 wave
on the 3rd at 9:00 wave
24/12 at 9:00 wave
12.24. at 9:00 wave
at 9 hours wave
at 0900 wave
at 9h30 wave
at 15.30 wave
tomorrow at quarter past nine wave
midnight wave
at midnight wave
tomorrow at midnight wave
明天昨天挥手
昨天九点挥手
前天九点挥手
上周五九点挥手
明天后天九点挥手
明天二十五点挥手
明天25:00挥手
明天9:75挥手
每天二十五点挥手
每月31号九点挥手
每个月挥手
每年挥手
每秒挥手
每两秒挥手
每隔几分钟挥手
每隔0分钟挥手
零分钟后挥手
几分钟后挥手
等一会儿挥手
明天晚上两点挥手
今晚十二点挥手
明天凌晨十二点挥手
过几分钟挥手
负三分钟后挥手
一百万分钟后挥手
待会挥手
过一会儿挥手
稍后挥手
晚点挥手
下周某个时候挥手
改天挥手
有空的时候挥手
明天中午前挥手
明天九点左右挥手
明天九点之前挥手
大概九点挥手
十到十五分钟后挥手
每五到十分钟挥手
隔天九点挥手
每隔一周九点挥手
每天早上挥手
每天晚上挥手
工作日挥手
每个工作日挥手
周末九点挥手
每周挥手
每周五挥手
每周五和明天九点挥手
二月三十日九点挥手
13月1日九点挥手
日落时挥手
天黑以后挥手
下雨就挥手
明天九点别挥手
现在和明天九点挥手
每天九点直到永远挥手
每天九点到昨天为止挥手
每小时零次挥手
一百次，每次间隔一小时，挥手
三次，每次间隔一秒，挥手
9点到17点之间挥手
每天9点到17点挥手
北京时间九点挥手
纽约时间明天九点挥手
走一米，明天九点再挥手
先挥手，十分钟后坐下
挥手然后明天九点坐下
""".strip().splitlines()


@pytest.mark.parametrize("text", UNCLEAR)
def test_law_18_an_unclear_or_impossible_time_moves_nothing_now_or_later(text: str) -> None:
    told = plan_text(text, "go2", "Europe/Berlin")
    assert told["intent"] != "command"
    assert (told["plan"], "schedule" in told) == ([], False)


@pytest.mark.parametrize("text", ["yesterday you walked 2 m", "it waved at 9 yesterday", "昨天你走了两米"])
def test_a_report_of_the_past_is_not_asked_about_its_time(text: str) -> None:
    assert plan_text(text, "go2")["intent"] == "nothing"


def test_the_parts_of_a_post_to_several_robots_are_shown() -> None:
    shown = describe_plan(plan_text("@rex walk 1 m, then @bot or @cat wave", "go2"))
    assert shown.splitlines() == [
        "command",
        "  part 1: @rex",
        "    1. move direction=forward distance_m=1.0",
        "  part 2: @bot or @cat, after part 1",
        "    1. hello",
    ]
    asked = describe_plan(plan_text("when @rex is done, @bot wave", "go2"))
    assert asked.startswith("ask_back\n  it would answer: I can only wait for what the same post asks of `rex`")
