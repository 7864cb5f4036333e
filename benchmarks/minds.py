"""Measure our own share of the time of minds: per post, per turn with a picture, and at the start of the CLI.

    python benchmarks/minds.py [--turns 200]

The model is a server on loopback, in its own process, that answers immediately; its time has a separate row (it is
small, and included in the other rows). HTTP, libraries, budgets on disk, prompts, checks and the encoding of pictures
count as ours.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from instruments.loopback_model import HEAD, loopback_model, row, served_s
from pydantic import BaseModel

from agentrob.config.minds import MindConfig
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.chat import Image, Tool, UserMessage
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.minds.protocol import Addressee
from agentrob.model import Capabilities, Intent, Op

CALLED = """
STEP = {"action": "move", "direction": "forward", "amount": 2, "unit": "m", "words": "meander forward 2 m"}
def called(body):
    tool = body["tools"][0]["function"]["name"]
    return tool, {"intent": "command", "steps": [STEP]} if tool == "answer" else {"distance_m": 1}
"""


class Walk(BaseModel):
    distance_m: float


async def _measure(port: int, turns: int, folder: Path) -> list[str]:
    config = MindConfig(provider="compatible", model="m", base_url=f"http://127.0.0.1:{port}/v1")
    config = config.model_copy(update={"limits": config.limits.model_copy(update={"day_tokens": 0})})
    model = ConfiguredModel("bench", config, folder / "minds.sqlite")
    mind = ModelMind(FallbackModel([model]))
    addressee = Addressee(("quadruped",), (), Capabilities("go2", frozenset(Op)))
    picture = Image(os.urandom(100_000))

    async def reading() -> None:
        found = await mind.understand("@quadruped be a dear and meander forward 2 m", addressee)
        assert found.intent is Intent.COMMAND

    async def turn() -> None:
        answer = await model.turn("You drive.", [UserMessage("Walk.", (picture,))], [Tool("act_move", "Walks.", Walk)])
        assert answer.value.calls[0].arguments == Walk(distance_m=1)

    rows = []
    for name, action in (("a post read", reading), ("a turn with a picture of 100 kB", turn)):
        await action()
        rows.append(row(name, await _times(action, turns)))
    rows.append(row("of this the server itself", served_s(port)))
    await model.close()
    return rows


async def _times(action: Callable[[], Awaitable[None]], turns: int) -> list[float]:
    found = []
    for _ in range(turns):
        began = time.perf_counter()
        await action()
        found.append(time.perf_counter() - began)
    return found


def _help_times(runs: int) -> list[float]:
    program = str(Path(sys.executable).with_name("agentrob"))
    found = []
    for _ in range(runs):
        began = time.perf_counter()
        subprocess.run([program, "--help"], check=True, stdout=subprocess.DEVNULL)
        found.append(time.perf_counter() - began)
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--turns", type=int, default=200)
    turns = parser.parse_args().turns
    with loopback_model(CALLED) as port, tempfile.TemporaryDirectory() as folder:
        rows = asyncio.run(_measure(port, turns, Path(folder)))
    print(HEAD)
    print("\n".join([*rows, row("agentrob --help", _help_times(20))]))


if __name__ == "__main__":
    main()
