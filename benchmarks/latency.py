"""Measure the time from a post to its status and to the first motion, with a real board, agent and driver process.

    python benchmarks/latency.py [--posts 1000]

Each post is written after the previous one has its final answer. The fake robot moves instantly and there are no rate
limits, so this measures only our own processing. Times count from when the board accepted the post, by the board's
clock; all processes share this machine.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import tempfile
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from agentrob.demo.ports import free_port
from agentrob.forums.protocol import Forum
from agentrob.model import AccountKind, EventKind, Role
from agentrob.process.child import Child, terminate_all
from agentrob.wiring import app

ROBOT = "quadruped"
GOALS_MS = {"seen": 150.0, "first_motion": 250.0}
CONFIG = """
data = {data}
[board]
listen = "127.0.0.1:{port}"
[forum]
url = "http://127.0.0.1:{port}"
[robots.{robot}]
model = "fake"
domain = {domain}
simulated = true
home_on_start = true
options = {{ time_scale = inf }}
rates = {{ commands_per_hour = 0, cooldown_s = 0 }}
"""


async def measure(forum: Forum, folder: Path, posts: int) -> dict[str, list[float]]:
    """Post `posts` times; return milliseconds per post until the status was visible here and until the first motion."""
    found: dict[str, list[float]] = {"seen": [], "first_motion": [], "done": []}
    after, _ = await forum.now()
    events = forum.stream(after)
    topic = ""
    for number in range(posts):
        text = f"@{ROBOT} turn {'left' if number % 2 else 'right'} 90 degrees"
        if number % 100 == 0:
            post = (await forum.create_topic("robots", f"Latency {number}", text, key=f"t{number}")).post
            topic = post.topic_id
        else:
            post = (await forum.reply(topic, text, key=f"p{number}")).post
        async for event in events:
            status = event.post
            if status is None or status.reply_to != post.id or status.card is None:
                continue
            if event.kind is EventKind.POST_CREATED:
                found["seen"].append((datetime.now(UTC) - post.created_at).total_seconds() * 1000)
            if status.card.state not in ("seen", "queued", "running"):
                assert status.card.state == "done", status.raw
                break
        timings = json.loads((folder / "records" / f"{post.id}.json").read_text())["timings_ms"]
        found["first_motion"].append(timings["first_motion"])
        found["done"].append(timings["done"])
    return found


def percentile(values: Sequence[float], share: float) -> float:
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def run(posts: int, folder: Path) -> dict[str, list[float]]:
    """Start everything, measure, end everything."""
    path = folder / "agentrob.toml"
    path.write_text(
        CONFIG.format(data=json.dumps(str(folder)), port=free_port(), robot=ROBOT, domain=1 + os.getpid() % 230)
    )
    config = app.load(path)
    app.board_account(config, ROBOT, AccountKind.ROBOT_AGENT, Role.MEMBER)
    app.board_account(config, "alice", AccountKind.HUMAN, Role.OPERATOR)
    own = {"AGENTROB_DATA": str(folder), "AGENTROB_RUNTIME": str(folder)}
    os.environ.update(own)
    children: list[Child] = []
    try:
        for name, *args in (("board", "board", "serve"), ("driver", "driver", ROBOT), ("agent", "agent", "run", ROBOT)):
            env = own | ({config.forum.token_env: app.board_token(config, ROBOT)} if name == "agent" else {})
            children.append(Child(name, [*args, "--config", str(path)], folder / f"{name}.log", env))
            children[-1].wait_ready()
        return asyncio.run(_measured(app.make_forum(config, app.board_token(config, "alice")), folder, posts))
    finally:
        terminate_all(children)


async def _measured(forum: Forum, folder: Path, posts: int) -> dict[str, list[float]]:
    try:
        return await measure(forum, folder / "agents" / ROBOT, posts)
    finally:
        await forum.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--posts", type=int, default=1000)
    posts = parser.parse_args().posts
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="agentrob-latency-") as folder:
        found = run(posts, Path(folder))
    print(f"{posts} posts in {time.monotonic() - begun_s:.0f} s, one after the other; no limits on posting; fake robot")
    print(f"{'post accepted until':<24}{'p50':>8}{'p90':>8}{'p99':>8}{'max':>8}   goal (p50)")
    for name, label in (("seen", "status visible"), ("first_motion", "first motion"), ("done", "robot done")):
        row = "".join(f"{percentile(found[name], share):>8.0f}" for share in (0.5, 0.9, 0.99, 1.0))
        goal = f"≤ {GOALS_MS[name]:.0f} ms" if name in GOALS_MS else ""
        print(f"{label + ' (ms)':<24}{row}   {goal}")
    missed = [name for name, goal in GOALS_MS.items() if percentile(found[name], 0.5) > goal]
    raise SystemExit(f"missed: {', '.join(missed)}" if missed else 0)


if __name__ == "__main__":
    main()
