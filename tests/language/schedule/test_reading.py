"""Which posts say when, what they say, and what is asked back. What is not wholly understood is never scheduled."""

from __future__ import annotations

import re
from datetime import datetime, timedelta
from itertools import pairwise
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.registry import known
from agentrob.language.schedule.reading import cancels_elsewhere, cancels_schedule, lists_schedules, timed_text
from agentrob.model import Schedule
from agentrob.model.schedules import first_runs

ZONE = "Europe/Berlin"
#: A Tuesday.
NOW = datetime(2026, 11, 24, 10, 0, tzinfo=ZoneInfo(ZONE))

#: A post, its command, the first three runs (weekday, day, time) and how many there are.
UNDERSTOOD = [
    ("in 10 minutes wave", "wave", ["Tue 24 10:10:00"], 1),
    ("wave in 10 minutes", "wave", ["Tue 24 10:10:00"], 1),
    ("in half an hour, please wave.", "please wave.", ["Tue 24 10:30:00"], 1),
    ("in 10 seconds, wave", "wave", ["Tue 24 10:00:10"], 1),
    ("please in an hour wave", "wave", ["Tue 24 11:00:00"], 1),
    ("in 2 hours walk 1 m, then turn left", "walk 1 m, then turn left", ["Tue 24 12:00:00"], 1),
    ("at 15:30 take a photo", "take a photo", ["Tue 24 15:30:00"], 1),
    ("at 3:30 pm take a photo", "take a photo", ["Tue 24 15:30:00"], 1),
    ("take a photo at 15:30", "take a photo", ["Tue 24 15:30:00"], 1),
    ("tomorrow at 9 wave", "wave", ["Wed 25 09:00:00"], 1),
    ("wave tomorrow at 9", "wave", ["Wed 25 09:00:00"], 1),
    ("tomorrow at 9 and 15:00 wave", "wave", ["Wed 25 09:00:00", "Wed 25 15:00:00"], 2),
    ("tomorrow at 3pm wave", "wave", ["Wed 25 15:00:00"], 1),
    ("tonight at 8 wave", "wave", ["Tue 24 20:00:00"], 1),
    ("the day after tomorrow at noon sit", "sit", ["Thu 26 12:00:00"], 1),
    ("on Friday at 9 in the morning sit", "sit", ["Fri 27 09:00:00"], 1),
    ("on Tuesday at 9 sit", "sit", ["Tue 01 09:00:00"], 1),
    ("on Tuesday at 11 sit", "sit", ["Tue 24 11:00:00"], 1),
    ("on 24 December at 9:00 wave", "wave", ["Thu 24 09:00:00"], 1),
    ("on 2026-12-01 at 9:00 wave", "wave", ["Tue 01 09:00:00"], 1),
    ("every day at 9 wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("every weekday at 9 take a photo", "take a photo", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("take a photo every weekday at 9", "take a photo", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("every morning at 8 wave", "wave", ["Wed 25 08:00:00", "Thu 26 08:00:00", "Fri 27 08:00:00"], 30),
    ("wave each evening at 7", "wave", ["Tue 24 19:00:00", "Wed 25 19:00:00", "Thu 26 19:00:00"], 30),
    ("every friday night at 11 sit", "sit", ["Fri 27 23:00:00", "Fri 04 23:00:00", "Fri 11 23:00:00"], 30),
    ("every quarter of an hour wave", "wave", ["Tue 24 10:15:00", "Tue 24 10:30:00", "Tue 24 10:45:00"], 30),
    ("每晚八点挥手", "挥手", ["Tue 24 20:00:00", "Wed 25 20:00:00", "Thu 26 20:00:00"], 30),
    ("每早七点半拍照", "拍照", ["Wed 25 07:30:00", "Thu 26 07:30:00", "Fri 27 07:30:00"], 30),
    ("Monday to Friday at 9:00 wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("every monday and thursday at 10:15 sit", "sit", ["Thu 26 10:15:00", "Mon 30 10:15:00", "Thu 03 10:15:00"], 30),
    ("mondays at 9 wave", "wave", ["Mon 30 09:00:00", "Mon 07 09:00:00", "Mon 14 09:00:00"], 30),
    ("every weekend at 12:00 wave", "wave", ["Sat 28 12:00:00", "Sun 29 12:00:00", "Sat 05 12:00:00"], 30),
    ("every day at 8:00 and 17:00 wave", "wave", ["Tue 24 17:00:00", "Wed 25 08:00:00", "Wed 25 17:00:00"], 30),
    ("every day at 9 until Friday wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("every day at 9 except on Fridays wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Sat 28 09:00:00"], 30),
    ("every 15 minutes between 9 and 17 wave", "wave", ["Tue 24 10:00:00", "Tue 24 10:15:00", "Tue 24 10:30:00"], 30),
    (
        "take a photo every 15 minutes between 9 and 17 on weekdays until Friday", "take a photo",
        ["Tue 24 10:00:00", "Tue 24 10:15:00", "Tue 24 10:30:00"], 30,
    ),
    ("every hour until 17:00 wave", "wave", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("hourly, wave", "wave", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("every hour, three times, wave", "wave", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 3),
    ("wave every hour, three times", "wave", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 3),
    ("wave three times every hour", "wave three times", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("every hour wave three times", "wave three times", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("three times, an hour apart, wave", "wave", ["Tue 24 10:00:00", "Tue 24 11:00:00", "Tue 24 12:00:00"], 3),
    ("wave three times, an hour apart", "wave", ["Tue 24 10:00:00", "Tue 24 11:00:00", "Tue 24 12:00:00"], 3),
    ("tomorrow at 9, twice, an hour apart, wave", "wave", ["Wed 25 09:00:00", "Wed 25 10:00:00"], 2),
    ("十分钟后挥手", "挥手", ["Tue 24 10:10:00"], 1),
    ("请在十分钟后挥手", "挥手", ["Tue 24 10:10:00"], 1),
    ("半小时后挥手", "挥手", ["Tue 24 10:30:00"], 1),
    ("两个半小时后挥手", "挥手", ["Tue 24 12:30:00"], 1),
    ("十秒后挥手", "挥手", ["Tue 24 10:00:10"], 1),
    ("五分钟后向前走两米，然后挥手", "向前走两米，然后挥手", ["Tue 24 10:05:00"], 1),
    ("明天早上九点挥手", "挥手", ["Wed 25 09:00:00"], 1),
    ("明天早上九点，请挥手", "请挥手", ["Wed 25 09:00:00"], 1),
    ("今晚八点挥手", "挥手", ["Tue 24 20:00:00"], 1),
    ("下周五晚上八点坐下", "坐下", ["Fri 04 20:00:00"], 1),
    ("12月24日九点挥手", "挥手", ["Thu 24 09:00:00"], 1),
    ("每个工作日九点拍照", "拍照", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("周一到周五9:00拍照", "拍照", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("每天下午三点半拍张照片", "拍张照片", ["Tue 24 15:30:00", "Wed 25 15:30:00", "Thu 26 15:30:00"], 30),
    ("每周一和周三上午十点挥手", "挥手", ["Wed 25 10:00:00", "Mon 30 10:00:00", "Wed 02 10:00:00"], 30),
    ("每隔15分钟从9点到17点拍照", "拍照", ["Tue 24 10:00:00", "Tue 24 10:15:00", "Tue 24 10:30:00"], 30),
    ("每隔一小时三次拍照", "拍照", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 3),
    ("每小时挥手，到周五为止", "挥手", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("挥手三次，每次间隔一小时", "挥手", ["Tue 24 10:00:00", "Tue 24 11:00:00", "Tue 24 12:00:00"], 3),
    ("tonight at 20:00 wave", "wave", ["Tue 24 20:00:00"], 1),
    ("tonight at 11 wave", "wave", ["Tue 24 23:00:00"], 1),
    ("tomorrow night at 9 wave", "wave", ["Wed 25 21:00:00"], 1),
    ("tomorrow morning at 7 wave", "wave", ["Wed 25 07:00:00"], 1),
    ("tomorrow morning at 7:30 wave", "wave", ["Wed 25 07:30:00"], 1),
    ("tomorrow afternoon at 3 wave", "wave", ["Wed 25 15:00:00"], 1),
    ("tomorrow afternoon at 12:30 wave", "wave", ["Wed 25 12:30:00"], 1),
    ("this evening at 6 wave", "wave", ["Tue 24 18:00:00"], 1),
    ("tomorrow at 9 at night wave", "wave", ["Wed 25 21:00:00"], 1),
    ("tomorrow at 11 in the evening wave", "wave", ["Wed 25 23:00:00"], 1),
    ("tomorrow at 3 in the morning wave", "wave", ["Wed 25 03:00:00"], 1),
    ("tomorrow at 12 am wave", "wave", ["Wed 25 00:00:00"], 1),
    ("tomorrow at 12 pm wave", "wave", ["Wed 25 12:00:00"], 1),
    ("every day at midnight wave", "wave", ["Wed 25 00:00:00", "Thu 26 00:00:00", "Fri 27 00:00:00"], 30),
    ("every day at 24:00 wave", "wave", ["Wed 25 00:00:00", "Thu 26 00:00:00", "Fri 27 00:00:00"], 30),
    ("every day at 6 pm wave", "wave", ["Tue 24 18:00:00", "Wed 25 18:00:00", "Thu 26 18:00:00"], 30),
    ("every day at 12:30 wave", "wave", ["Tue 24 12:30:00", "Wed 25 12:30:00", "Thu 26 12:30:00"], 30),
    ("every day at 00:00 wave", "wave", ["Wed 25 00:00:00", "Thu 26 00:00:00", "Fri 27 00:00:00"], 30),
    ("every sunday at noon wave", "wave", ["Sun 29 12:00:00", "Sun 06 12:00:00", "Sun 13 12:00:00"], 30),
    ("saturdays and sundays at 10:00 wave", "wave", ["Sat 28 10:00:00", "Sun 29 10:00:00", "Sat 05 10:00:00"], 30),
    ("every tuesday at 8 am and 6 pm wave", "wave", ["Tue 24 18:00:00", "Tue 01 08:00:00", "Tue 01 18:00:00"], 30),
    ("on monday at 8:30 wave", "wave", ["Mon 30 08:30:00"], 1),
    ("friday at 17:00 wave", "wave", ["Fri 27 17:00:00"], 1),
    ("on 1 December at 8:00 wave", "wave", ["Tue 01 08:00:00"], 1),
    ("December 1st at 8:00 wave", "wave", ["Tue 01 08:00:00"], 1),
    ("on the 1st of December at 8:00 wave", "wave", ["Tue 01 08:00:00"], 1),
    ("on Jan 2 at 8:00 wave", "wave", ["Sat 02 08:00:00"], 1),
    ("every 30 minutes wave", "wave", ["Tue 24 10:30:00", "Tue 24 11:00:00", "Tue 24 11:30:00"], 30),
    ("every half hour wave", "wave", ["Tue 24 10:30:00", "Tue 24 11:00:00", "Tue 24 11:30:00"], 30),
    ("every 2 hours wave", "wave", ["Tue 24 12:00:00", "Tue 24 14:00:00", "Tue 24 16:00:00"], 30),
    ("every day at 9:00, 3 times, wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 3),
    ("every day at 9:00 until 5 December wave", "wave", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    (
        "every day at 9:00 except on 24 December wave", "wave",
        ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30,
    ),
    (
        "every weekday at 9:00 except on Mondays wave", "wave",
        ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30,
    ),
    (
        "every 20 minutes from 9:00 to 11:00 on weekdays wave", "wave",
        ["Tue 24 10:00:00", "Tue 24 10:20:00", "Tue 24 10:40:00"], 30,
    ),
    ("every hour between noon and 6 pm wave", "wave", ["Tue 24 12:00:00", "Tue 24 13:00:00", "Tue 24 14:00:00"], 30),
    ("in an hour, twice, 10 minutes apart, wave", "wave", ["Tue 24 11:00:00", "Tue 24 11:10:00"], 2),
    (
        "at 15:30, three times, 5 minutes apart, wave", "wave",
        ["Tue 24 15:30:00", "Tue 24 15:35:00", "Tue 24 15:40:00"], 3,
    ),
    ("tomorrow at 10:00, 15:00 and 20:00 wave", "wave", ["Wed 25 10:00:00", "Wed 25 15:00:00", "Wed 25 20:00:00"], 3),
    ("90 minutes from now wave", "wave", ["Tue 24 11:30:00"], 1),
    ("please wave in 20 minutes", "please wave", ["Tue 24 10:20:00"], 1),
    ("turn around tomorrow at 9:00", "turn around", ["Wed 25 09:00:00"], 1),
    ("look around tomorrow at 9:00", "look around", ["Wed 25 09:00:00"], 1),
    ("take a photo at 23:59", "take a photo", ["Tue 24 23:59:00"], 1),
    ("at noon wave", "wave", ["Tue 24 12:00:00"], 1),
    ("in 24 hours wave", "wave", ["Wed 25 10:00:00"], 1),
    ("in 2 days wave", "wave", ["Thu 26 10:00:00"], 1),
    ("明早七点挥手", "挥手", ["Wed 25 07:00:00"], 1),
    ("明晚八点半挥手", "挥手", ["Wed 25 20:30:00"], 1),
    ("今晚二十点挥手", "挥手", ["Tue 24 20:00:00"], 1),
    ("明天凌晨三点挥手", "挥手", ["Wed 25 03:00:00"], 1),
    ("明天中午十二点挥手", "挥手", ["Wed 25 12:00:00"], 1),
    ("明天中午一点挥手", "挥手", ["Wed 25 13:00:00"], 1),
    ("明天上午十二点挥手", "挥手", ["Wed 25 12:00:00"], 1),
    ("明天下午两点一刻挥手", "挥手", ["Wed 25 14:15:00"], 1),
    ("明天夜里十点挥手", "挥手", ["Wed 25 22:00:00"], 1),
    ("明天傍晚六点挥手", "挥手", ["Wed 25 18:00:00"], 1),
    ("后天上午十点二十分挥手", "挥手", ["Thu 26 10:20:00"], 1),
    ("周六下午三点挥手", "挥手", ["Sat 28 15:00:00"], 1),
    ("下周一早上八点挥手", "挥手", ["Mon 30 08:00:00"], 1),
    ("12月1日8:00挥手", "挥手", ["Tue 01 08:00:00"], 1),
    ("2026-12-01 8:00挥手", "挥手", ["Tue 01 08:00:00"], 1),
    ("每天早上七点挥手", "挥手", ["Wed 25 07:00:00", "Thu 26 07:00:00", "Fri 27 07:00:00"], 30),
    ("每天0:00挥手", "挥手", ["Wed 25 00:00:00", "Thu 26 00:00:00", "Fri 27 00:00:00"], 30),
    ("每周六周日十点挥手", "挥手", ["Sat 28 10:00:00", "Sun 29 10:00:00", "Sat 05 10:00:00"], 30),
    ("每周一、周三、周五九点挥手", "挥手", ["Wed 25 09:00:00", "Fri 27 09:00:00", "Mon 30 09:00:00"], 30),
    ("每周二早上八点和下午六点挥手", "挥手", ["Tue 24 18:00:00", "Tue 01 08:00:00", "Tue 01 18:00:00"], 30),
    ("每隔两小时挥手", "挥手", ["Tue 24 12:00:00", "Tue 24 14:00:00", "Tue 24 16:00:00"], 30),
    ("每半小时挥手", "挥手", ["Tue 24 10:30:00", "Tue 24 11:00:00", "Tue 24 11:30:00"], 30),
    ("每30分钟挥手", "挥手", ["Tue 24 10:30:00", "Tue 24 11:00:00", "Tue 24 11:30:00"], 30),
    ("每小时挥手一次", "挥手一次", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 30),
    ("每小时挥手，一共五次", "挥手", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 5),
    ("每天九点挥手，到周五为止", "挥手", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("每天九点挥手，除了周日", "挥手", ["Wed 25 09:00:00", "Thu 26 09:00:00", "Fri 27 09:00:00"], 30),
    ("每隔20分钟从9点到11点拍照", "拍照", ["Tue 24 10:00:00", "Tue 24 10:20:00", "Tue 24 10:40:00"], 30),
    ("一小时后挥手", "挥手", ["Tue 24 11:00:00"], 1),
    ("再过二十分钟挥手", "挥手", ["Tue 24 10:20:00"], 1),
    ("过半小时挥手", "挥手", ["Tue 24 10:30:00"], 1),
    ("两天后挥手", "挥手", ["Thu 26 10:00:00"], 1),
    ("15:30挥手", "挥手", ["Tue 24 15:30:00"], 1),
    ("下午三点半挥手", "挥手", ["Tue 24 15:30:00"], 1),
    ("今天下午四点挥手", "挥手", ["Tue 24 16:00:00"], 1),
    ("明天九点和十五点挥手", "挥手", ["Wed 25 09:00:00", "Wed 25 15:00:00"], 2),
    ("明天九点后退一米", "后退一米", ["Wed 25 09:00:00"], 1),
    ("明天九点前进一米", "前进一米", ["Wed 25 09:00:00"], 1),
    ("明天九点向前走一米", "向前走一米", ["Wed 25 09:00:00"], 1),
    ("明天九点起立", "起立", ["Wed 25 09:00:00"], 1),
    ("明天早上九点转圈", "转圈", ["Wed 25 09:00:00"], 1),
    ("wave every hour, 3 times in total", "wave", ["Tue 24 11:00:00", "Tue 24 12:00:00", "Tue 24 13:00:00"], 3),
]  # fmt: skip

#: A post that says when in a way that is not understood, and words of the question.
ASKED = [
    ("tomorrow wave", "not the time"),
    ("every day wave", "not the time"),
    ("in 10 minutes", "not what to do"),
    ("tomorrow at 3 wave", "3:00 or 15:00"),
    ("every day at 5 wave", "5:00 or 17:00"),
    ("at 3 o'clock wave", "On which day"),
    ("wave at 9", "On which day"),
    ("at 9:30 wave", "09:30 is over"),
    ("every minute wave", "at least 5 minutes"),
    ("wave every 5 seconds", "at least 5 minutes"),
    ("40 times, an hour apart, wave", "1 to 30 runs"),
    ("in 90 days wave", "60 days"),
    ("every day at 9 until 2027-06-01 wave", "60 days"),
    ("every 15 minutes on weekdays wave", "Between which times"),
    ("every 15 minutes between 17:00 and 9:00 wave", "Between which times"),
    ("in an hour and a half wave", "did not understand when"),
    ("in 1 hour 30 minutes wave", "did not understand when"),
    ("every other day at 9 wave", "did not understand when"),
    ("twice a day wave", "did not understand when"),
    ("next friday at 9 wave", "did not understand when"),
    ("every day at noon until december 24th at 9 wave", "did not understand when"),
    ("every month at 9 wave", "did not understand when"),
    ("walk 2 m in 10 minutes", "did not understand when"),
    ("walk 1 m, then in 10 minutes wave", "did not understand when"),
    ("walk 1 m, wave at 15:30", "did not understand when"),
    ("wave at 15:30 and sit", "did not understand when"),
    ("tomorrow at 9, wave but now sit", "did not understand when"),
    ("tomorrow at 9 every day at 10:00 wave", "did not understand when"),
    ("in 5 minutes in 10 minutes wave", "did not understand when"),
    ("明天挥手", "没有听懂几点"),
    ("每天三点拍照", "3:00还是15:00"),
    ("每分钟挥手", "至少要间隔5分钟"),
    ("每月一号九点挥手", "没有听懂是什么时候"),
    ("挥手，明天坐下再九点挥手", "没有听懂是什么时候"),
    ("tonight at 12 wave", "not understand when"),
    ("tonight at 1 wave", "not understand when"),
    ("tonight at 8 am wave", "not understand when"),
    ("tonight at 08:00 wave", "not understand when"),
    ("tomorrow night at 3 wave", "not understand when"),
    ("tomorrow morning at 15:00 wave", "not understand when"),
    ("every morning at 15:00 wave", "not understand when"),
    ("every morning wave", "not the time"),
    ("每晚两点挥手", "没有听懂是什么时候"),
    ("tomorrow morning at 3 pm wave", "not understand when"),
    ("tomorrow morning at 12 wave", "not understand when"),
    ("tomorrow afternoon at 9 wave", "not understand when"),
    ("this evening at 3 wave", "not understand when"),
    ("tomorrow at 2 at night wave", "not the time"),
    ("tomorrow at 12 in the morning wave", "not the time"),
    ("tomorrow at 11 in the afternoon wave", "not the time"),
    ("tomorrow at 24:00 wave", "beginning or at the end"),
    ("tonight at midnight wave", "beginning or at the end"),
    ("every day at 9:00 except on weekends wave", "not understand when"),
    ("明早十二点挥手", "没有听懂是什么时候"),
    ("今晚十二点挥手", "没有听懂是什么时候"),
    ("今晚一点挥手", "没有听懂几点"),
    ("明天晚上两点挥手", "没有听懂是什么时候"),
    ("明天凌晨十二点挥手", "没有听懂是什么时候"),
    ("明天下午十一点挥手", "没有听懂是什么时候"),
    ("明天夜里两点挥手", "没有听懂是什么时候"),
    ("今晚早上八点挥手", "没有听懂是什么时候"),
    ("每天中午挥手", "没有听懂几点"),
    ("明天九点到门口去", "没有听懂是什么时候"),
]

#: Durations of a motion, counts, directions of a clock and remarks: nothing of it is a time.
UNTIMED = [
    "walk for two seconds", "walk 2 m in 10 seconds", "wave three times", "turn to 3 o'clock", "wait 5 seconds",
    "walk at 0.5 m/s", "stop after 2 m", "take 3 photos", "turn left, then right",
    "make a heart, I passed today's exam", "一样但是慢一点", "往前走一点", "走两秒后挥手", "挥手三次", "转向三点钟方向",
    "前进3秒", "往后退一米", "一米五", "先挥手再坐下",
]  # fmt: skip


def told(schedule: Schedule) -> list[str]:
    return [f"{run.astimezone(ZoneInfo(ZONE)):%a %d %H:%M:%S}" for run in first_runs(schedule, 3)]


@pytest.mark.parametrize(("text", "rest", "runs", "count"), UNDERSTOOD)
def test_a_time_is_split_from_its_command(text: str, rest: str, runs: list[str], count: int) -> None:
    found = timed_text(text, NOW, ZONE)
    assert found is not None
    assert found.schedule is not None, found.question
    assert (found.rest, told(found.schedule), found.schedule.runs_left) == (rest, runs, count)


@pytest.mark.parametrize(("text", "question"), ASKED)
def test_a_time_that_is_not_wholly_understood_is_asked_about(text: str, question: str) -> None:
    found = timed_text(text, NOW, ZONE)
    assert found is not None
    assert found.schedule is None
    assert question in found.question
    offered = re.findall("`([^`]+)`", found.question)
    assert offered
    for example in offered:
        again = timed_text(example, NOW, ZONE)
        assert again is not None
        assert again.schedule is not None, f"the question offers {example!r}"


@pytest.mark.parametrize("text", UNTIMED)
def test_other_words_keep_their_meaning(text: str) -> None:
    found = timed_text(text, NOW, ZONE)
    assert found is None or found.schedule is None


def test_until_is_the_end_of_that_day_and_limits_are_named() -> None:
    friday = timed_text("every hour until Friday wave", NOW, ZONE)
    assert friday is not None
    assert friday.schedule is not None
    assert friday.schedule.until_at == datetime(2026, 11, 28, tzinfo=ZoneInfo(ZONE))
    assert friday.schedule.limited_runs
    assert not friday.schedule.limited_days
    daily = timed_text("every day at 9 wave", NOW, ZONE)
    assert daily is not None
    assert daily.schedule is not None
    assert daily.schedule.until_at == NOW + timedelta(days=60)
    assert daily.schedule.limited_days


_WORDS = [
    "in", "10 minutes", "an hour", "at", "9", "15:30", "3 pm", "tomorrow", "every day", "every weekday",
    "every 15 minutes", "between 9 and 17", "until", "Friday", "three times", "an hour apart", "wave", "walk 1 m",
    "and", "then", "now", ",", ".", "after", "except", "on Mondays", "half", "not", "please", "noon",
]  # fmt: skip


@given(st.lists(st.sampled_from(_WORDS), min_size=1, max_size=9).map(" ".join))
def test_whatever_is_said_runs_are_in_the_future_in_order_and_within_the_limits(text: str) -> None:
    found = timed_text(text, NOW, ZONE)
    if found is None or found.schedule is None:
        return
    schedule = found.schedule
    runs = first_runs(schedule, 30)
    assert 1 <= schedule.runs_left <= 30
    assert runs
    assert runs[0] >= NOW
    assert runs[-1] <= NOW + timedelta(days=61)
    assert all(a < b for a, b in pairwise(runs))
    assert schedule.at or all(b - a >= timedelta(minutes=5) for a, b in pairwise(runs))
    words = known()["en"].schedule
    assert not re.search(words.hints, found.rest, re.IGNORECASE), "what says when is not left in the command"


@pytest.mark.parametrize(
    "text",
    ["schedules", "Schedules?", "show me your schedules", "what is scheduled?", "what's on your schedule",
     "when is your next run?", "日程", "你的日程", "日程表", "有什么日程？", "下次什么时候运行"],
)  # fmt: skip
def test_a_request_for_the_schedules(text: str) -> None:
    assert lists_schedules(text)


@pytest.mark.parametrize("text", ["schedule a walk", "wave", "日程很满", "cancel the schedules"])
def test_no_request_for_the_schedules(text: str) -> None:
    assert not lists_schedules(text)


@pytest.mark.parametrize(
    "text", ["cancel", "@quadruped cancel", "Cancel it!", "please cancel the schedule", "取消", "取消日程。"]
)
def test_a_cancellation(text: str) -> None:
    assert cancels_schedule(text)


@pytest.mark.parametrize(
    "text",
    ["cancel all schedules", "cancel tomorrow's photo", "please cancel the run of tomorrow at 9:00", "取消所有日程",
     "取消明天的拍照"],
)  # fmt: skip
def test_a_cancellation_of_a_schedule_elsewhere(text: str) -> None:
    assert cancels_elsewhere(text)


@pytest.mark.parametrize(
    "text",
    ["cancel", "cancel my visit", "cancel that, tomorrow at 9 wave", "cancel it and tomorrow at 9 wave",
     "wave tomorrow", "取消", "取消关注", "取消明天的拍照，改成挥手", "取消它然后明天九点挥手"],
)  # fmt: skip
def test_no_cancellation_of_a_schedule_elsewhere(text: str) -> None:
    assert not cancels_elsewhere(text)


@pytest.mark.parametrize("text", ["cancel my visit", "don't cancel", "I had to cancel", "取消关注", "stop"])
def test_no_cancellation(text: str) -> None:
    assert not cancels_schedule(text)
