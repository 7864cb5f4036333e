"""Release a locked robot and set its home when its owner presses the buttons of its page (laws 2, 9 and 17), and say in
replies how that is done."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from datetime import datetime
from typing import Any, Literal

import structlog

from agentrob.agent.intake.authorization import own_rights
from agentrob.agent.intake.triage import obeyed
from agentrob.agent.stop.replies import StopReplies
from agentrob.agent.stop.stop_handler import StopHandler
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, RobotError
from agentrob.forums.protocol import Event, Forum, RobotControls, RobotRightsSource
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.model import (
    EMERGENCY_STOP,
    Account,
    CommandState,
    Decision,
    EventKind,
    Language,
    Lock,
    Report,
    RobotRights,
    RobotState,
)
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.safety.lock import held_for
from agentrob.screening.rights import may

#: A button counts for so long after it was pressed: what the owner saw then is no longer what is there.
FRESH_S = 30.0
#: Asking the driver, or the forum where the robot's page is, may delay a reply by so much.
ASK_S = 1.0
_LOCKED = frozenset({"halted", "halt"})
#: A fall and a jump of the odometry void the home.
_HOMELESS = frozenset({"not_homed", "odometry_jump", "fallen"})
OwnerAction = Literal["release", "home"]
_log = structlog.get_logger()


class OwnerActions:
    """One robot's. `last_action` is the result of the last press, for the robot's card; None before the first one.

    `now` is the forum's clock, `changed` hears that the card should be renewed.
    """

    def __init__(
        self,
        name: str,
        settings: RobotConfig,
        forum: Forum,
        driver: DriverClient,
        stops: StopReplies,
        stop_handler: StopHandler,
        now: Callable[[], datetime],
        changed: Callable[[], None],
    ) -> None:
        self.last_action: dict[str, Any] | None = None
        self._name = name
        self._settings = settings
        self._forum = forum
        self._driver = driver
        self._stops = stops
        self._stop_handler = stop_handler
        self._now = now
        self._changed = changed
        self._page = ""
        self._one_at_a_time = asyncio.Lock()

    # ------------------------------------------------------------------ buttons
    async def pressed(self, event: Event, me: Account) -> None:
        """Release the robot or set its home, if the account may and pressed just now. Never moves anything."""
        by = event.account
        action: OwnerAction = "release" if event.kind is EventKind.ROBOT_RELEASE else "home"
        if by is None or not obeyed(by, me):
            return
        pressed_s = time.monotonic() - max(0.0, (self._now() - event.at).total_seconds())
        async with self._one_at_a_time:
            try:
                why = await self._objection(by, action, pressed_s)
                done, message = (False, why) if why else await self._do(action, by.name, event.at, pressed_s)
            except RobotError as e:
                done, message = False, f"{e}."
        level = _log.info if done else _log.warning
        level("owner's button", robot=self._name, action=action, by=by.name, done=done, message=message)
        self.last_action = {
            "action": action, "by": by.name, "at": self._now().isoformat(), "done": done, "message": message,
        }  # fmt: skip
        self._changed()

    async def _objection(self, by: Account, action: OwnerAction, pressed_s: float) -> str:
        """Why this press does not count, by the rights of now; empty if it does."""
        if time.monotonic() - pressed_s > FRESH_S:
            return f"It was pressed more than {FRESH_S:.0f} s before I heard of it. Look at the robot, and press again."
        try:
            account = await self._forum.account(by.name)
            rights = await self._rights()
        except ForumError:
            return "I could not check whether this account may do that. Press again."
        if account is None or account.id != by.id:
            return "This account is no longer there."
        verdict = may(account, action, "en", self._settings.owner, rights)
        return "" if verdict.decision is Decision.ALLOW else verdict.reason

    async def _rights(self) -> RobotRights:
        if not isinstance(self._forum, RobotRightsSource) or not self._settings.boards:
            return own_rights(self._settings)
        try:
            return await self._forum.robot_rights(self._name, self._settings.boards[0])
        except (ForumNotFound, ForumDenied):
            return RobotRights()

    async def _do(self, action: OwnerAction, by: str, at: datetime, pressed_s: float) -> tuple[bool, str]:
        """Do it; return whether it was done, and the result in English. Raises `RobotError`."""
        if action == "home":
            await self._driver.home(by)
            return True, "Its home is where it stood then."
        await self._stops.wait_for_stops()
        ahead, lock = self._stop_handler.clear(), None
        if (await self._driver.state()).halted:
            self._stop_handler.released(at)  # first: nothing that was posted before it finds the robot free
            lock = await self._driver.release(by, pressed_s)
        message = f"It had been {_locked_by(lock)}." if lock else "It was not locked."
        if ahead is not None:
            message += (
                f" Its last stop bore a time in the future ({ahead:%Y-%m-%d %H:%M:%S} UTC); it no longer holds back"
                " commands."
            )
        return True, message

    # ------------------------------------------------------------------ what replies say
    async def how_to_release(self, language: Language) -> str:
        return await self._how("release", language)

    async def how_to_home(self, language: Language) -> str:
        return await self._how("home", language)

    async def _how(self, action: OwnerAction, language: Language) -> str:
        owner = self._settings.owner
        who = say("agent.owner.named", language, owner=quote(owner)) if owner else say("agent.owner.any", language)
        if not isinstance(self._forum, RobotControls):
            return say(f"agent.how.{action}.shell", language, robot=self._name)
        page = say("agent.owner.page", language)
        address = await self._page_address(self._forum)
        page = f"[{page}]({address})" if address else page
        return say(f"agent.how.{action}", language, who=who, page=page, robot=self._name)

    async def _page_address(self, forum: RobotControls) -> str:
        """The address of the robot's page; empty if the forum does not answer within `ASK_S`."""
        if not self._page:
            with contextlib.suppress(ForumError, TimeoutError):
                async with asyncio.timeout(ASK_S):
                    self._page = await forum.robot_page(self._name)
        return self._page

    async def release_hints(self, report: Report) -> list[str]:
        """Paragraphs for a command that did not move because the robot is locked or has no home: who locked it, and how
        to release it or set its home."""
        reasons, language = {result.reason for result in report.results}, report.command.language
        reasons |= {report.verdict.rule.removeprefix("guard.")} if report.verdict else set()
        homeless = not self._settings.homes_itself and bool(reasons & _HOMELESS)
        if not homeless and not reasons & _LOCKED and report.status is not CommandState.STOPPED:
            return []
        state = await self._state()
        locked = state.halted if state is not None else bool(reasons & _LOCKED)
        if locked:
            # The driver's message says who, when and why if it refused a step, but not if it broke one off.
            already_said = language == "en" and bool(reasons & _LOCKED) and report.status is not CommandState.STOPPED
            return [await self.locked(None if already_said or state is None else state.lock, language)]
        if homeless and not (state is not None and state.homed):
            return [await self.how_to_home(language)]
        return []

    async def of_state(self, state: RobotState, language: Language) -> list[str]:
        """Paragraphs for the answer to "how are you"."""
        homeless = not state.homed and not self._settings.homes_itself
        paragraphs = [await self.locked(state.lock, language)] if state.halted else []
        return paragraphs + ([await self.how_to_home(language)] if homeless else [])

    async def locked(self, lock: Lock | None, language: Language) -> str:
        """Say who locked the robot, why and since when, and how to release it."""
        how = await self.how_to_release(language)
        return join_sentences(([lock_text(lock, language)] if lock else []) + [how], language)

    async def _state(self) -> RobotState | None:
        try:
            async with asyncio.timeout(ASK_S):
                return await self._driver.state()
        except (RobotError, TimeoutError):
            return None


def lock_text(lock: Lock, language: Language) -> str:
    """A lock as a sentence; its untrusted texts are shown as code."""
    why = say("agent.lock.emergency", language) if lock.why == EMERGENCY_STOP else quote(lock.why.rstrip("."))
    if not lock.by or lock.at is None:
        return say("agent.lock.nobody", language, why=why)
    return say("agent.lock.by", language, who=quote(lock.by), ago=held_for(lock, language), why=why)


def _locked_by(lock: Lock) -> str:
    held = held_for(lock)
    return f"locked{f' by {lock.by}' if lock.by else ''}{f' for {held}' if held else ''}"
