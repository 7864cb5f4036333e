"""The door to the Unitree SDK and to DDS."""

from __future__ import annotations

import os
import threading

from cyclonedds.domain import DomainParticipant
from cyclonedds.topic import Topic

import agentrob.dds

DOMAIN = 201 + int(os.environ["AGENTROB_TEST_NUMBER"])


def test_topics_are_created_one_at_a_time_for_two_at_once_may_hang_the_process() -> None:
    from unitree_sdk2py.idl.unitree_api.msg.dds_ import Request_

    participant = DomainParticipant(DOMAIN)
    made = threading.Event()
    thread = threading.Thread(target=lambda: (Topic(participant, "rt/one", Request_), made.set()), daemon=True)
    with agentrob.dds._one_topic:
        thread.start()
        assert not made.wait(0.3)
    assert made.wait(10.0)
    thread.join(10.0)
