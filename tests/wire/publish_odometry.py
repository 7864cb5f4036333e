"""Publish a G1's odometry on domain 0, from cyclonedds 11 with or without our patch: `publish_odometry.py
plain|patched`."""

import sys
import time

if sys.argv[1] == "patched":
    import agentrob.process.dds  # noqa: F401  before any type of the SDK

from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelPublisher
from unitree_sdk2py.idl.default import unitree_go_msg_dds__SportModeState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_

ChannelFactoryInitialize(0, "lo")
publisher = ChannelPublisher("rt/odommodestate", SportModeState_)
publisher.Init()
state = unitree_go_msg_dds__SportModeState_()
state.position, state.imu_state.quaternion = [1.0, 2.0, 3.0], [1.0, 0.0, 0.0, 0.0]
print("ready", flush=True)  # noqa: T201
while True:
    publisher.Write(state)
    time.sleep(0.02)
