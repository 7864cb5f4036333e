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
from tests.kill.kill_house import ROBOT, WALK, Asked, House, check
from tests.kill.kill_process import wait_for

pytestmark = pytest.mark.slow
JOURNAL, APPROVALS, FORUM = (
    "agent.store.journal:Journal.",
    "agent.queue.approvals:Approvals.",
    "forums.agentrob.forum:BoardForum.",
)


class AskingHouse(House):
    """Require an approval for every motion, which the only person of the house may give."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        with local_admin.writing(app.board_settings(self.config)) as connection:
            rights = {"approval": ("move",), "approve": "operator", "approve_own": True}
            management.change_robot(connection, SHELL, ROBOT, **rights)

    def waits(self, asked: Asked) -> None:
        """Wait until its reply says that it waits."""
        wait_for(
            "it waits for an approval",
            lambda: [p for p in self.answers(asked) if p["card"] and p["card"]["state"] == "waiting"],
            30.0,
        )

    def approve(self, asked: Asked) -> None:
        post = self.posted(asked)
        said = {"body": f"@{ROBOT} approve", "reply_to": post["id"]}
        key = {"Idempotency-Key": secrets.token_hex(8)}
        self._insist("POST", f"/topics/{post['topic_id']}/posts", json=said, headers=key)


@pytest.fixture(scope="module", params=BOTH)
def asking(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[AskingHouse]:
    folder = tmp_path_factory.mktemp("kill")
    on_postgres = request.param == "postgresql"
    made = AskingHouse(folder, database_for(request.getfixturevalue("postgres"), folder) if on_postgres else "")
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
    Point("to be told that it waits", FORUM + "edit", "before", asks=True, containing="state=<CommandState.WAITING"),
    Point("told that it waits", FORUM + "edit", "after", asks=True, containing="state=<CommandState.WAITING"),
    Point("approval heard", APPROVALS + "hear", "before"),
    Point("approval not noted yet", JOURNAL + "decide", "before"),
    Point("approval noted", JOURNAL + "decide", "after"),
    Point("approval counted", APPROVALS + "hear", "after"),
    Point("approved and first in line", "agent.queue.queue:CommandQueue.turn", "after"),
    Point("attempt not committed yet", JOURNAL + "_begin", "before"),
    Point("attempt committed", JOURNAL + "_begin", "after", end="interrupted"),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_laws_6_and_7_killed_between_the_asking_and_the_motion(point: Point, asking: AskingHouse) -> None:
    target = "agentrob." + point.target
    asking.arm("agent", {"target": target, "when": point.when, "nth": 1, "containing": point.containing})
    asked = asking.ask(WALK)
    if point.asks:
        asking.died("agent")
        asking.start("agent")
    asking.waits(asked)
    assert asking.motions(asked.began) == 0
    asking.approve(asked)
    if not point.asks:
        asking.died("agent")
        asking.start("agent")
    assert check(asking, asked) == point.end
    asking.release()
