"""A stop over HTTP: laws 13 to 15."""

from __future__ import annotations

import asyncio
import sys
import time
from asyncio.subprocess import PIPE
from pathlib import Path

from agentrob.forums.memory.forum import MemoryForum
from tests.agent.agent_scene import ROBOT, Driver
from tests.agent.store.journal_store import fail_disk
from tests.service.service_scene import Service, make_service, token


async def test_law_13_a_stop_over_http_stops_and_returns_the_measurements(service: Service) -> None:
    command = await service.submit("alice", "walk forward 5 m")
    await service.moving(command)
    stopped = (await service.call("bob", "POST", "/stop")).json()
    assert stopped["reached"]
    assert stopped["confirmed"]
    assert stopped["was_moving"]
    assert stopped["ended"] == 1
    assert 0 <= stopped["latency_ms"] < 500
    ended = await service.end(command)
    assert (ended["state"], ended["stopped_by"]) == ("stopped", "bob")
    reply = await service.scene.final(service.scene.world.posts[command["id"]])
    assert "**Stopped** by `bob`" in reply.raw


async def test_law_13_a_submitted_stop_is_a_stop_post_and_dont_stop_is_not(service: Service) -> None:
    command = await service.submit("alice", "walk forward 5 m")
    await service.moving(command)
    assert (await service.submit("bob", "please don't stop"))["state"] != "stop"
    said = await service.submit("bob", "stop")
    assert (said["state"], said["ended"]) == ("stop", True)
    assert (await service.end(command))["state"] == "stopped"


async def test_law_14_a_stop_ends_all_earlier_posts_and_only_a_later_post_moves(service: Service) -> None:
    first = await service.submit("alice", "walk forward 5 m")
    await service.moving(first)
    waiting = [await service.submit(who, "walk forward 5 m") for who in ("planner", "alice")]
    stopped = (await service.call("bob", "POST", "/stop")).json()
    assert stopped["reached"]
    at_m = await service.x_m()
    states = [(await service.end(command))["state"] for command in (first, *waiting)]
    assert states == ["stopped", "cancelled", "cancelled"]
    assert await service.x_m() - at_m < 0.05
    later = await service.end(await service.submit("alice", "walk forward 0.2 m"))
    assert later["state"] == "done"


async def test_law_14_a_stop_also_ends_posts_that_the_agent_does_not_know_yet(driver: Driver, tmp_path: Path) -> None:
    """The forum is polled on request only, so the agent does not know the post yet when the stop arrives."""
    world = MemoryForum.world(clock_offset_s=0.0)
    async with make_service(driver, tmp_path, world=world, listens=False) as service:
        at_m = await service.x_m()
        post = await service.scene.post("alice", "@quadruped walk forward 2 m")
        await service.call("bob", "POST", "/stop")
        assert (await service.call("alice", "POST", "/scan")).json()["heard"]
        ended = await service.call("watcher", "GET", f"/commands/{post.id}?wait_s=10")
        assert ended.json()["state"] == "cancelled"
        assert abs(await service.x_m() - at_m) < 0.001  # it may still come to rest from the test before


async def test_law_15_no_limit_applies_to_a_stop(driver: Driver, tmp_path: Path) -> None:
    async with make_service(driver, tmp_path, per_minute=3) as service:
        answers = [(await service.call("alice", "GET", "")).status_code for _ in range(5)]
        assert answers == [200, 200, 200, 429, 429]
        begun_s = time.monotonic()
        stops = await asyncio.gather(*(service.call("alice", "POST", "/stop") for _ in range(40)))
        assert {answer.status_code for answer in stops} == {200}
        assert all(answer.json()["confirmed"] for answer in stops)
        assert time.monotonic() - begun_s < 10


async def test_law_15_a_stop_needs_no_forum_and_no_journal(service: Service) -> None:
    command = await service.submit("alice", "walk forward 5 m")
    await service.moving(command)
    service.scene.world.reachable = False
    assert not service.agent.journal._rows.closed
    fail_disk(service.agent.journal)
    stopped = (await service.call("bob", "POST", "/stop")).json()
    service.scene.world.reachable = True
    assert stopped["confirmed"]
    assert stopped["latency_ms"] < 500


