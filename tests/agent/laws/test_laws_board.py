"""Laws 4 and 5 on the real board: a post is edited or removed, or its author loses a right, before and during the
motion."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from uuid import uuid4

import pytest

from agentrob.agent import motion
from agentrob.agent.agent import RobotAgent
from agentrob.board.admin import local_admin, management, moderation
from agentrob.board.auth.rights import MaintenanceWindow
from agentrob.board.db.audit import SHELL
from agentrob.board.db.records import Board
from agentrob.board.db.writer import Transaction
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import Account, ActionClass, ActionResult, Capabilities, Primitive, Role
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_process import Poster, RunningBoard, until_state
from tests.agent.agent_scene import ROBOT, Driver, robot_settings, serving
from tests.agent.store.journal_store import open_journal
from tests.board.running_board import running_board
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("database")
AGENTS_DIE = True

CHANGES = ("edit", "remove", "hide", "suspend", "demote", "narrow", "close", "move")
#: Changes that lead to a refusal with a reason instead of a cancellation.
REFUSED = ("demote", "narrow", "close", "move")
WALK = f"@{ROBOT} walk forward 0.5 metres, then turn left 40 degrees"


class GatedClient(DriverClient):
    """A driver client that holds back the end of each step until it is released."""

    def __init__(self, driver: Driver) -> None:
        super().__init__(driver.name, driver.socket)
        self.begun: list[str] = []
        self.busy, self.let = asyncio.Event(), asyncio.Event()

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        self.begun.append(str(primitive.op))
        result = await super().step(lease, primitive, deadline_s)
        self.busy.set()
        await self.let.wait()
        return result


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as made:
        yield made


@asynccontextmanager
async def serving_on(board: RunningBoard, client: DriverClient, folder: Path) -> AsyncIterator[None]:
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    opened = partial(open_journal, folder, ROBOT)
    async with serving(RobotAgent(ROBOT, robot_settings(), forum, client, RulesMind(), folder, open_journal=opened)):
        yield


def change(board: RunningBoard, what: str, topic: str) -> None:
    """Take the post away: by its author, by an admin, or by suspending the account."""
    account = local_admin.find_account(board.settings, "pilot")
    own, chief = board.client("pilot"), board.client("admin")
    post = own.get(f"/topics/{topic}/posts").json()["items"][0]["id"]
    match what:
        case "edit":
            own.patch(f"/posts/{post}", json={"body": f"{WALK} and wave"}).raise_for_status()
        case "remove":
            own.delete(f"/posts/{post}").raise_for_status()
        case "hide":
            chief.delete(f"/posts/{post}").raise_for_status()
        case "suspend":
            local_admin.change_account(board.settings, account, suspended=True)
        case "demote":
            local_admin.change_account(board.settings, account, role=Role.MEMBER)
        case "narrow" | "close" | "move":
            revoke_right(board, what, topic)


def revoke_right(board: RunningBoard, what: str, topic: str) -> None:
    """Take the right away, on the robot's or the board's side."""
    with local_admin.writing(board.settings) as connection:
        match what:
            case "narrow":
                rights = dict.fromkeys(ActionClass, "operator") | {ActionClass.MOVE: "owner"}
                management.change_robot(connection, SHELL, ROBOT, command=rights)
            case "close":
                until = datetime.now(UTC) + timedelta(hours=1)
                management.change_robot(connection, SHELL, ROBOT, closed=(MaintenanceWindow(until=until),))
            case "move":
                management.change_board(connection, SHELL, "talk", command_role=Role.ADMIN)
                shell = Account("0", SHELL, role=Role.ADMIN)
                moderation.move(Transaction(connection), shell, topic, "talk")


@pytest.fixture
def pilot(board: RunningBoard) -> Iterator[Poster]:
    """Return an operator with all rights."""
    if "pilot" not in board.tokens:
        board.add("pilot", role=Role.OPERATOR)
    account = local_admin.find_account(board.settings, "pilot")
    usual = {"role": Role.OPERATOR, "suspended": False, "commands_simulated": False}
    local_admin.change_account(board.settings, account, **usual)
    with local_admin.writing(board.settings) as connection:
        rights = dict.fromkeys(ActionClass, "operator")
        management.change_robot(connection, SHELL, ROBOT, command=rights, closed=())
        management.change_board(connection, SHELL, "robots", command_role=Role.OPERATOR)
    with Poster(board, "pilot") as made:
        yield made


@pytest.mark.parametrize("what", CHANGES)
async def test_law_4_on_the_board_what_changed_while_it_waited_in_line_does_not_move(
    board: RunningBoard, driver: Driver, pilot: Poster, tmp_path: Path, what: str
) -> None:
    client = GatedClient(driver)
    async with serving_on(board, client, tmp_path):
        with Poster(board, "op") as op:
            first = await op.post(f"@{ROBOT} turn right 20 degrees")
            await asyncio.wait_for(client.busy.wait(), 60)
            topic = await pilot.post(WALK)
            await queued(op, topic)
            await asyncio.to_thread(change, board, what, topic)
            client.let.set()
            assert await op.final(first) == ["done"]
            assert await op.final(topic) == ["refused" if what in REFUSED else "cancelled"], await op.status_text(topic)
    assert client.begun == ["turn"], "only the first command moved it"


async def test_law_4_on_the_board_the_right_to_command_simulated_robots_is_asked_again_before_motion(
    board: RunningBoard, driver: Driver, pilot: Poster, tmp_path: Path
) -> None:
    account = local_admin.find_account(board.settings, "pilot")

    def grant(simulated: bool) -> None:
        with local_admin.writing(board.settings) as connection:
            changed = {"role": Role.MEMBER, "commands_simulated": simulated}
            management.change_account(connection, SHELL, account.name, **changed)

    grant(True)
    client = GatedClient(driver)
    async with serving_on(board, client, tmp_path):
        with Poster(board, "op") as op:
            first = await pilot.post(f"@{ROBOT} turn right 20 degrees")
            await asyncio.wait_for(client.busy.wait(), 60)
            topic = await pilot.post(WALK)
            await queued(op, topic)
            await asyncio.to_thread(grant, False)
            client.let.set()
            await op.final(first)
            assert await op.final(topic) == ["refused"], await op.status_text(topic)
    assert client.begun == ["turn"], "only the command from before moved it"


class RealClient(GatedClient):
    """A driver client whose robot does not say that it is simulated."""

    async def capabilities(self) -> Capabilities:
        return replace(await super().capabilities(), simulated=False)


async def test_law_2_on_the_board_a_robot_that_is_not_simulated_refuses_an_account_for_simulated_ones(
    board: RunningBoard, driver: Driver, pilot: Poster, tmp_path: Path
) -> None:
    account = local_admin.find_account(board.settings, "pilot")
    local_admin.change_account(board.settings, account, role=Role.MEMBER, commands_simulated=True)
    client = RealClient(driver)
    async with serving_on(board, client, tmp_path):
        topic = await pilot.post(WALK)
        assert await pilot.final(topic) == ["refused"]
        assert "simulated robots only" in await pilot.status_text(topic)
    assert client.begun == []


@pytest.mark.parametrize("what", CHANGES)
async def test_law_4_on_the_board_what_changes_while_it_moves_begins_no_further_step(
    board: RunningBoard, driver: Driver, pilot: Poster, tmp_path: Path, what: str
) -> None:
    client = GatedClient(driver)
    async with serving_on(board, client, tmp_path):
        topic = await pilot.post(WALK)
        await asyncio.wait_for(client.busy.wait(), 60)
        await asyncio.to_thread(change, board, what, topic)
        client.let.set()
        with Poster(board, "op") as op:
            assert await op.final(topic) == ["refused" if what in REFUSED else "cancelled"], await op.status_text(topic)
    assert client.begun == ["move"]
    await until_state(driver, lambda state: state.velocity_mps == (0.0, 0.0))


async def queued(poster: Poster, topic: str) -> None:
    await until(lambda: poster.states(topic), lambda states: states == ["queued"])


@pytest.fixture
def slow_driver(tmp_path: Path) -> Iterator[Driver]:
    made = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="slow", lease_s=TTL_S)
    yield made
    made.end()


async def test_law_13_a_robot_stops_when_its_account_may_no_longer_read_the_thread(
    board: RunningBoard, slow_driver: Driver, pilot: Poster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stop in that thread would not reach it."""
    monkeypatch.setattr(motion, "READ_AGAIN_S", 0.1)
    async with serving_on(board, DriverClient(slow_driver.name, slow_driver.socket), tmp_path):
        topic = await pilot.post(f"@{ROBOT} walk forward 5 metres slowly")
        await until_state(slow_driver, lambda state: any(state.velocity_mps or ()))
        vault = Board(f"vault-{uuid4().hex[:8]}", "Vault", read_role=Role.ADMIN, post_role=Role.ADMIN)
        with local_admin.writing(board.settings) as connection:
            management.add_board(connection, SHELL, vault)
            shell = Account("0", SHELL, role=Role.ADMIN)
            moderation.move(Transaction(connection), shell, topic, vault.id)
        await until_state(slow_driver, lambda state: state.velocity_mps == (0.0, 0.0))
    async with slow_driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    assert pose.x_m < 4.0, "it would have walked 5 m, in 25 s"
