"""The `[forum]` table: the forum that the agents read and write.

[forum]
kind = "board"
url = "http://127.0.0.1:8088"
"""

from __future__ import annotations

from typing import Any

from pydantic import Field

from agentrob.config.section import DEFAULT_LISTEN, Section


class ForumConfig(Section):
    """The forum's adapter (`kind`: `board`, `nodebb`, `discourse`, `mcp`, or an installed one) and address (`url`).
    The environment variable that `token_env` names holds the token.

    `options` belong to the adapter (groups and their rights, polling intervals), which validates them.
    """

    kind: str = "board"
    url: str = "http://" + DEFAULT_LISTEN
    token_env: str = "AGENTROB_TOKEN"
    options: dict[str, Any] = Field(default_factory=dict)
