"""Approvals on the real board: its settings, the button on its pages, its API, and a post in the thread."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.board.admin import local_admin, management
from agentrob.board.db.audit import SHELL
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import Role
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_process import Poster, RunningBoard
from tests.agent.agent_scene import ROBOT, Driver, robot_settings
from tests.board.running_board import running_board
from tests.board.web.forum_site import PageClient
from tests.waiting import until

WAVE = f"@{ROBOT} wave"


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    """Return a board where `op` posts commands and `mod` approves gestures."""
    with running_board(tmp_path_factory.mktemp("board")) as made:
        made.add("mod", role=Role.MODERATOR)
        with local_admin.writing(made.settings) as connection:
            management.change_robot(connection, SHELL, ROBOT, approval=("gesture",))
        yield made


@asynccontextmanager
async def asked(board: RunningBoard, driver: Driver, folder: Path) -> AsyncIterator[tuple[Poster, str, str]]:
    """Run an agent with a waiting command: (the poster, its topic, its post)."""
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    client = DriverClient(driver.name, driver.socket)
    agent = RobotAgent(ROBOT, robot_settings(), forum, client, RulesMind(), folder)
    running = asyncio.create_task(agent.run())
    try:
        await asyncio.wait_for(agent.ready.wait(), 60)
        with Poster(board, "op") as op:
            topic = await op.post(WAVE)
            await states(op, topic, "waiting")
            first = await asyncio.to_thread(op._http.get, f"/topics/{topic}/posts")
            yield op, topic, first.json()["items"][0]["id"]
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await agent.close()


async def states(poster: Poster, topic: str, wanted: str) -> None:
    await until(lambda: poster.states(topic), lambda found: found == [wanted])


def page_client(board: RunningBoard, name: str) -> PageClient:
    client = board.browser(name)
    client.follow_redirects = True
    return PageClient(client)


@pytest.mark.parametrize(
    ("page", "do", "end"),
    [("/c/{post}", "approve", "done"), pytest.param(f"/robots/{ROBOT}", "deny", "refused", marks=pytest.mark.slow)],
)
async def test_law_7_the_button_of_a_page_approves_or_denies_what_waits(
    board: RunningBoard, driver: Driver, tmp_path: Path, page: str, do: str, end: str
) -> None:
    async with asked(board, driver, tmp_path) as (op, topic, post):
        path, where = f"/c/{post}/approve", page.format(post=post)
        await _line(board, post)
        for name in ("op", "member"):  # the author of the command, and an account without the right
            text = (await asyncio.to_thread(page_client(board, name).get, where)).text
            assert "waits for approval" in text.lower()
            assert path not in text
        mod = page_client(board, "mod")
        forged = await asyncio.to_thread(mod.client.post, path, data={"robot": ROBOT, "do": do, "csrf": "guess"})
        assert forged.status_code == 403
        shown = await asyncio.to_thread(lambda: mod.send(path, where, do=do))
        assert f"You {'approved' if do == 'approve' else 'denied'} a command" in shown.text
        assert await op.final(topic) == [end]
        again = await asyncio.to_thread(
            lambda: mod.client.post(path, data={"robot": ROBOT, "do": do, "csrf": mod.csrf(f"/robots/{ROBOT}")})
        )
        assert again.status_code == 409
        items = (await asyncio.to_thread(op._http.get, f"/topics/{topic}/posts")).json()["items"]
        said = [(i["raw"], i["author"]["name"], i["reply_to"]) for i in items[1:] if i["author"]["name"] != ROBOT]
        assert said == [(f"@{ROBOT} {do}", "mod", post)]


@pytest.mark.slow
async def test_law_2_the_api_approves_for_who_may_and_for_nobody_else(
    board: RunningBoard, driver: Driver, tmp_path: Path
) -> None:
    async with asked(board, driver, tmp_path) as (op, topic, post):
        path = f"/commands/{post}/approve"

        async def said(name: str, **more: Any) -> int:
            body = {"robot": ROBOT} | more
            return (await asyncio.to_thread(board.client(name).post, path, json=body)).status_code

        assert [await said(name) for name in ("op", "member", ROBOT)] == [403, 403, 403]
        assert [await said("mod", robot="nobody"), await said("mod", approve="yes")] == [404, 422]
        assert await op.states(topic) == ["waiting"]
        assert await said("mod") == 201
        assert await op.final(topic) == ["done"]
        assert await said("mod") == 409
        page = partial(asyncio.to_thread, page_client(board, "op").get, f"/c/{post}")
        await until(page, lambda answer: "Approved by" in answer.text)  # the record follows the reply


@pytest.mark.slow
async def test_law_2_an_approver_who_was_demoted_before_the_word_was_heard_approves_nothing(
    board: RunningBoard, driver: Driver, tmp_path: Path
) -> None:
    async with asked(board, driver, tmp_path) as (op, topic, post):
        mod = local_admin.find_account(board.settings, "mod")
        local_admin.change_account(board.settings, mod, role=Role.OPERATOR)
        try:
            body = {"body": f"@{ROBOT} approve", "reply_to": post}
            answer = await asyncio.to_thread(board.client("mod").post, f"/topics/{topic}/posts", json=body)
            said = answer.raise_for_status().json()["post"]["id"]
            await _answered(op, topic, said)
            assert await op.states(topic) == ["waiting"]
        finally:
            local_admin.change_account(board.settings, mod, role=Role.MODERATOR)


@pytest.mark.slow
async def test_law_7_the_owner_s_settings_let_an_author_approve_alone(
    board: RunningBoard, driver: Driver, tmp_path: Path
) -> None:
    def change(**what: Any) -> None:
        with local_admin.writing(board.settings) as connection:
            management.change_robot(connection, SHELL, ROBOT, **what)

    change(approve="operator", approve_own=True)
    try:
        async with asked(board, driver, tmp_path) as (op, topic, post):
            rights = (await asyncio.to_thread(op._http.get, f"/robots/{ROBOT}/rights?board_id=robots")).json()
            assert (rights["approve"], rights["approve_own"]) == ("operator", True)
            own = await asyncio.to_thread(op._http.post, f"/commands/{post}/approve", json={"robot": ROBOT})
            assert own.status_code == 201
            assert await op.final(topic) == ["done"]
    finally:
        change(approve="moderator", approve_own=False)


async def _line(board: RunningBoard, post: str) -> None:
    """Wait until the robot's page shows its queue."""
    await until(lambda: post in board.services.presence.robot(ROBOT).card.get("line", ()))


async def _answered(poster: Poster, topic: str, post: str) -> None:
    async with asyncio.timeout(60):
        while True:
            items = (await asyncio.to_thread(poster._http.get, f"/topics/{topic}/posts")).json()["items"]
            if any(item["reply_to"] == post for item in items):
                return
            await asyncio.sleep(0.02)
