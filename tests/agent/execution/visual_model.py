"""A scripted model on loopback that steers a robot by pictures over HTTP.

Other questions to the model (reading, screening) are answered by `scripted_model`.
"""

from __future__ import annotations

import base64
import io
import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from PIL import Image

from tests.minds.faulty_server import called, faulty_server, said
from tests.minds.scripted_model import ScriptedModel

Step = tuple[str, Any] | str | Callable[[Any], None]
DONE = ("finish", {"outcome": "done", "saw": ["a blue box"], "did": "I walked to it."})


class ScriptedLoopModel(ScriptedModel):
    """`loop_answers` is what it says in the loop, turn by turn, the last for ever; or a function of the conversation.

    `shown` are the pictures that came with its last question, `loops` the bodies of its questions.
    """

    def __init__(self, server: Any) -> None:
        super().__init__(server)
        self.loop_answers: list[Step] | Callable[[list[Any]], Step] = [DONE]
        self.loops: list[dict[str, Any]] = []
        self.hanging, self.go = threading.Event(), threading.Event()
        server.answer = self._drive

    def hang(self, handler: Any) -> None:
        self.hanging.set()
        handler.hang()

    def after(self, step: tuple[str, Any]) -> Callable[[Any], None]:
        """Wait until `go` is set, then return that call."""

        def answer(handler: Any) -> None:
            self.hanging.set()
            self.go.wait(60)
            handler.send(200, json.dumps(called(*step)).encode())

        return answer

    def _drive(self, handler: Any, body: dict[str, Any]) -> None:
        if not str(body["messages"][0]["content"]).startswith("# Driving"):
            return self._answer(handler, body)
        self.loops.append(body)
        if callable(self.loop_answers):
            step = self.loop_answers(pictures(body))
        else:
            step = self.loop_answers[min(len(self.loops), len(self.loop_answers)) - 1]
        if callable(step):
            return step(handler)
        reply = said(step) if isinstance(step, str) else called(*step)
        handler.send(200, json.dumps(reply).encode())
        return None


@contextmanager
def running_loop_model() -> Iterator[ScriptedLoopModel]:
    with faulty_server() as server:
        yield ScriptedLoopModel(server)


def pictures(body: dict[str, Any]) -> list[Image.Image]:
    """Return the pictures in a question, oldest first."""
    found = []
    for message in body["messages"]:
        parts = message["content"] if isinstance(message["content"], list) else []
        for part in parts:
            if part.get("type") == "image_url":
                data = base64.b64decode(part["image_url"]["url"].partition(",")[2])
                found.append(Image.open(io.BytesIO(data)))
    return found


def conversation_text(body: dict[str, Any]) -> str:
    """Return all words of a question, without the pictures."""
    words = []
    for message in body["messages"]:
        content = message["content"]
        words.append(content if isinstance(content, str) else " ".join(p.get("text", "") for p in content or []))
    return "\n".join(words)


def find_red(picture: Image.Image) -> tuple[float, float] | None:
    """Return the position of the red ball, from -1 (left) to 1 (right), and its share of the picture's width; None if
    not visible."""
    import numpy as np

    pixels = np.asarray(picture.convert("RGB"), dtype=np.int16)
    red = (pixels[..., 0] > 110) & (pixels[..., 1] < 0.45 * pixels[..., 0]) & (pixels[..., 2] < 0.45 * pixels[..., 0])
    red[: red.shape[0] // 3] = False  # the ball lies on the floor; red books on shelves do not
    columns = red.sum(axis=0)
    wide = columns >= 3
    if wide.sum() < 4:
        return None
    at = np.nonzero(wide)[0]
    middle = float(np.average(at, weights=columns[at]))
    return 2 * middle / red.shape[1] - 1, float(wide.sum()) / red.shape[1]
