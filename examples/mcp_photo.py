"""An agent that uses the forum through MCP: it reads the board, asks a robot for a photo, and waits for it.

    agentrob demo                                                        # in another terminal
    export AGENTROB_TOKEN=$(agentrob board account add planner --kind commanding_agent --role operator \
        --config ~/.local/share/agentrob/demo/agentrob.toml)
    python examples/mcp_photo.py ~/.local/share/agentrob/demo/agentrob.toml photo.jpg

The client starts the server over stdio, with writes allowed, and prints the calls and their results.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

from agentrob.mcp import results
from agentrob.mcp.client import ForumClient
from agentrob.mcp.forum.resources import address

ROBOT = "quadruped"
ENDED = {"done", "failed", "refused", "asks_back", "stopped", "interrupted", "cancelled", "expired"}


async def main(config: Path, picture: Path | None) -> bool:
    """Return whether the photo arrived."""
    command = ["-m", "agentrob", "mcp", "forum", "--write", "--config", str(config)]
    async with ForumClient.spawn(sys.executable, *command, env=os.environ) as forum:
        await read_the_board(forum)
        post = await ask(forum)
        photo = await answer(forum, post)
        if not photo:
            return False
        say("resources/read", uri=(uri := address("media", photo)))
        jpeg = await forum.read_bytes(uri)
        print(f"  {len(jpeg)} bytes of {'JPEG' if jpeg[:2] == bytes((0xFF, 0xD8)) else 'a picture'}")
        if picture is not None:
            picture.write_bytes(jpeg)
        return True


async def read_the_board(forum: ForumClient) -> None:
    say("list_boards")
    for board in (await forum.list_boards()).boards:
        print(f"  {board.id}: {board.description}")
    say("list_posts", board_id="robots", limit=3)
    topics = (await forum.list_posts("robots", limit=3)).topics
    for topic in topics:
        print(f"  {topic.id}: {topic.title} by {topic.author.name}")
    if topics:
        say("get_topic", topic_id=topics[0].id)
        for post in (await forum.get_topic(topics[0].id)).posts:
            tell(post)


async def ask(forum: ForumClient) -> results.PostInfo:
    body = f"@{ROBOT} take a photo"
    say("create_topic", board_id="robots", title="A photo, please", body=body, status="asking")
    asked = (await forum.create_topic("robots", "A photo, please", body, status="asking")).post
    tell(asked)
    return asked


async def answer(forum: ForumClient, asked: results.PostInfo) -> str:
    """Wait for the robot's answer and return the address of its photo, or "" without one."""
    say("subscribe_topic", topic_id=asked.topic_id)
    after = (await forum.subscribe_topic(asked.topic_id)).after
    say("get_topic", topic_id=asked.topic_id)  # posts from before the subscription
    posts = (await forum.get_topic(asked.topic_id)).posts[1:]
    while True:
        for post in posts:
            tell(post)
            if post.card and post.card["state"] in ENDED:
                return post.images[0] if post.images else ""
        say("subscribe_topic", topic_id=asked.topic_id, after=after, wait_s=30)
        said = await forum.subscribe_topic(asked.topic_id, after, wait_s=30)
        after, posts = said.after, said.posts


def say(tool: str, **arguments: Any) -> None:
    print(f"> {tool} {json.dumps(arguments)}")


def tell(post: results.PostInfo) -> None:
    state = f" [{post.card['state']}]" if post.card else ""
    tag = f" ({post.agent.type}, status {post.agent.status}, trace {post.agent.trace_id})" if post.agent else ""
    print(f"  {post.author.name}, {post.author.kind}{state}{tag}: {' '.join(post.body.split())[:120]}")


if __name__ == "__main__":
    where = [Path(p).expanduser() for p in sys.argv[1:]]
    sys.exit(0 if asyncio.run(main(where[0], where[1] if len(where) > 1 else None)) else "there was no photo")
