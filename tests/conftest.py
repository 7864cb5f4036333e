"""A DDS domain for the fake robots of this test process that no other test process on this host has."""

from __future__ import annotations

import os

from agentrob.errors import RobotBusy
from agentrob.hostlock import HostLock

#: Those above are for the tests that speak real DDS.
FAKE_DOMAINS = range(1, 150)


def _take_domain() -> tuple[int, HostLock]:
    for domain in FAKE_DOMAINS:
        try:
            return domain, HostLock(f"test-domain/{domain}", "the domain")
        except RobotBusy:
            continue
    raise RuntimeError(f"every domain of {FAKE_DOMAINS} is taken by other test processes")


# In the environment, since a test's own processes drive the same robot.
domain, _held_to_the_end = _take_domain()
os.environ["AGENTROB_TEST_DOMAIN"] = str(domain)
