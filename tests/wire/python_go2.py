"""A Go2 served by Unitree's Python SDK on cyclonedds 0.10: `python_go2.py DOMAIN CALLS`; calls go to the file CALLS."""

import json
import math
import random
import sys
import time

from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelPublisher
from unitree_sdk2py.idl.default import unitree_go_msg_dds__LowState_, unitree_go_msg_dds__SportModeState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_, SportModeState_
from unitree_sdk2py.rpc.server import Server

from tests.wire.peer_body import PICTURE, Body, CallLog

IDLE, WALKING = 1013, 1015


def serve(name, call_log, handlers, pictures=()):
    """Serve an RPC service; `handlers` maps an API id to a function of the decoded parameter."""
    server = Server(name)
    server._Server__apiBinarySet = set()  # the SDK converts it to a dict, which fails

    def handler(api_id, work):
        def call(parameter):
            call_log.note(name, api_id, parameter)
            work(json.loads(parameter) if parameter else {})
            return 0, ""

        return call

    def picture(_):
        call_log.note(name, 1001, "")
        return 0, list(PICTURE)

    server._SetApiVersion("1.0.0.1")
    for api_id, work in handlers.items():
        server._RegistHandler(api_id, handler(api_id, work), False)
    for api_id in pictures:
        server._RegistBinaryHandler(api_id, picture, False)
    server.Start(False)
    return server


def main():
    ChannelFactoryInitialize(int(sys.argv[1]), "lo")
    body, call_log, noise = Body(), CallLog(sys.argv[2]), random.Random(7)

    def move(asked):
        body.command(asked["x"], asked["y"], asked["z"])

    def rest(_):
        body.command(0.0, 0.0, 0.0)

    servers = [
        serve("sport", call_log, {1002: rest, 1003: rest, 1008: move, 1016: rest}),
        serve("videohub", call_log, {}, pictures=[1001]),
    ]
    state, low = unitree_go_msg_dds__SportModeState_(), unitree_go_msg_dds__LowState_()
    low.bms_state.soc = 77
    states, lows = ChannelPublisher("rt/sportmodestate", SportModeState_), ChannelPublisher("rt/lowstate", LowState_)
    states.Init()
    lows.Init()
    print("ready", flush=True)  # noqa: T201
    while servers:
        (x, y, yaw), velocity = body.look()
        state.error_code = WALKING if any(velocity) else IDLE
        state.position, state.velocity, state.yaw_speed = [x, y, 0.3], [velocity[0], velocity[1], 0.0], velocity[2]
        state.imu_state.rpy, state.imu_state.quaternion = [0.0, 0.0, yaw], [math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
        state.range_obstacle = [5.0 + noise.gauss(0, 0.01) for _ in range(4)]
        states.Write(state)
        lows.Write(low)
        time.sleep(0.02)


main()
