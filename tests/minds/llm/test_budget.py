"""Budgets of minds: per command and per day, across restarts and processes."""

from __future__ import annotations

import asyncio
import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.config.minds import MindLimitsConfig, PriceConfig
from agentrob.minds.llm.budget import Budget
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.model import RETRY_MAX_S, ConfiguredModel, retry_wait_s
from agentrob.minds.usage import Usage, cost_of, estimate_tokens
from tests.minds.faulty_server import FaultyServer, said

Make = Callable[..., ConfiguredModel]
DAY = MindLimitsConfig(day_tokens=1_000, command_tokens=0)


def budget(file: Path, limits: MindLimitsConfig = DAY, day: str = "2026-01-01", mind: str = "clever") -> Budget:
    return Budget(mind, limits, file, today=lambda: day)


async def test_the_daily_budget_survives_a_restart(tmp_path: Path) -> None:
    file = tmp_path / "minds.sqlite"
    first = budget(file)
    await first.settle(await first.reserve(900, 0.0, ()), 800, 0.0)
    assert first.spent_today() == (800, 0.0)
    again = budget(file)
    with pytest.raises(ModelError, match="day_tokens = 1000") as caught:
        await again.reserve(201, 0.0, ())
    assert caught.value.kind == "budget"
    await again.reserve(200, 0.0, ())


async def test_each_day_and_each_mind_has_its_own_budget(tmp_path: Path) -> None:
    file = tmp_path / "minds.sqlite"
    await budget(file).reserve(1_000, 0.0, ())
    await budget(file, day="2026-01-02").reserve(1_000, 0.0, ())
    await budget(file, mind="other").reserve(1_000, 0.0, ())


async def test_an_aborted_request_stays_counted(tmp_path: Path) -> None:
    await budget(tmp_path / "minds.sqlite").reserve(700, 0.5, ())
    assert budget(tmp_path / "minds.sqlite").spent_today() == (700, 0.5)


async def test_concurrent_requests_cannot_overspend(tmp_path: Path) -> None:
    purses = [budget(tmp_path / "minds.sqlite") for _ in range(8)]
    got = await asyncio.gather(*(p.reserve(300, 0.0, ()) for p in purses), return_exceptions=True)
    assert sum(not isinstance(x, BaseException) for x in got) == 3
    assert purses[0].spent_today() == (900, 0.0)


async def test_money_is_limited_too(tmp_path: Path) -> None:
    limits = MindLimitsConfig(command_cost=1.0, day_cost=1.5)
    purse = budget(tmp_path / "minds.sqlite", limits)
    spent = [Usage("clever", "m", cost=0.8), Usage("other", "m", cost=5.0)]
    with pytest.raises(ModelError, match="command_cost = 1 "):
        await purse.reserve(10, 0.3, spent)
    await purse.reserve(10, 0.9, ())
    with pytest.raises(ModelError, match=r"day_cost = 1\.5"):
        await purse.reserve(10, 0.7, ())


async def test_an_unusable_file_stops_the_spending(tmp_path: Path) -> None:
    for broken in (tmp_path, tmp_path / "text"):
        (tmp_path / "text").write_text("no database" * 1000)
        with pytest.raises(ModelError, match="cannot be kept") as caught:
            await budget(broken).reserve(1, 0.0, ())
        assert caught.value.kind == "budget"


async def test_a_locked_file_stops_the_spending_and_loses_no_response(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.minds.llm.budget.BUSY_S", 0.05)
    file = tmp_path / "minds.sqlite"
    reserve = await budget(file).reserve(500, 0.0, ())
    with closing(sqlite3.connect(file, isolation_level=None)) as other:
        other.execute("begin immediate")
        with pytest.raises(ModelError, match="locked"):
            await budget(file).reserve(1, 0.0, ())
        await budget(file).settle(reserve, 100, 0.0)
    assert budget(file).spent_today() == (500, 0.0), "what was set aside stays counted"


async def test_nothing_is_sent_beyond_the_budget_of_a_command(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.send(200, json.dumps(said("Yes.", (600, 50))).encode())
    model = make(server.url + "/v1", max_output_tokens=100, limits={"command_tokens": 700})
    first = await model.chat("", "Hello")
    with pytest.raises(ModelError, match="command_tokens = 700"):
        await model.chat("", "Hello", spent=first.usage)
    assert len(server.requests) == 1
    await model.chat("", "Hello")  # another command
    await model.close()


async def test_the_daily_budget_counts_actual_usage(server: FaultyServer, make: Make, tmp_path: Path) -> None:
    script = [(200, said("Yes.", (600, 50))), (500, {}), (401, {}), (200, said("No usage.", None))]
    left = iter(script)

    def answer(handler: Any, _: Any) -> None:
        status, body = next(left)
        handler.send(status, json.dumps(body).encode())

    server.answer = answer
    model = make(server.url + "/v1", retries=0, max_output_tokens=100)
    purse = Budget("clever", MindLimitsConfig(), tmp_path / "minds.sqlite")
    await model.chat("", "Hello")
    assert purse.spent_today() == (650, 0.0)
    for _ in range(2):  # a failed request is not billed
        with pytest.raises(ModelError):
            await model.chat("", "Hello")
        assert purse.spent_today() == (650, 0.0)
    (usage,) = (await model.chat("", "Hello")).usage
    assert usage.input_tokens is None
    assert usage.counted_tokens == 100 + estimate_tokens(["", "Hello"])
    assert purse.spent_today() == (650 + usage.counted_tokens, 0.0)
    await model.close()


async def test_timed_out_requests_count_because_they_may_be_billed(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.hang()
    price = {"input_per_million": 10.0, "output_per_million": 10.0}
    model = make(server.url + "/v1", timeout_s=0.2, retries=1, max_output_tokens=100, price=price)
    with pytest.raises(ModelError) as caught:
        await model.chat("", "Hello")
    (usage,) = caught.value.usage
    assert usage.counted_tokens == 2 * (100 + estimate_tokens(["", "Hello"]))
    assert usage.cost == pytest.approx(usage.counted_tokens * 10 / 1e6)
    await model.close()


@given(st.lists(st.text()), st.integers(0, 8))
def test_an_estimate_is_never_zero(texts: list[str], images: int) -> None:
    assert estimate_tokens(texts, images) >= sum(map(len, texts)) // 3 + images * 1_000


def test_cost_is_unknown_without_a_price() -> None:
    assert cost_of(10, 10, None) is None
    assert cost_of(1_000_000, 500_000, PriceConfig(input_per_million=2, output_per_million=4)) == 4.0


@given(st.integers(1, 10_000), st.floats(0, 1), st.none() | st.floats(0, 100))
def test_waits_are_bounded_and_respect_the_server(attempt: int, chance: float, after: float | None) -> None:
    wait = retry_wait_s(attempt, chance, after)
    assert (after or 0.0) <= wait <= (after or 0.0) + RETRY_MAX_S
