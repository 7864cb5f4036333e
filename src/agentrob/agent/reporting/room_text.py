"""Say whom a robot waits for in a room that it shares with others."""

from __future__ import annotations

import math
from typing import Any

from agentrob.language.messages.catalog import can_say, say
from agentrob.language.messages.durations import duration
from agentrob.model import Hindrance, Language


def who_does(hindrance: Hindrance, language: Language) -> str:
    """Another robot and what it does: "@humanoid walks"."""
    key = f"agent.room.{hindrance.doing}"
    return say(key if can_say(key) else "agent.room.other", language, who=f"@{hindrance.robot}")


def on_card(awaited: Hindrance | None) -> dict[str, Any]:
    """The entry on the card of a robot that waits; the robot's page shows it as a fact."""
    return {} if awaited is None else {"waits_for_the_room": who_does(awaited, "en")}


def waits_for_room(hindrance: Hindrance, language: Language) -> str:
    """A status: for whom the robot waits, and what helps if that robot's driver is silent."""
    text = say("agent.room", language, who_does=who_does(hindrance, language))
    if not hindrance.silent:
        return text
    known = math.isfinite(hindrance.silent_s)
    silent = duration(hindrance.silent_s, language) if known else say("agent.room.silent.unknown", language)
    return f"{text} {say('agent.room.silent', language, silent=silent, robot=hindrance.robot)}"
