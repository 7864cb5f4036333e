"""Post one text as the visitor and wait for the robots' answers, for `agentrob demo --post`."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agentrob.config.load import Config
from agentrob.errors import AgentRobError, ConfigError, ForumUnreachable
from agentrob.model import CommandState, Post
from agentrob.wiring import app

if TYPE_CHECKING:
    from agentrob.forums.protocol import Forum

#: Seconds to wait for the answer: a command's time limit, its report, and a margin for slow machines.
LIMIT_S = 180.0


async def ask(config: Config, token: str, text: str, check: Callable[[], None]) -> dict[str, Any]:
    """Post the text, wait until every mentioned robot has given its final answer, and return the answers.

    `check` raises to end the wait early. `status` is "done" if all robots are done. The other fields combine all
    robots; `robots` has the answer of each.
    """
    forum = app.make_forum(config, token)
    names, posts, error, pictures = _addressed_robots(text, config), dict[str, Post](), "", list[str]()
    try:
        watermark, _ = await forum.now()
        board = config.robot(names[0]).boards[0]
        written = await forum.create_topic(board, title(text), text, key=secrets.token_hex(8))
        topic = await forum.topic(written.post.topic_id)
        try:
            async with asyncio.timeout(LIMIT_S):
                await _wait_for_finals(forum, watermark, topic.id, names, posts, check)
                for post in posts.values():
                    pictures += await _save_images(forum, post, config.data_dir / "pictures")
        except TimeoutError:
            error = f"no final answer within {LIMIT_S:.0f} s; see the logs in {config.data_dir / 'log'}"
        except AgentRobError as e:
            error = str(e)
    finally:
        await forum.close()
    answers = {name: _answer(config, name, written.post.id, posts.get(name)) for name in names}
    return {
        "status": next((a["status"] for a in answers.values() if a["status"] != CommandState.DONE), CommandState.DONE),
        "topic_url": topic.url,
        "reply_markdown": "\n\n".join(a["reply_markdown"] for a in answers.values() if a["reply_markdown"]),
        "steps": [{"robot": name, **step} for name, a in answers.items() for step in a["steps"]],
        "timings_ms": answers[names[0]]["timings_ms"],
        "robots": answers,
        "images": pictures,
        "data": str(config.data_dir),
        "error": error,
    }


def _addressed_robots(text: str, config: Config) -> list[str]:
    """The robots that a post mentions, else the first configured robot."""
    from agentrob.language.visible_text import mentions, visible_text

    named = mentions(visible_text(text))
    return [name for name in config.robots if name in named] or list(config.robots)[:1]


def _answer(config: Config, name: str, post_id: str, post: Post | None) -> dict[str, Any]:
    """One robot's answer, with the steps and timings of its agent's record."""
    record = app.read_record(config.data_dir, name, post_id)
    return {
        "status": post.card.state if post and post.card else CommandState.FAILED,
        "reply_markdown": post.raw if post else "",
        "steps": record.get("steps", []),
        "timings_ms": record.get("timings_ms", {}),
    }


async def _wait_for_finals(
    forum: Forum,
    after: str,
    topic_id: str,
    names: Sequence[str],
    posts: dict[str, Post],
    check: Callable[[], None],
) -> None:
    """Add each robot's final answer to `posts`; return when all have answered."""
    while True:
        with contextlib.suppress(ForumUnreachable):  # on a busy machine the stream may break: resume it
            async for event in forum.stream(after):
                check()
                after, post = event.id or after, event.post
                if post is None or post.topic_id != topic_id or post.author.name not in names:
                    continue
                if post.card and post.card.is_final:
                    posts[post.author.name] = post
                if len(posts) == len(names):
                    return
        check()
        await asyncio.sleep(0.2)


async def _save_images(forum: Forum, post: Post, folder: Path) -> list[str]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for n, url in enumerate(post.images):
        data = await forum.download(url)
        suffix = ".png" if data[:4] == b"\x89PNG" else ".jpg"
        path = folder / f"post-{post.id}-{n + 1}{suffix}"
        path.write_bytes(data)
        paths.append(str(path))
    return paths


def title(text: str) -> str:
    """The topic's title: the first line of the text, shortened."""
    if not text.strip():
        raise ConfigError('nothing to post; give a text, for example --post "@quadruped wave"')
    line = text.strip().splitlines()[0]
    return line if len(line) <= 80 else line[:79] + "…"
