"""Whatever is asked of a journal, in whatever order: SQLite, PostgreSQL and a simple model answer the same."""

from __future__ import annotations

import asyncio
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.agent.store.journal import Journal
from agentrob.errors import IllegalTransition
from agentrob.model import CommandState, EndReason
from agentrob.model.lifecycle import TRANSITIONS
from tests.agent.store.journal_store import open_journal
from tests.agent.store.test_journal import command, says
from tests.sizes import size

ROBOT = "rex"
POSTS = st.sampled_from(["1", "2", "3"])
CALLS = st.one_of(
    st.tuples(st.sampled_from(["claim", "stale", "cancel", "end", "move", "assess", "moved", "refuse", "done"]), POSTS),
    st.sampled_from([("open", ""), ("restart", ""), ("set aside", "")]),
)


@dataclass
class JournalModel:
    """A journal in memory."""

    claims: dict[str, CommandState | None] = field(default_factory=dict)
    motions: dict[str, str] = field(default_factory=dict)
    assessments: dict[str, str] = field(default_factory=dict)

    def ask(self, call: str, post: str, n: int) -> object:
        match call:
            case "claim" | "stale":
                new = post not in self.claims
                self.claims.setdefault(post, None)
                if new and call == "stale":
                    self.motions.setdefault(post, "cancelled")
                return new
            case "cancel":
                return self.motions.setdefault(post, f"cancelled {n}") == f"cancelled {n}"
            case "end":
                self.motions.setdefault(post, "cancelled")
                return None
            case "move":
                if post in self.claims and post not in self.motions and self.claims[post] is not None:
                    return IllegalTransition
                kept = self.motions.setdefault(post, f"moved {n}")
                return "cancelled" if kept.startswith("cancelled") else kept
            case "assess":
                return self.assessments.setdefault(post, f"thought {n}")
            case "moved":
                return self.motions.get(post, "").startswith("moved")
            case "refuse" | "done":
                return self.finish(post, CommandState.REFUSED if call == "refuse" else CommandState.DONE)
            case "open":
                return [post for post, final in self.claims.items() if final is None]
            case "set aside":
                self.__init__()  # type: ignore[misc]
        return None

    def finish(self, post: str, final: CommandState) -> object:
        if post in self.claims:
            moved = self.motions.get(post, "").startswith("moved")
            before = self.claims[post] or (CommandState.RUNNING if moved else CommandState.SEEN)
            if final != before and final not in TRANSITIONS[before]:
                return IllegalTransition
            self.claims[post] = final
        self.assessments.pop(post, None)
        return None


async def ask(journal: Journal, call: str, post: str, n: int) -> object:
    match call:
        case "claim" | "stale":
            return (await journal.claim(command(post), EndReason.STALE if call == "stale" else None)).new
        case "cancel":
            return await journal.cancel(post)
        case "end":
            await journal.end([post], EndReason.STOP)
        case "move":
            return await journal.move(post, says(f"moved {n}"))
        case "assess":
            return await journal.assess(post, says(f"thought {n}"))
        case "moved":
            return await journal.moved(post)
        case "refuse" | "done":
            await journal.finish(post, CommandState.REFUSED if call == "refuse" else CommandState.DONE)
        case "open":
            return [claim.command.post_id for claim in await journal.open_claims()]
        case "set aside":
            await journal.set_aside()
    return None


async def answers(calls: list[tuple[str, str]]) -> list[object]:
    found: list[object] = []
    with tempfile.TemporaryDirectory() as folder:
        journal = await open_journal(Path(folder), ROBOT)
        for n, (call, post) in enumerate(calls):
            if call == "restart":
                await journal.close()
                journal = await open_journal(Path(folder), ROBOT)
            try:
                found.append(await ask(journal, call, post, n))
            except IllegalTransition:
                found.append(IllegalTransition)
        await journal.close()
    return found


@pytest.mark.usefixtures("database")
@settings(
    max_examples=size(15, 200),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.lists(CALLS, max_size=25))
def test_law_6_a_journal_answers_as_the_model_does(calls: list[tuple[str, str]]) -> None:
    model = JournalModel()
    assert asyncio.run(answers(calls)) == [model.ask(call, post, n) for n, (call, post) in enumerate(calls)]
