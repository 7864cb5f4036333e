"""Delete what an agent kept of commands that ended long ago, at the start and then hourly, and return free memory."""

from __future__ import annotations

import asyncio

import structlog

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.records import Records
from agentrob.config.robots import RetentionConfig
from agentrob.process.memory import release_free_memory

EVERY_S = 3600.0
_log = structlog.get_logger()


async def prune(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Prune once. Errors are logged and not raised: the agent must continue, to hear the next stop."""
    try:
        await journal.prune(keep.days, keep.commands)
        await asyncio.to_thread(records.prune, keep.days, keep.mb, keep.commands)
    except Exception as e:
        _log.warning("old commands not deleted", error=str(e) or type(e).__name__)


async def keep_pruning(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Prune now and then once an hour, and return free memory to the system, until cancelled."""
    while True:
        await prune(journal, records, keep)
        await asyncio.to_thread(release_free_memory)
        await asyncio.sleep(EVERY_S)
