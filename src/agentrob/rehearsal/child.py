"""The process of one preview: `python -m agentrob.rehearsal.child` reads a request and writes the preview, as JSON.

It has the lowest priority, opens no network, and knows neither the robot's driver nor the forum.
"""

from __future__ import annotations

import os
import resource
import sys

from agentrob.errors import AgentRobError
from agentrob.rehearsal.preview import read_request, write_preview

#: Lower priority than every other process of AgentRob, but not so low that a busy machine forgets who waits for it.
NICE = 10
#: Seconds of processor time after which the kernel ends it: also when nobody waits for it any more.
PROCESSOR_S = 60


def main() -> int:
    """Write the preview; 1 with one line on standard error if there is none."""
    os.nice(NICE)
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S + 1))
    request = read_request(sys.stdin.buffer.read())
    try:
        from agentrob.rehearsal.runs import simulate
        from agentrob.rehearsal.side_by_side import usable_processes

        sys.stdout.buffer.write(write_preview(simulate(request, processes=usable_processes())))
    except (AgentRobError, ImportError) as e:
        sys.stderr.write(f"{e}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
