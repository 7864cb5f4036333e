"""The process of one preview: `python -m agentrob.rehearsal.child` reads a request and writes the preview, as JSON.

It has the lowest priority, opens no network, and knows neither the robot's driver nor the forum.
"""

from __future__ import annotations

import math
import os
import resource
import sys

from agentrob.errors import AgentRobError
from agentrob.rehearsal.preview import read_request, write_preview

#: Lower priority than every other process of AgentRob, but not so low that a busy machine forgets who waits for it.
NICE = 10


def main() -> int:
    """Write the preview; 1 with one line on standard error if there is none."""
    os.nice(NICE)
    request = read_request(sys.stdin.buffer.read())
    most_s = math.ceil(request.settings.rehearsal.limit_s)
    resource.setrlimit(resource.RLIMIT_CPU, (most_s, most_s + 1))  # it also ends when nobody waits for it any more
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