async def test_law_15_a_stop_works_before_the_forum_is_first_reached(driver: Driver, tmp_path: Path) -> None:
    world = MemoryForum.world()
    world.reachable = False
    async with make_service(driver, tmp_path, world=world, wait=False) as service:
        assert (await service.http.get(f"{service.url}/readyz")).status_code == 503
        assert (await service.call("alice", "POST", "/commands", {"text": "walk 1 m"})).json()["code"] == "starting"
        assert (await service.call("alice", "POST", "/stop")).json()["confirmed"]
        world.reachable = True
        async with asyncio.timeout(60):
            await service.agent.ready.wait()
        assert (await service.end(await service.submit("alice", "walk forward 0.2 m")))["state"] == "done"


async def test_law_15_suspended_accounts_and_robots_may_not_stop(service: Service) -> None:
    command = await service.submit("alice", "walk forward 1 m")
    await service.moving(command)
    service.scene.world.suspend("bob")
    for caller in service.parts.auth.all:
        await caller.refresh()
    for who in ("bob", "other-robot"):
        answer = await service.call(who, "POST", "/stop")
        assert (answer.status_code, answer.json()["code"]) == (403, "may_not_stop")
    assert (await service.end(command))["state"] == "done"


async def test_law_17_an_unreachable_driver_is_reported(tmp_path: Path) -> None:
    class Nobody(Driver):
        def __init__(self) -> None:
            self.name, self.socket = ROBOT, tmp_path / "nobody.sock"

    async with make_service(Nobody(), tmp_path, domain=229) as service:
        stopped = (await service.call("alice", "POST", "/stop")).json()
        assert not stopped["reached"]
        assert "NOT STOPPED" in stopped["message"]


#: A separate program that floods the service with reads from many clients until its standard input ends. It reports
#: when each client has had one response, and at the end the statuses.
FLOOD = """
import asyncio, sys, httpx2
url, token, askers = sys.argv[1], sys.argv[2], int(sys.argv[3])

async def main():
    seen, first, ended = set(), set(), asyncio.Event()
    asyncio.get_running_loop().add_reader(0, ended.set)

    async def ask(number, http):
        while not ended.is_set():
            seen.add((await http.get(url + ("", "/camera.jpg", "/queue")[number % 3])).status_code)
            first.add(number)
            if len(first) == askers:
                first.add(-1)
                print("begun", flush=True)

    limits, headers = httpx2.Limits(max_connections=askers), {"Authorization": f"Bearer {token}"}
    async with httpx2.AsyncClient(timeout=100, trust_env=False, limits=limits, headers=headers) as http:
        await asyncio.gather(*(ask(number, http) for number in range(askers)))
    print(*seen, flush=True)

asyncio.run(main())
"""


async def test_law_15_a_flood_of_reads_leaves_capacity_for_a_stop(service: Service) -> None:
    await service.end(await service.submit("alice", "turn left 5 degrees"))  # imports what it needs
    command = await service.submit("alice", "walk forward 5 m")
    await service.moving(command)
    url = f"{service.url}/api/v1/robots/{ROBOT}"
    arguments = ("-c", FLOOD, url, token("alice"), "120")
    flood = await asyncio.create_subprocess_exec(sys.executable, *arguments, stdin=PIPE, stdout=PIPE)
    assert flood.stdout is not None
    try:
        async with asyncio.timeout(60):
            assert await flood.stdout.readline() == b"begun\n"
            asked_s = time.monotonic()
            stopped = (await service.call("bob", "POST", "/stop")).json()
            took_s = time.monotonic() - asked_s
            said, _ = await flood.communicate(b"")
    finally:
        if flood.returncode is None:
            flood.kill()
    assert stopped["confirmed"]
    assert stopped["latency_ms"] < 1000
    assert took_s < 2, "with the way to the door and back"
    assert set(map(int, said.split())) <= {200, 429}
    assert (await service.end(command))["state"] == "stopped"
