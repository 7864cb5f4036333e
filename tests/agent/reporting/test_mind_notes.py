"""The notes on minds in a reply."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import get_args

import pytest
from pydantic import TypeAdapter

from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.reporting.mind_notes import notes, usage_line
from agentrob.agent.understanding.extract import FAILED, OVER, Assessment
from agentrob.language.messages.catalog import can_say
from agentrob.minds.llm.errors import ErrorKind
from agentrob.minds.safety_review import SafetyReview
from agentrob.minds.usage import Usage
from agentrob.model import Account, Command, EndReason, Intent, Understanding

COMMAND = Command("1", "1", "", Account("1", "alice"), "quadruped", "walk", "en", datetime.now(UTC), "t")
READ = Understanding(Intent.COMMAND)
ONE = Usage("clever", "gpt-x", 812, 40, 852, 0.0031, "USD", 640.0)
LOST = Usage("clever", "gpt-x", latency_ms=25_000.0, attempts=3, failed="timeout")


@pytest.mark.parametrize("kind", [*get_args(ErrorKind), FAILED])
def test_each_way_of_failing_has_its_words(kind: str) -> None:
    assert can_say(f"agent.mind.why.{kind}")
    for language, begin in (("en", "`clever` did not read this post ("), ("zh", "`clever` 没有读这个帖子（")):
        (note,) = notes(Assessment(READ, "rules", fallback=kind), "clever", language)
        assert note.startswith(begin)
        assert ("my rules did." if language == "en" else "由我的规则代读。") in note


def test_what_was_taken_is_one_line_also_for_several_questions() -> None:
    assert usage_line([ONE], "en") == "`clever` (`gpt-x`): 812 + 40 tokens, 0.0031 USD, 0.64 s"
    assert usage_line([ONE, ONE], "en") == "`clever` (`gpt-x`): 2 questions, 1624 + 80 tokens, 0.0062 USD, 1.28 s"
    free = Usage("local", "llama", latency_ms=100.0)
    assert usage_line([LOST, free], "en") == (
        "`clever` (`gpt-x`): no answer after 25.00 s; `local` (`llama`): tokens unknown, 0.10 s"
    )
    assert usage_line([ONE], "zh") == "`clever` (`gpt-x`)：812 + 40 个 token，0.0031 USD，0.64 秒"
    assert usage_line([], "en") == ""


def test_where_no_model_had_a_part_nothing_is_said() -> None:
    assert notes(None, "rules", "en") == []
    assert notes(Assessment(READ, "rules"), "rules", "en") == []
    assert notes(Assessment(READ, "rules", fallback=OVER), "clever", "en") == []


def test_who_answered_instead_and_who_did_not_look_are_reported_in_one_paragraph() -> None:
    thought = Assessment(
        READ, "second", usage=(LOST, ONE), fallback="timeout", screened=SafetyReview("clever", failed="server")
    )
    said, line = notes(thought, "clever", "en", more=[ONE])
    assert said == (
        "`clever` did not read this post (no answer in time); `second` did. "
        "No model has reviewed this command (its server failed); my rules found nothing against it."
    )
    assert line.startswith("*`clever` (`gpt-x`): 3 questions, 1624 + 80 tokens")


def test_law_3_a_name_that_a_server_gives_is_shown_as_code() -> None:
    line = usage_line([Usage("clever", "`@bob` <img> [x](http://evil.example)", 1, 1)], "en")
    assert "`'(at)bob' <img> [x](http://evil.example)`" in line


async def test_law_14_nobody_thinks_about_what_is_ended_and_nobody_waits_for_who_does() -> None:
    job, begun = QueuedCommand(COMMAND), asyncio.Event()

    async def think() -> str:
        begun.set()
        await asyncio.Event().wait()
        return "a thought"

    thinking = asyncio.create_task(job.unless_ended(think()))
    await asyncio.wait_for(begun.wait(), 60)
    assert not thinking.done()
    job.end(EndReason.STOP)
    assert await asyncio.wait_for(thinking, 60) is None
    begun.clear()
    assert await job.unless_ended(think()) is None
    assert not begun.is_set()


async def test_what_is_thought_in_time_counts() -> None:
    job = QueuedCommand(COMMAND)
    assert await job.unless_ended(asyncio.sleep(0, "a thought")) == "a thought"


def test_a_thought_of_an_older_journal_is_still_read() -> None:
    older = '{"understanding": {"intent": "command", "language": "zh"}, "mind": "rules", "verdict": null}'
    thought = TypeAdapter(Assessment).validate_json(older)
    assert (thought.mind, thought.usage, thought.fallback, thought.screened) == ("rules", (), "", None)
    full = Assessment(
        READ, "rules", usage=(ONE,), fallback="timeout", screened=SafetyReview("clever", failed="timeout")
    )
    assert TypeAdapter(Assessment).validate_json(TypeAdapter(Assessment).dump_json(full)) == full
