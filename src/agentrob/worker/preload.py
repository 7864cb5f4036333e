"""Import what agents need before a worker takes any robot.

These imports take seconds of a processor. Until they are done other workers serve the robots, so they run at a lower
priority: on a busy machine they must not delay the stops of others.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future

#: Added to the nice value of the thread that imports: beside a busy process it still gets a quarter of a core.
LOWER = 5


def preload() -> None:
    """Import the agent's modules and the libraries that it would else import later. Blocks until that is done."""
    _at_low_priority(_import_agent)


def _import_agent() -> None:
    from agentrob.agent import agent  # noqa: F401
    from agentrob.agent.media import plot
    from agentrob.agent.understanding.extract import warm_up_rules
    from agentrob.screening.screen import prepare

    plot.warm_up()
    prepare()
    warm_up_rules()


def _at_low_priority(work: Callable[[], None]) -> None:
    """Run `work` on a thread of a lower priority, which only Linux has."""
    if sys.platform != "linux":
        return work()
    done: Future[None] = Future()

    def run() -> None:
        thread = threading.get_native_id()
        os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + LOWER)
        try:
            work()
            done.set_result(None)
        except BaseException as e:
            done.set_exception(e)

    threading.Thread(target=run, name="preload", daemon=True).start()
    return done.result()
