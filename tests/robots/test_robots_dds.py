"""DDS does not crash the process: callbacks outlive what was dropped, and nothing calls Python at its end."""

from __future__ import annotations

import os
import subprocess
import sys

DOMAIN = 211 + int(os.environ["AGENTROB_TEST_NUMBER"])

SPEAK = """
import gc, sys, time
from agentrob.robots import unitree
unitree.connect(int(sys.argv[1]), "lo")
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
assert heard.wait(20)
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
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_a_client_that_was_dropped_without_being_closed_does_not_crash_the_process() -> None:
    command = f"[sys.executable, '-c', {SPEAK + TALKS!r}, sys.argv[1], '1.0']"
    peer = f"import subprocess; subprocess.run({command}, check=True, stdout=subprocess.DEVNULL)"
    ended = run(DROPS + peer + "\nprint('alive')")
    assert (ended.returncode, ended.stdout.strip()) == (0, "alive"), ended.stderr


ENDS = """
import threading
from agentrob import dds
begun, calls = threading.Event(), []

def called(number):
    begun.set()
    time.sleep(0.1)
    calls.append(number)

call = dds._until_the_end(called)
threading.Thread(target=call, args=(1,)).start()
assert begun.wait(10)
dds._end()
print(calls)
call(2)
print(calls)
"""


def test_the_end_waits_for_a_callback_that_has_begun_and_none_begins_after_it() -> None:
    ended = run(ENDS)
    assert (ended.returncode, ended.stdout.split("\n")) == (0, ["[1]", "[1]", ""]), ended.stderr


def test_a_process_ends_well_in_the_middle_of_a_stream_of_messages() -> None:
    talker = subprocess.Popen(
        [sys.executable, "-c", SPEAK + TALKS, str(DOMAIN), "60"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert talker.stdout is not None
        assert talker.stdout.readline().strip() == "talks"
        for _ in range(4):
            ended = run(LISTENS)
            assert (ended.returncode, ended.stdout.strip()) == (0, "ends"), ended.stderr
    finally:
        talker.terminate()
        talker.communicate(timeout=10)
