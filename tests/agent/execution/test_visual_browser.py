"""The report of a command that a model steered, in Chromium: every call with its pictures."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.board.admin import local_admin
from agentrob.config.forum import ForumConfig
from agentrob.forums.agentrob.forum import BoardForum
from tests.agent.agent_process import Poster
from tests.agent.agent_scene import ROBOT, Driver, robot_settings, serving
from tests.agent.execution.visual_model import DONE, running_loop_model
from tests.board.running_board import RunningBoard, running_board
from tests.board.web.browser_windows import running_chromium

DRAWS = True

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.usefixtures("model_libraries")]
SHOTS = Path(__file__).parents[3] / "var/screenshots"
CALLS = [
    ("act_turn", {"direction": "left", "degrees": 15}),
    ("act_backflip", {}),
    ("act_move", {"direction": "forward", "distance_m": 1.2, "look": True}),
    DONE,
]


async def looked(board: RunningBoard, driver: Driver, folder: Path) -> str:
    """Return the topic of a command that a model carried out."""
    settings = robot_settings(look={"allowed": True})
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    with running_loop_model() as scripted_model, Poster(board, "op") as op:
        scripted_model.loop_answers = list(CALLS)
        mind = scripted_model.mind(folder)
        await mind.prepare()
        async with serving(RobotAgent(ROBOT, settings, forum, driver.client(), mind, folder)):
            topic = await op.post(f"@{ROBOT} walk to the red ball and tell me what is beside it")
            assert await op.final(topic) == ["done"]
    return topic


@pytest.fixture(scope="module")
def thread(driver: Driver, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[RunningBoard, str]]:
    """Start a board with that topic."""
    folder = tmp_path_factory.mktemp("look")
    with running_board(folder / "board") as board:
        yield board, asyncio.run(looked(board, driver, folder))


@pytest.mark.parametrize("width", [1280, 390])
def test_the_calls_and_what_was_seen_are_on_the_page(thread: tuple[RunningBoard, str], width: int) -> None:
    board, topic = thread
    with running_chromium() as chromium:
        page = chromium.new_page(viewport={"width": width, "height": 900}, base_url=board.url)
        page.goto(local_admin.issue_link(board.settings, local_admin.find_account(board.settings, "op")))
        page.get_by_role("button", name="Enter").click()
        page.get_by_role("heading", name="Boards", exact=True).wait_for()
        page.goto(f"/t/{topic}")
        page.locator("article th").first.wait_for()
        report = page.locator("article").filter(has=page.locator("th"))
        heads = report.locator("th").all_inner_texts()
        assert heads == ["Step", "Called by the model", "Measured", "Outcome"]
        rows = [row.locator("td").all_inner_texts() for row in report.locator("tbody tr").all()]
        assert [row[1].split()[0] for row in rows] == ["take", "act_turn", "act_backflip", "act_move", "take", "finish"]
        assert [row[3] for row in rows if row[0]] == ["done, picture 1", "done", "done", "done, picture 2"]
        assert rows[2][3].startswith("not done: ")
        pictures = report.locator(".pictures img")
        photos = [row[0] for row in rows if row[3].startswith("done, picture")]
        for number, step in enumerate(photos):
            picture = pictures.nth(number)
            picture.scroll_into_view_if_needed()
            page.wait_for_function("image => image.naturalWidth > 0", arg=picture.element_handle())
            alt = f"Photo of step {step}, {number + 1} of {pictures.count()} by {ROBOT}"
            assert picture.get_attribute("alt") == alt
        assert page.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
        SHOTS.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=SHOTS / f"look-{width}.png", full_page=True)
