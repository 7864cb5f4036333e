"""Let a model steer a robot on this machine without a forum, for `agentrob drive`."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime

from agentrob.agent.execution.execute import Execution, ExecutionHooks
from agentrob.agent.execution.visual import run_visual_task
from agentrob.agent.understanding.visual_goal import visual_task_of
from agentrob.config.robots import RobotConfig
from agentrob.language.goal import Goal
from agentrob.minds.llm.chat import ChatModel
from agentrob.model import Account, ActionResult, Capabilities, Command, Language, Plan, Verdict
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.screen import screen


async def run_visual_task_locally(
    driver: DriverClient,
    goal: Goal,
    vision_model: ChatModel,
    settings: RobotConfig,
    text: str,
    author: Account,
    language: Language,
    on_result: Callable[[ActionResult], None],
) -> Execution:
    """Let a model reach a goal through a driver, whose client is then closed, with the same budgets, mandate and screen
    as on a forum.

    It ends on `agentrob stop`, on a stop of the hardware, or with this process.
    """
    await vision_model.prepare()  # no first question then waits for a library while the robot's lease is held
    async with driver:
        capabilities = await driver.capabilities()
        now = datetime.now(UTC)
        command = Command("drive", "drive", "", author, driver.robot, text, language, now, f"drive-{now:%H%M%S}")
        hooks = _hooks(driver, lambda plan: judge(plan, text, author, capabilities, language, settings))
        visual_task = visual_task_of(goal, vision_model, capabilities, settings.look, language)
        return await run_visual_task(driver, command, visual_task, hooks, on_result)


def judge(
    plan: Plan, text: str, author: Account, capabilities: Capabilities, language: Language, settings: RobotConfig
) -> Verdict:
    """Screen a step, or the part of a goal that can be judged before it is pursued."""
    return screen(
        plan, text=text, author=author, capabilities=capabilities, language=language, consents=settings.consents,
        scene=settings.scene, part="",
    )  # fmt: skip


def _hooks(driver: DriverClient, judged: Callable[[Plan], Verdict]) -> ExecutionHooks:
    began_s = time.monotonic()

    async def since() -> float:
        return began_s

    async def permit(plan: Plan) -> tuple[Verdict, Capabilities | None]:
        return judged(plan), await driver.capabilities()

    async def alive() -> bool:
        return True

    return ExecutionHooks(
        since=since, permit=permit, ended=lambda: None, alive=alive, silent=lambda: False, stop=driver.stop,
        on_step=lambda *_: None,
    )  # fmt: skip
