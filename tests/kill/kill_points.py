"""Runs inside a process that is to be killed: `agentrob`, with a thread that receives the points at which to die.

The product does not know about it. An order (a line of JSON on standard input) names a function by its import path,
whether to die before or after it, at which call, and what the arguments must contain. A line on standard output
confirms the order, and another one precedes the death. With `KILL_VERSION` the journal sees another version of the
agent.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import json
import os
import signal
import threading
import time
from typing import Any


def report(**facts: Any) -> None:
    os.write(1, (json.dumps(facts) + "\n").encode())


def arm(target: str, when: str, nth: int = 1, containing: str = "") -> None:
    """Kill this process by SIGKILL when `module:Class.name` is reached for the nth time, `before` or `after` it."""
    module, _, path = target.partition(":")
    *owners, name = path.split(".")
    owner: Any = importlib.import_module(module)
    for part in owners:
        owner = getattr(owner, part)
    original = vars(owner)[name]
    calls, counting = 0, threading.Lock()

    def reached(at: str, args: object, kwargs: object) -> None:
        nonlocal calls
        if at != when or (containing and containing not in f"{args!r} {kwargs!r}"):
            return
        with counting:
            calls += 1
            if calls == nth:
                report(killed=target, at_s=time.monotonic())
                os.kill(os.getpid(), signal.SIGKILL)

    @functools.wraps(original)
    def call(*args: Any, **kwargs: Any) -> Any:
        reached("before", args, kwargs)
        result = original(*args, **kwargs)
        reached("after", args, kwargs)
        return result

    @functools.wraps(original)
    async def awaited(*args: Any, **kwargs: Any) -> Any:
        reached("before", args, kwargs)
        result = await original(*args, **kwargs)
        reached("after", args, kwargs)
        return result

    setattr(owner, name, awaited if inspect.iscoroutinefunction(original) else call)


def read_orders() -> None:
    left = b""
    while data := os.read(0, 4096):
        *lines, left = (left + data).split(b"\n")
        for line in lines:
            try:
                arm(**json.loads(line))
                report(armed=True)
            except Exception as e:
                report(armed=False, why=repr(e))


def main() -> None:
    from agentrob.__main__ import main

    if version := os.environ.get("KILL_VERSION"):
        from agentrob.agent.store import journal

        journal.VERSION = version
    threading.Thread(target=read_orders, name="orders", daemon=True).start()
    main()
