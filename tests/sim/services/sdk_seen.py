"""Shared code of the two programs that drive a robot with the vendor's SDK."""

import math
import threading
import time

from agentrob.process import dds

# isort: split
from unitree_sdk2py.core import channel
from unitree_sdk2py.core.channel import ChannelSubscriber
from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_

dds.use_in(channel)


class TopicCollector:
    """Collects the messages of the state topics as they arrive."""

    def __init__(self, state_topic, low_type):
        self.states, self.lows = [], []
        self.changed = threading.Condition()
        self.subscribers = [
            self.subscribe(state_topic, SportModeState_, self.states),
            self.subscribe("rt/lowstate", low_type, self.lows),
        ]

    def subscribe(self, topic, kind, there):
        subscriber = ChannelSubscriber(topic, kind)
        subscriber.Init(lambda sample: self.add(there, sample), 1)
        return subscriber

    def add(self, there, sample):
        with self.changed:
            there.append((time.monotonic(), sample))
            self.changed.notify_all()

    def until(self, true, limit_s=20.0):
        with self.changed:
            assert self.changed.wait_for(true, limit_s), "state did not become what was awaited"
        return self.states[-1][1]


def made(client, limit_s):
    client.SetTimeout(limit_s)
    client.Init()
    return client


def pose(state):
    return [state.position[0], state.position[1], math.degrees(state.imu_state.rpy[2])]
