"""Lengths of time in words, as replies say them."""

from __future__ import annotations

import pytest

from agentrob.language.messages.durations import duration


@pytest.mark.parametrize(
    ("seconds", "english", "chinese"),
    [
        (-5, "1 second", "1 秒"),
        (0.4, "1 second", "1 秒"),
        (59.4, "59 seconds", "59 秒"),
        (59.6, "1 minute", "1 分钟"),
        (90, "1 minute 30 seconds", "1 分钟 30 秒"),
        (600, "10 minutes", "10 分钟"),
        (3_599.7, "1 hour", "1 小时"),
        (10_215, "2 hours 50 minutes", "2 小时 50 分钟"),
        (86_399, "1 day", "1 天"),
        (7 * 86_400 - 20, "7 days", "7 天"),
        (400 * 86_400 + 7_300, "400 days 2 hours", "400 天 2 小时"),
    ],
)
def test_a_length_of_time_is_said_in_one_or_two_units(seconds: float, english: str, chinese: str) -> None:
    assert duration(seconds) == english
    assert duration(seconds, "zh") == chinese
