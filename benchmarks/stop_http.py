"""Measure the time from a stop over HTTP to zero velocity: the demo's processes, a simulated Go2 over DDS.

    python benchmarks/stop_http.py [--trials 200] [--json]

Like `benchmarks/stop.py`, whose second DDS reader it uses, but the Go2's agent runs as `agentrob agent serve`, and the
stop is `POST /stop` of its service. Time counts from just before the request is sent, on an open connection, until
the second reader on the robot's DDS domain has received zero velocity.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import httpx2
import stop as posts

from agentrob.config.service import ServiceConfig
from agentrob.demo.run import Demo, DemoSettings
from agentrob.process.child import Child
from agentrob.process.signals import sigterm_interrupts
from agentrob.wiring import app

TOKEN = "benchmark-token-of-nobody"


class ServedDemo(Demo):
    """A demo that runs the Go2's agent as a service."""

    def _start_agents(self, robots: Sequence[str], config_path: Path) -> list[Child]:
        others = super()._start_agents([robot for robot in robots if robot != posts.ROBOT], config_path)
        tokens = {"stopper": {"token_env": "STOP_TOKEN", "scopes": ["stop"]}}
        service = ServiceConfig.model_validate({"listen": "127.0.0.1:0", "tokens": tokens})
        path = self.data / "served.toml"
        app.load(config_path).model_copy(update={"service": service}).write(path)
        env = {"AGENTROB_TOKEN": self.tokens[posts.ROBOT], "STOP_TOKEN": TOKEN}
        return [*others, self._child("service", "agent", "serve", posts.ROBOT, "--config", str(path), env=env)]


async def trial(scene: posts.Scene, http: httpx2.AsyncClient) -> tuple[float, float]:
    """One stop while the robot walks: milliseconds on DDS, and as reported by the service."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    asked_s = time.monotonic()
    answer = (await http.post(f"/api/v1/robots/{posts.ROBOT}/stop")).raise_for_status().json()
    await scene.wire.wait("zero", mark, asked_s)
    if (state := await scene.ended(command)) != "stopped":
        raise RuntimeError(f"the walk ended as {state} instead of stopped: the trial is invalid")
    return 1000 * (scene.wire.zero_s(mark, asked_s) - asked_s), float(answer["latency_ms"])


async def measure(demo: Demo, trials: int) -> posts.Row:
    row, told_ms = posts.Row("http", posts.STOP_LIMIT_MS), []
    ready = next(child for child in demo.children if child.name == "service").wait_ready()
    client = httpx2.AsyncClient(
        base_url=ready["url"], headers={"Authorization": f"Bearer {TOKEN}"}, trust_env=False, timeout=20
    )
    async with posts.Scene.of(demo) as scene, client:
        for _ in range(trials):
            found_ms, said_ms = await trial(scene, client)
            row.found_ms.append(found_ms)
            told_ms.append(said_ms)
    row.note = f"the service told p50 {posts.percentile(told_ms, 0.5):.0f} ms, worst {max(told_ms):.0f} ms"
    return row


def run(trials: int) -> posts.Row:
    with contextlib.ExitStack() as stack:
        data = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="agentrob-stop-")))
        demo = stack.enter_context(ServedDemo(DemoSettings(data, port=0)))
        demo.start()
        return asyncio.run(measure(demo, trials))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200, help="(default 200)")
    parser.add_argument("--json", action="store_true", help="print JSON with every single time")
    given = parser.parse_args()
    with sigterm_interrupts():
        row = run(given.trials)
    figures = row.figures()
    print(
        json.dumps({**figures, "found_ms": [round(x, 2) for x in row.found_ms]}) if given.json else posts.table([row])
    )
    raise SystemExit(0 if figures["ok"] else "missed: http")


if __name__ == "__main__":
    main()
