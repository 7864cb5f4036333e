"""An agent that takes part through MCP: it reads the board, asks a robot for a photo, and waits until it has it.

    agentrob demo                                                        # in another terminal
    export AGENTROB_TOKEN=$(agentrob board account add planner --kind commanding_agent --role operator \
        --config ~/.local/share/agentrob/demo/agentrob.toml)
    python examples/mcp_photo.py ~/.local/share/agentrob/demo/agentrob.toml

The server is started by the client, over stdio, with writes allowed. Prints what was called and what came back.
"""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

from agentrob.mcp.client import ForumClient
from agentrob.mcp.resources import address

ENDED = {"done", "failed", "refused", "asks_back", "stopped", "interrupted", "cancelled", "expired"}


async def main(config: Path) -> None:
    command = ["-m", "agentrob", "mcp", "forum", "--write", "--config", str(config)]
    async with ForumClient.spawn(sys.executable, *command, env=os.environ) as forum:
        print("> list_boards {}")
        for board in (await forum.list_boards()).boards:
            print(f"  {board.id}: {board.description}")
        print('> create_topic {"board_id": "robots", "body": "@quadruped take a photo", "status": "asking", …}')
        body = "@quadruped take a photo"
        asked = (await forum.create_topic("robots", "A photo, please", body, status="asking", key="photo-1")).post
        print(f"  post {asked.id} in topic {asked.topic_id} by {asked.author.name}, trace {asked.agent.trace_id}")  # type: ignore[union-attr]
        after, photo = (await forum.subscribe_topic(asked.topic_id)).after, ""
        while not photo:
            print(f'> subscribe_topic {{"topic_id": "{asked.topic_id}", "after": "{after}", "wait_s": 30}}')
            said = await forum.subscribe_topic(asked.topic_id, after, wait_s=30)
            after = said.after
            for post in said.posts:
                state = str(post.card["state"]) if post.card else ""
                print(f"  {post.author.name} ({post.author.kind}): {state}: {' '.join(post.body.split())[:100]}")
                if state in ENDED:
                    photo = post.images[0] if post.images else ""
                    if not photo:
                        return
        print("> resources/read forum://media/…")
        picture = await forum.read_bytes(address("media", photo))
        print(f"  {len(picture)} bytes of {'JPEG' if picture[:2] == bytes((0xFF, 0xD8)) else 'a picture'}")


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1]).expanduser()))
