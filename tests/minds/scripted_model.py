"""A model server on loopback with scripted responses for each kind of request; it records the requests."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from agentrob.config.minds import MindConfig
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.model import ConfiguredModel
from tests.minds.faulty_server import FaultyServer, called, faulty_server, said

#: The beginning of the system prompt of each kind of request.
_KINDS = {"Reading posts": "read", "Looking at": "screen", "Wording a": "summary"}
FINE = {"decision": "fine"}
Fault = Callable[[Any], None]


class ScriptedModel:
    """`extraction`, `review` and `summary` are the responses; a callable gets the HTTP handler and responds itself."""

    def __init__(self, server: FaultyServer) -> None:
        self.server = server
        self.extraction: dict[str, Any] | Fault = {"intent": "nothing"}
        self.review: dict[str, Any] | Fault = FINE
        self.summary: str | Fault = "Fine."
        self.asked: list[tuple[str, str]] = []
        server.answer = self._answer

    def prompts(self, kind: str) -> list[str]:
        """Return the user prompts of one kind of request: read, screen or summary."""
        return [prompt for asked, prompt in self.asked if asked == kind]

    def mind(self, folder: Path, name: str = "clever", **settings: Any) -> ModelMind:
        """Return a mind that uses this server, with a short timeout."""
        return ModelMind(FallbackModel([self.model(folder, name, **settings)]))

    def model(self, folder: Path, name: str = "clever", **settings: Any) -> ConfiguredModel:
        given = {
            "provider": "compatible",
            "model": "some-model",
            "base_url": f"{self.server.url}/v1",
            "timeout_s": 5.0,
            "total_s": 10.0,
            "retries": 1,
            **settings,
        }
        return ConfiguredModel(name, MindConfig.model_validate(given), folder / "minds.sqlite", chance=lambda: 0.0)

    def _answer(self, handler: Any, body: dict[str, Any]) -> None:
        system, user = (message["content"] for message in body["messages"][:2])
        kind = next(kind for begin, kind in _KINDS.items() if system.startswith(f"# {begin}"))
        self.asked.append((kind, user))
        answer = {"read": self.extraction, "screen": self.review, "summary": self.summary}[kind]
        if callable(answer):
            answer(handler)
        else:
            reply = said(answer) if isinstance(answer, str) else called("answer", answer)
            handler.send(200, json.dumps(reply).encode())


@contextmanager
def running_scripted_model() -> Iterator[ScriptedModel]:
    with faulty_server() as server:
        yield ScriptedModel(server)


def move(words: str, amount: float, unit: str = "m", direction: str = "forward", **more: Any) -> dict[str, Any]:
    """Return a model's extraction of a walk."""
    step = {"action": "move", "direction": direction, "amount": amount, "unit": unit, "words": words, **more}
    return {"intent": "command", "steps": [step]}
