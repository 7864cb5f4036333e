"""Drive a robot with Unitree's Python SDK on cyclonedds 0.10: `python_client.py go2|g1 DOMAIN`; prints JSON."""

import json
import math
import os
import sys
import time

from unitree_sdk2py.core.channel import ChannelFactoryInitialize, ChannelSubscriber
from unitree_sdk2py.g1.arm.g1_arm_action_client import G1ArmActionClient
from unitree_sdk2py.g1.loco.g1_loco_client import LocoClient
from unitree_sdk2py.go2.sport.sport_client import SportClient
from unitree_sdk2py.go2.video.video_client import VideoClient
from unitree_sdk2py.idl.unitree_go.msg import dds_ as go
from unitree_sdk2py.idl.unitree_hg.msg import dds_ as hg

LIMIT_S = 60.0
UNKNOWN = 4711  # no robot has this API


def made(client):
    client.SetTimeout(15.0)
    client.Init()
    client._RegistApi(UNKNOWN, 0)
    return client


def subscribed(topic, kind):
    subscriber = ChannelSubscriber(topic, kind)
    subscriber.Init()
    return subscriber


def newest(subscriber):
    message = subscriber.Read(LIMIT_S)
    assert message is not None, "no state came"
    return message


def walk(states, command):
    """Send a command at 10 Hz until the robot has gone 30 cm; return the distance."""
    x, y = newest(states).position[:2]
    end_s = time.monotonic() + LIMIT_S
    while time.monotonic() < end_s:
        command()
        now = newest(states).position
        if math.hypot(now[0] - x, now[1] - y) > 0.3:
            break
        time.sleep(0.1)
    return math.hypot(now[0] - x, now[1] - y)


def go2():
    sport, video = made(SportClient()), made(VideoClient())
    states, lows = subscribed("rt/sportmodestate", go.SportModeState_), subscribed("rt/lowstate", go.LowState_)
    out = {"ready": sport.BalanceStand(), "unknown": sport._Call(UNKNOWN, "{}")[0]}
    out["walked_m"] = walk(states, lambda: sport.Move(0.4, 0.0, 0.0))
    out["stop"], out["gesture"] = sport.StopMove(), sport.Hello()
    code, image = video.GetImageSample()
    low = newest(lows)
    return {
        **out,
        "picture": [code, bytes(image or ())[:2].hex()],
        "soc": low.bms_state.soc,
        "motors": len(low.motor_state),
    }


def g1():
    sport, arm, video = made(LocoClient()), made(G1ArmActionClient()), made(VideoClient())
    states, lows = subscribed("rt/odommodestate", go.SportModeState_), subscribed("rt/lowstate", hg.LowState_)
    out = {"ready": sport.SetFsmId(500), "unknown": sport._Call(UNKNOWN, "{}")[0]}
    out["walked_m"] = walk(states, lambda: sport.SetVelocity(0.3, 0.0, 0.0, 0.5))
    out["stop"], out["gesture"] = sport.SetVelocity(0.0, 0.0, 0.0), arm.ExecuteAction(26)
    code, image = video.GetImageSample()
    return {**out, "picture": [code, bytes(image or ())[:2].hex()], "motors": len(newest(lows).motor_state)}


ChannelFactoryInitialize(int(sys.argv[2]), "lo")
print(json.dumps({"go2": go2, "g1": g1}[sys.argv[1]]()), flush=True)  # noqa: T201
os._exit(0)  # the SDK's threads do not end on their own
