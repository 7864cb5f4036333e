"""Alert moderators when a robot is stopped repeatedly (law 15)."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from datetime import datetime, timedelta

import structlog

from agentrob.errors import ForumError
from agentrob.forums.protocol import Forum
from agentrob.language.messages.catalog import say
from agentrob.model import Language

#: How many stops within how long cause an alert; no second one follows within the same time.
STOPS = 3
WITHIN = timedelta(minutes=5)
_log = structlog.get_logger()


class ModeratorAlert:
    """Counts the stops of one robot by the forum's clock and mentions `names` in the thread of the third."""

    def __init__(self, forum: Forum, robot: str, names: Sequence[str]) -> None:
        self._forum = forum
        self._robot = robot
        self._names = [name.lower().lstrip("@") for name in dict.fromkeys(names) if name]
        self._stops: deque[datetime] = deque(maxlen=STOPS)
        self._alerted_at: datetime | None = None

    def count_stop(self, at: datetime) -> bool:
        """Count a stop that was accepted at `at`; return whether to alert."""
        self._stops.append(at)
        # The forum's clock may have been set back since: then there may be one alert too many.
        quiet = self._alerted_at is None or abs(at - self._alerted_at) > WITHIN
        if not quiet or len(self._stops) < STOPS or abs(at - self._stops[0]) > WITHIN:
            return False
        self._alerted_at = at
        return True

    async def post(self, topic_id: str | None, language: Language) -> None:
        """Post the alert in a topic, if there is one, and log it."""
        _log.warning("stopped again and again", robot=self._robot, stops=STOPS, minutes=WITHIN.seconds // 60)
        if topic_id is None or self._alerted_at is None:
            return
        names = " ".join(f"@{name}" for name in self._names)
        text = say("agent.stop.third", language, count=STOPS, minutes=WITHIN.seconds // 60, names=names).strip()
        try:
            await self._forum.reply(topic_id, text, key=f"alarm:{self._robot}:{self._alerted_at.isoformat()}")
        except ForumError as e:
            _log.warning("moderators not alerted", robot=self._robot, error=str(e))
