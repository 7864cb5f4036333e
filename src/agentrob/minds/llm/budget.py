"""Limit what minds may use per command and per day; the daily sum is on disk, so that it survives a restart.

The maximum cost of a question is reserved before it and settled after the answer. So two agents that share the file
cannot overspend together, and an interrupted question stays counted. pydantic-ai's `UsageLimits` check one run in one
process, after each response.
"""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import structlog

from agentrob.config.minds import MindLimitsConfig
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.usage import Usage, spent_by

BUSY_S = 2.0
_log = structlog.get_logger()
_MAKE = """
create table if not exists spent (
    day text not null, mind text not null, tokens integer not null, cost real not null, primary key (day, mind)
) without rowid
"""
_ADD = """
insert into spent (day, mind, tokens, cost) values (?, ?, max(0, ?), max(0, ?))
on conflict (day, mind) do update set tokens = max(0, tokens + ?3), cost = max(0, cost + ?4)
"""


def _utc_day() -> str:
    return datetime.now(UTC).date().isoformat()


@dataclass(frozen=True, slots=True)
class Reserve:
    """The tokens and the cost reserved for a question, and the day."""

    day: str
    tokens: int
    cost: float


class Budget:
    """The limits of one mind. `file` is shared by all minds and processes with the same budget.

    An unusable file stops the spending: the mind then fails, and the next one, in the end the rules, answers.
    """

    def __init__(self, mind: str, limits: MindLimitsConfig, file: Path, today: Callable[[], str] = _utc_day) -> None:
        self._mind = mind
        self._limits = limits
        self._file = file
        self._today = today

    async def reserve(self, tokens: int, cost: float, spent: Sequence[Usage]) -> Reserve:
        """Reserve the most that a question may cost. Raises `ModelError` "budget", which names the exceeded limit."""
        used_tokens, used_money = spent_by(self._mind, spent)
        self._check("command", used_tokens + tokens, used_money + cost)
        reserve = Reserve(self._today(), tokens, cost)
        await asyncio.to_thread(self._take, reserve)
        return reserve

    async def settle(self, reserve: Reserve, tokens: int, cost: float) -> None:
        """Replace the reservation by the actual cost."""
        more = (tokens - reserve.tokens, cost - reserve.cost)
        try:
            await asyncio.to_thread(self._add, reserve.day, *more)
        except ModelError as e:  # the answer is there all the same; what was set aside stays counted
            _log.warning("what a mind used cannot be written down", mind=self._mind, error=str(e))

    def spent_today(self) -> tuple[int, float]:
        """Return the tokens and money of this UTC day."""
        with self._opened() as db:
            return self._of(db, self._today())

    def _check(self, span: str, tokens: int, cost: float) -> None:
        most_tokens = self._limits.command_tokens if span == "command" else self._limits.day_tokens
        most_money = self._limits.command_cost if span == "command" else self._limits.day_cost
        if most_tokens and tokens > most_tokens:
            what = f"{tokens} tokens would pass {span}_tokens = {most_tokens}"
        elif most_money and cost > most_money:
            what = f"a cost of {cost:.4f} would pass {span}_cost = {most_money:g}"
        else:
            return
        raise ModelError("budget", f"{self._mind}: {what} (minds.{self._mind}.limits)")

    def _take(self, reserve: Reserve) -> None:
        with self._opened() as db:
            db.execute("begin immediate")
            tokens, cost = self._of(db, reserve.day)
            self._check("day", tokens + reserve.tokens, cost + reserve.cost)
            db.execute(_ADD, (reserve.day, self._mind, reserve.tokens, reserve.cost))
            db.execute("commit")

    def _add(self, day: str, tokens: int, cost: float) -> None:
        with self._opened() as db:
            db.execute(_ADD, (day, self._mind, tokens, cost))

    def _of(self, db: sqlite3.Connection, day: str) -> tuple[int, float]:
        row = db.execute("select tokens, cost from spent where day = ? and mind = ?", (day, self._mind)).fetchone()
        return row or (0, 0.0)

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        """Open the file; raises `ModelError` if that fails."""
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with closing(sqlite3.connect(self._file, timeout=BUSY_S, isolation_level=None)) as db:
                db.execute(_MAKE)
                yield db
        except (OSError, sqlite3.Error) as e:
            what = f"{self._mind}: what was spent today cannot be kept in {self._file.name}: {e}"
            raise ModelError("budget", what) from None
