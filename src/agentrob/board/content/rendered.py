"""One text with everything derived from it: HTML, mentions, search tokens, and whether it stops a robot."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict, dataclass
from typing import Any

from agentrob.board.content.markdown import Parsed, as_plain_text
from agentrob.board.db.fulltext import indexed
from agentrob.language.stop.at_rest import is_only_stop, stop_intent
from agentrob.language.stop.while_moving import stop_while_moving
from agentrob.language.visible_text import mentions, visible_text

#: And when its HTML has more characters than this, ten times the longest post: a short text can use a long link again
#: and again or say one name ten thousand times, and a page shows fifty posts. Nothing but links makes seven times.
MAX_HTML = 10 * 65_536
#: A longer text that says stop somewhere is written in turn, like any other.
STOP_CHARS = 200


@dataclass(frozen=True, slots=True)
class Rendered:
    """A text and what is derived from it. `mentions` are accounts that it visibly names, `words` and `chars` go to the
    full-text index; `stop`: it stops a moving robot, `only_stop`: it says nothing else."""

    raw: str
    html: str
    mentions: tuple[str, ...]
    words: str
    chars: str
    stop: bool = False
    only_stop: bool = False

    def fields(self) -> dict[str, Any]:
        return asdict(self)


class Text:
    """A body that is rendered in two steps: first its names; then, knowing which of them are accounts, the rest."""

    def __init__(self, raw: str) -> None:
        self._raw, self._parsed = raw, Parsed(raw)
        self._visible = visible_text(raw)
        self._named = mentions(self._visible)
        self.names = tuple(dict.fromkeys((*self._named, *self._parsed.names())))

    def rendered(self, accounts: Collection[str]) -> Rendered:
        html = self._parsed.html(accounts.__contains__)
        named = tuple(name for name in self._named if name in accounts)
        if len(html) > MAX_HTML:
            html, named = as_plain_text(self._raw), ()
        stop = stop_intent(self._visible) is not None
        only_stop = stop and is_only_stop(self._raw)
        stop = stop or (len(self._visible) <= STOP_CHARS and stop_while_moving(self._visible) is not None)
        return Rendered(self._raw, html, named, *indexed(self._raw), stop, only_stop)
