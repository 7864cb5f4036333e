"""Laws 6 and 7 for a command that needs an approval: its agent is killed between the request and the motion.

There must be one final reply and at most one motion, an approved command is done, and nobody is asked twice.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from agentrob.board.admin import local_admin, management
from agentrob.board.db.audit import SHELL
from agentrob.wiring import app
from tests.board.running_board import database_for
from tests.databases import BOTH
from tests.kill.kill_process import wait_for
from tests.kill.kill_scene import ROBOT, WALK, KillScene, PostedCommand, check

pytestmark = pytest.mark.slow
JOURNAL, APPROVALS, FORUM = (
    "agent.store.journal:Journal.",
    "agent.queue.approvals:Approvals.",
    "forums.agentrob.forum:BoardForum.",
)


class ApprovalScene(KillScene):
    """Require an approval for every motion, which the only person of the scene may give."""

    def __init__(self, folder: Path, database: str = "") -> None:
        super().__init__(folder, database)
        with local_admin.writing(app.board_settings(self.config)) as connection:
            rights = {"approval": ("move",), "approve": "operator", "approve_own": True}
            management.change_robot(connection, SHELL, ROBOT, **rights)

    def waits(self, command: PostedCommand) -> None:
        """Wait until its reply says that it waits."""
        wait_for(
            "it waits for an approval",
            lambda: [p for p in self.answers(command) if p["card"] and p["card"]["state"] == "waiting"],
            30.0,
        )

    def approve(self, command: PostedCommand) -> None:
        post = self.posted(command)
        said = {"body": f"@{ROBOT} approve", "reply_to": post["id"]}
        key = {"Idempotency-Key": secrets.token_hex(8)}
        self._request("POST", f"/topics/{post['topic_id']}/posts", json=said, headers=key)


@pytest.fixture(scope="module", params=BOTH)
def approval_scene(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ApprovalScene]:
    folder = tmp_path_factory.mktemp("kill")
    on_postgres = request.param == "postgresql"
    made = ApprovalScene(folder, database_for(request.getfixturevalue("postgres"), folder) if on_postgres else "")
    yield made
    made.close()


@dataclass(frozen=True)
class Point:
    """Where the agent is killed, before the approval (`asks`) or after it, and how the command ends."""

    name: str
    target: str
    when: str
    asks: bool = False
    containing: str = ""
    end: str = "done"


POINTS = [
    Point("asking not noted yet", JOURNAL + "ask", "before", asks=True),
    Point("asking noted", JOURNAL + "ask", "after", asks=True),
    Point(
        "request for approval to be shown",
        FORUM + "edit",
        "before",
        asks=True,
        containing="state=<CommandState.WAITING",
    ),
    Point("request for approval shown", FORUM + "edit", "after", asks=True, containing="state=<CommandState.WAITING"),
    Point("approval heard", APPROVALS + "record_decision", "before"),
    Point("approval not noted yet", JOURNAL + "decide", "before"),
    Point("approval noted", JOURNAL + "decide", "after"),
    Point("approval counted", APPROVALS + "record_decision", "after"),
    Point("approved and first in line", "agent.queue.queue:CommandQueue.turn", "after"),
    Point("attempt not committed yet", JOURNAL + "_begin", "before"),
    Point("attempt committed", JOURNAL + "_begin", "after", end="interrupted"),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_laws_6_and_7_killed_between_the_asking_and_the_motion(point: Point, approval_scene: ApprovalScene) -> None:
    target = "agentrob." + point.target
    approval_scene.arm("agent", {"target": target, "when": point.when, "nth": 1, "containing": point.containing})
    command = approval_scene.ask(WALK)
    if point.asks:
        approval_scene.wait_for_kill("agent")
        approval_scene.start("agent")
    approval_scene.waits(command)
    assert approval_scene.motions(command.began) == 0
    approval_scene.approve(command)
    if not point.asks:
        approval_scene.wait_for_kill("agent")
        approval_scene.start("agent")
    assert check(approval_scene, command) == point.end
    approval_scene.release()
