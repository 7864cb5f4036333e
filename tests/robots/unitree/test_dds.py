"""DDS does not crash the process: callbacks outlive what was dropped, and none calls Python at the end."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.host_numbers import dds_number

DOMAIN = 211 + dds_number()

SPEAK = """
import gc, sys, time
from agentrob.robots.unitree import sdk
sdk.connect(int(sys.argv[1]), "lo")
from unitree_sdk2py.core.channel import ChannelPublisher, ChannelSubscriber
from unitree_sdk2py.idl.unitree_api.msg.dds_ import *

def answer():
    return Response_(ResponseHeader_(RequestIdentity_(1, 2), ResponseStatus_(0)), "", [])
"""
DROPS = """
def talk():
    asking = ChannelPublisher("rt/api/sport/request", Request_)
    asking.Init()
    hearing = ChannelSubscriber("rt/api/sport/response", Response_)
    hearing.Init(lambda message: None, 0)

talk()
gc.collect()
filled = [bytearray(64) for _ in range(100_000)]  # over what was freed
"""
LISTENS = """
import threading
heard = threading.Event()
hearing = ChannelSubscriber("rt/api/sport/response", Response_)
hearing.Init(lambda message: heard.set(), 0)
assert heard.wait(60)
print("ends")
"""
TALKS = """
asked = ChannelSubscriber("rt/api/sport/request", Request_)
asked.Init(lambda message: None, 0)
answers = ChannelPublisher("rt/api/sport/response", Response_)
answers.Init()
print("talks", flush=True)
end_s = time.monotonic() + float(sys.argv[2])
while time.monotonic() < end_s:
    answers.Write(answer())
    time.sleep(0.001)
"""


def run(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", SPEAK + script, str(DOMAIN), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)


@pytest.fixture
def message_sender() -> Iterator[None]:
    """Another process sends a message each millisecond."""
    command = [sys.executable, "-c", SPEAK + TALKS, str(DOMAIN), "240"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "talks"
        yield
    finally:
        process.terminate()
        process.communicate(timeout=100)


def test_a_client_that_was_dropped_without_being_closed_does_not_crash_the_process() -> None:
    command = f"[sys.executable, '-c', {SPEAK + TALKS!r}, sys.argv[1], '1.0']"
    peer = f"import subprocess; subprocess.run({command}, check=True, stdout=subprocess.DEVNULL)"
    ended = run(DROPS + peer + "\nprint('alive')")
    assert (ended.returncode, ended.stdout.strip()) == (0, "alive"), ended.stderr


ENDS = """
import threading
from agentrob.process import dds
begun, calls = threading.Event(), []

def called(number):
    begun.set()
    time.sleep(0.1)
    calls.append(number)

call = dds._until_the_end(called)
threading.Thread(target=call, args=(1,)).start()
assert begun.wait(60)
dds._end()
print(calls)
call(2)
print(calls)
"""


def test_the_end_waits_for_a_callback_that_has_begun_and_none_begins_after_it() -> None:
    ended = run(ENDS)
    assert (ended.returncode, ended.stdout.split("\n")) == (0, ["[1]", "[1]", ""]), ended.stderr


SLOWLY_MADE = """
from cyclonedds.core import Entity
from cyclonedds.sub import DataReader

note, get = Entity.__init__, DataReader.get_subscriber

def slowly(self, *args, **kwargs):
    if isinstance(self, DataReader):
        time.sleep(0.5)
    note(self, *args, **kwargs)

def slowly_too(self):
    time.sleep(0.5)
    return get(self)

Entity.__init__, DataReader.get_subscriber = slowly, slowly_too
DataReader.subscriber = property(slowly_too)
"""


def test_messages_that_come_while_their_reader_is_being_made_are_heard_as_any(message_sender: None) -> None:
    ended = run(SLOWLY_MADE + LISTENS)
    assert (ended.returncode, ended.stdout.strip(), ended.stderr) == (0, "ends", "")


def test_a_process_ends_well_in_the_middle_of_a_stream_of_messages(message_sender: None) -> None:
    for _ in range(4):
        ended = run(LISTENS)
        assert (ended.returncode, ended.stdout.strip()) == (0, "ends"), ended.stderr
