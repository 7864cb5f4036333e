"""Lets go of what a robot's agent kept of commands that ended long ago, at the start and then once an hour."""

from __future__ import annotations

import asyncio

import structlog

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.records import Records
from agentrob.config.robots import RetentionConfig

#: How often it is looked.
EVERY_S = 3600.0
_log = structlog.get_logger()


async def prune(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Once, now. Whatever fails is logged: nothing that is kept too long ends the agent, which must hear
    the next stop."""
    try:
        await journal.prune(keep.days, keep.commands)
        await asyncio.to_thread(records.prune, keep.days, keep.mb, keep.commands)
    except Exception as e:
        _log.warning("old commands not let go of", error=str(e) or type(e).__name__)


async def keep_pruning(journal: Journal, records: Records, keep: RetentionConfig) -> None:
    """Until cancelled."""
    while True:
        await prune(journal, records, keep)
        await asyncio.sleep(EVERY_S)
