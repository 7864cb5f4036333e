"""Our forum server for benchmarks/mcp.py: twelve tools before a memory forum with one topic of 6 kB."""

from __future__ import annotations

import asyncio
import sys


def main() -> None:
    from agentrob.process.interpreter import importing

    with importing():
        from agentrob.forums.memory.forum import MemoryForum
        from agentrob.mcp.forum import tools
        from agentrob.mcp.forum.identity import Accounts, Identity, Rights
        from agentrob.mcp.forum.run import serve_accounts
        from agentrob.model import Role
        from agentrob.process.logs import log_to_stderr

    log_to_stderr()
    world = MemoryForum.world()
    forum = world.sign_in("admin", role=Role.ADMIN)

    async def fill() -> None:
        topic = (await forum.create_topic("robots", "A walk", "word " * 60, key="0")).post.topic_id
        for n in range(9):
            await forum.reply(topic, "word " * 60, key=f"{n + 1}")

    asyncio.run(fill())
    # Twelve tools: manage_permissions and edit_post are left out.
    tools.TOOLS = tuple(t for t in tools.TOOLS if t.name != "edit_post")
    identity = Identity("admin", forum, Rights(True, frozenset({"core", "social"})))
    if "--http" in sys.argv:
        from agentrob.config.mcp import McpConfig
        from agentrob.mcp.forum.http import serve

        serve(McpConfig(listen="127.0.0.1:0"), {"admin": (identity, "token-of-the-benchmark", "")})
    else:
        serve_accounts(lambda: Accounts(identity, lambda token: MemoryForum(world, token), {}))


if __name__ == "__main__":
    main()
