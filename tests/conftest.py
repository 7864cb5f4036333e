"""Settings of the whole test run: DDS domains that no other test process on this host uses, time limits, and the
garbage collector."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.databases import database, postgres
from tests.host_numbers import take
from tests.pauses import pytest_itemcollected, pytest_runtest_call, pytest_runtest_setup
from tests.slices import pytest_addoption, pytest_collection_modifyitems, pytest_ignore_collect

__all__ = [
    "database",
    "postgres",
    "pytest_addoption",
    "pytest_collection_modifyitems",
    "pytest_ignore_collect",
    "pytest_itemcollected",
    "pytest_runtest_call",
    "pytest_runtest_setup",
]

#: For fake robots. Higher domains are for tests that use real DDS (see host_numbers.py).
FAKE_DOMAINS = range(1, 150)

# No deadline for single examples: their duration depends on the load of the machine.
settings.register_profile("agentrob", deadline=None, print_blob=True)
settings.load_profile("agentrob")

# A shell starts background jobs with SIGINT ignored, and child processes that tests end by SIGINT would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Write bytecode, because otherwise each of the hundreds of processes that tests start would compile all its imports.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Loading the machine's certificate authorities takes 45 ms of CPU for each HTTP client, and the tests make thousands
# of clients. They connect to this machine only, so they trust one authority whose private key was deleted.
os.environ["SSL_CERT_FILE"] = str(Path(__file__).with_name("authority.pem"))

# In the environment, so that the processes of a test control the same robot.
_domain = take("domain", FAKE_DOMAINS)
os.environ["AGENTROB_TEST_DOMAIN"] = str(_domain)
# With its own namespace, `agentrob stop --all` in a test does not stop the robots of tests that run in parallel, and a
# driver that outlived an earlier run holds no robot of this one.
os.environ["AGENTROB_LOCK_NAMESPACE"] = f"test-{_domain}-{os.getpid()}"


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Disable garbage collection while tests are imported: it would take a fifth of that time and find almost
    nothing."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.fixture(scope="module", autouse=True)
def no_search_of_old_heaps() -> None:
    """Exclude the objects that are loaded so far from garbage collection during the tests of a module.

    After some thousand tests a collection took up to 1.6 s, during which an agent in this process lost its robot's
    lease (valid for one second).
    """
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="module")
def model_libraries() -> None:
    """Import the model libraries before the tests of a module, so that no test's time limit counts the import.

    It takes 2 s of CPU, and each worker collects all modules but runs only some.
    """
    importlib.import_module("agentrob.minds.llm.provider")


@pytest.fixture
def short_folder() -> Iterator[Path]:
    """A folder with a short path: the path of a Unix socket has at most 107 characters."""
    with tempfile.TemporaryDirectory(prefix="agentrob-") as folder:
        yield Path(folder)
