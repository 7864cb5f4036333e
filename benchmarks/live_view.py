"""Measure what live maps cost: the board's share of a core and the traffic of a viewer, and stops while many watch.

    python benchmarks/live_view.py [--viewers 50] [--seconds 10] [--trials 20]

First a board alone: one robot's agent sends poses as often as the board asks for them, and the viewers read them on raw
connections; once as maps, once as 3D views of a G1 (29 joints). Then the demo, as `benchmarks/stop.py` measures stops,
with the viewers watching the robot that is stopped. `--trials 0` leaves the demo out.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import math
import os
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

import board
import stop

from agentrob.board.admin import local_admin
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.demo.run import Demo, DemoSettings
from agentrob.model import AccountKind
from agentrob.process.signals import sigterm_interrupts

CORE_PERCENT, TRAFFIC_KB = 1.5, 10.0
JOINTS = 29
WARM_S = 1.5


class Viewer(asyncio.Protocol):
    """One viewer: counts what it receives, and does nothing else."""

    def __init__(self) -> None:
        self.bytes = self.poses = 0

    def data_received(self, data: bytes) -> None:
        self.bytes += len(data)
        self.poses += data.count(b'"pose"')


@contextlib.asynccontextmanager
async def watching(port: int, token: str, robot: str, viewers: int, body: bool) -> AsyncIterator[list[Viewer]]:
    """Open the map of a robot so many times."""
    loop, found = asyncio.get_running_loop(), []
    path = f"/api/v1/poses?robots={robot}&body={int(body)}"
    asked = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAuthorization: Bearer {token}\r\n\r\n"
    with contextlib.ExitStack() as stack:
        for _ in range(viewers):
            transport, viewer = await loop.create_connection(Viewer, "127.0.0.1", port)
            stack.callback(transport.close)
            transport.write(asked.encode())
            found.append(viewer)
        yield found


async def sending(client: board.Client, body: bool, sent: list[int]) -> None:
    """Send poses of a walking robot as its agent does: the next one when the board asks for it."""
    began_s = time.monotonic()
    while True:
        t = time.monotonic() - began_s
        frame: dict[str, object] = {"pose": [round(math.cos(t / 5), 3), round(math.sin(t / 5), 3), round(t % 3, 3)]}
        frame["body"] = [round(math.sin(t + n), 3) for n in range(5 + JOINTS)]
        begun_s = time.monotonic()
        answer = json.loads(await client.call(client.request("PUT", "/api/v1/robots/quadruped/pose", frame)))
        sent[0] += 1
        await asyncio.sleep(max(0.0, answer["every_s"] - (time.monotonic() - begun_s)))


async def one_load(
    server: board.Server, agent: str, viewers: int, seconds: float, *, body: bool, robot: bool = True
) -> tuple[float, float, float, float]:
    """The board's share of a core in percent, kB/s and poses/s of a viewer, poses/s of the robot."""
    sent, feeding = [0], None
    async with watching(server.port, server.token, "quadruped", viewers, body) as found:
        if robot:
            client = await board.Client(server.port, f"Authorization: Bearer {agent}").open()
            feeding = asyncio.create_task(sending(client, body, sent))
        await asyncio.sleep(WARM_S)
        cpu_s, begun_s, before = server.cpu_s(), time.monotonic(), sent[0]
        received, poses = sum(v.bytes for v in found), sum(v.poses for v in found)
        await asyncio.sleep(seconds)
        took_s, used_s = time.monotonic() - begun_s, server.cpu_s() - cpu_s
        if feeding is not None:
            feeding.cancel()
        each = max(1, viewers) * took_s
        kb = (sum(v.bytes for v in found) - received) / 1000 / each
        return 100 * used_s / took_s, kb, (sum(v.poses for v in found) - poses) / each, (sent[0] - before) / took_s


async def measure_board(server: board.Server, agent: str, viewers: int, seconds: float) -> bool:
    print("| load | of a core | for the viewers | kB/s each | poses/s each |", "|---|---|---|---|---|", sep="\n")
    rows = list[tuple[float, float]]()
    alone = dict[str, float]()
    idle, *_ = await one_load(server, agent, 0, seconds, body=False, robot=False)
    print(f"| nobody, no robot | {idle:.2f} % | | | |")
    for kind, body in (("map", False), ("3D", True)):
        alone[kind], *_ = await one_load(server, agent, 1, seconds, body=body)
        print(f"| {kind}: robot and 1 viewer | {alone[kind]:.2f} % | | | |")
        core, kb, poses, _ = await one_load(server, agent, viewers, seconds, body=body)
        more = core - alone[kind]
        print(f"| {kind}: robot and {viewers} viewers | {core:.2f} % | {more:.2f} % | {kb:.1f} | {poses:.1f} |")
        rows.append((more, kb))
    return all(more <= CORE_PERCENT and kb <= TRAFFIC_KB for more, kb in rows)


def run_board(viewers: int, seconds: float) -> bool:
    with tempfile.TemporaryDirectory() as folder, board.serving(folder, 50) as server:
        settings = BoardSettings.from_config(BoardConfig(), Path(folder))
        robot = local_admin.create_account(settings, "quadruped", kind=AccountKind.ROBOT_AGENT)
        agent = local_admin.issue_token(settings, robot)
        return asyncio.run(measure_board(server, agent, viewers, seconds))


# ---------------------------------------------------------------------- stops
async def measure_stops(demo: Demo, trials: int, viewers: int) -> stop.Row:
    row = stop.Row(f"{viewers} viewers", stop.STOP_LIMIT_MS)
    port, token = int(demo.url.rsplit(":", 1)[1]), demo.tokens[stop.VISITOR]
    async with stop.Scene.of(demo) as scene, watching(port, token, stop.ROBOT, viewers, True) as found:
        for _ in range(trials):
            row.found_ms.append(await stop.stopped(scene))
        seen = min((viewer.poses for viewer in found), default=0)
        row.note = f"each saw {seen} poses or more" if viewers else ""
        row.void = "" if seen or not viewers else "a viewer saw nothing"
    return row


def run_stops(trials: int, viewers: int) -> stop.Row:
    with contextlib.ExitStack() as stack:
        data = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="agentrob-live-")))
        demo = stack.enter_context(Demo(DemoSettings(data, port=0)))
        demo.start()
        return asyncio.run(measure_stops(demo, trials, viewers))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--viewers", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=10.0, help="how long each load lasts")
    parser.add_argument("--trials", type=int, default=20, help="stops, without viewers and with them (default 20)")
    given = parser.parse_args()
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    missed = [] if run_board(given.viewers, given.seconds) else ["the cost of viewers"]
    if given.trials:
        with sigterm_interrupts():
            rows = [run_stops(given.trials, viewers) for viewers in (0, given.viewers)]
        print(stop.table(rows))
        missed += [row.condition for row in rows if not row.figures()["ok"]]
    raise SystemExit(f"missed: {', '.join(missed)}" if missed else 0)


if __name__ == "__main__":
    main()
