"""Delete what an agent kept of commands that ended long ago, once an hour, and return free memory."""

from __future__ import annotations

import asyncio
import random

import structlog

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.records import Records
from agentrob.config.robots import RetentionConfig
from agentrob.process.interpreter import release_free_memory

#: How long after the start an agent prunes first, drawn at random, and how often from then on.
FIRST_S, EVERY_S = (30.0, 90.0), 3600.0
_log = structlog.get_logger()


async def prune(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Prune once. Errors are logged and not raised: the agent must continue, to hear the next stop."""
    try:
        await journal.prune(keep.days, keep.commands)
        await asyncio.to_thread(records.prune, keep.days, keep.mb, keep.commands)
    except Exception as e:
        _log.warning("old commands not deleted", error=str(e) or type(e).__name__)


async def keep_pruning(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Prune once an hour and return free memory to the system, until cancelled. The first time is about a minute after
    the start: a worker that takes over the robots of another has more urgent work."""
    await asyncio.sleep(random.uniform(*FIRST_S))
    while True:
        await prune(journal, records, keep)
        await asyncio.to_thread(release_free_memory)
        await asyncio.sleep(EVERY_S)
