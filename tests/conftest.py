"""DDS domains for this test process that no other test process on this host has, and how its own processes start."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.host_numbers import take
from tests.slices import pytest_addoption, pytest_collection_modifyitems, pytest_ignore_collect

__all__ = ["pytest_addoption", "pytest_collection_modifyitems", "pytest_ignore_collect"]

#: Of the fake robots. Those above are for the tests that speak real DDS (see host_numbers.py).
FAKE_DOMAINS = range(1, 150)

# An example has no time limit of its own: how long one takes depends on what else the machine does.
settings.register_profile("agentrob", deadline=None, print_blob=True)
settings.load_profile("agentrob")

# A shell has its background jobs ignore Ctrl-C, and they would hand that on to the processes that tests end by it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Processes that tests start by the hundred would each compile all that they import.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# An HTTP client loads the authorities that it trusts, which takes 45 ms of CPU for those of the machine, and the tests
# make thousands of clients. None of them leaves this machine: this authority is nobody's, and its key was thrown away.
os.environ["SSL_CERT_FILE"] = str(Path(__file__).with_name("authority.pem"))

# In the environment, since a test's own processes drive the same robot.
_domain = take("domain", FAKE_DOMAINS)
os.environ["AGENTROB_TEST_DOMAIN"] = str(_domain)
# `agentrob stop --all` of a test stops the simulated robots of this test process, not those of tests beside it.
os.environ["AGENTROB_LOCK_NAMESPACE"] = f"test-{_domain}"


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Imports make next to no garbage, and a fifth of their time would be spent on looking for it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.fixture(scope="module", autouse=True)
def no_search_of_old_heaps() -> None:
    """What the test process has loaded and collected so far, a million objects after some thousand tests, is not looked
    through for garbage within a test: that took up to 1.6 s, in which an agent in this process fell silent and lost its
    robot's lease (which is worthless after one)."""
    gc.collect()
    gc.freeze()
