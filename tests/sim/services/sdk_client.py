"""Drives a Go2 with the vendor's SDK and prints its observations as one JSON object: `sdk_client.py DOMAIN`."""

import json
import os
import sys
import threading
import time

from tests.sim.services.sdk_seen import TopicCollector, made, pose  # patches DDS: before IDL types

# isort: split
from unitree_sdk2py.comm.motion_switcher.motion_switcher_client import MotionSwitcherClient
from unitree_sdk2py.core.channel import ChannelFactoryInitialize
from unitree_sdk2py.go2.sport.sport_client import SportClient
from unitree_sdk2py.go2.video.video_client import VideoClient
from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_
from unitree_sdk2py.utils.crc import CRC


def timed(call, *arguments):
    began = time.monotonic()
    return call(*arguments), time.monotonic() - began


def main():
    ChannelFactoryInitialize(int(sys.argv[1]), "lo")
    sport, other = made(SportClient(), 15.0), made(SportClient(), 5.0)
    video, switcher = made(VideoClient(), 5.0), made(MotionSwitcherClient(), 5.0)
    seen = TopicCollector("rt/sportmodestate", LowState_)
    seen.until(lambda: seen.states and seen.lows)
    out = {"balance": sport.BalanceStand(), "left_flip": sport.LeftFlip(), "mode": switcher.CheckMode()}
    out["select"] = switcher.SelectMode("ai")[0]
    low = seen.lows[-1][1]
    out["low"] = {"soc": low.bms_state.soc, "volts": low.power_v, "joints": [m.q for m in low.motor_state[:12]]}
    out["low"]["whole"] = CRC().Crc(low) == low.crc
    (code, image), seconds = timed(video.GetImageSample)
    out["image"] = {"code": code, "seconds": seconds, "hex": bytes(image).hex()}

    start = seen.states[-1][1]
    out["start"] = {"pose": pose(start), "codes": [start.error_code, start.mode], "ranges": list(start.range_obstacle)}
    moved = time.monotonic()
    sport.Move(0.5, 0.0, 0.0)  # once: held for a second, then the robot stops by itself
    seen.until(lambda: seen.states[-1][1].error_code == 1015)
    rest = seen.until(lambda: seen.states[-1][1].error_code == 1013)
    out["held"] = {"pose": pose(rest), "seconds": time.monotonic() - moved}

    answers = []
    waving = threading.Thread(target=lambda: answers.append(timed(sport.Hello)))
    waving.start()
    seen.until(lambda: seen.states[-1][1].error_code == 1006)
    out["second_gesture"] = other.Heart()
    seen.until(lambda: seen.states[-1][1].progress > 0.4)
    out["stop"] = timed(other.StopMove)
    waving.join()
    out["hello"] = answers[0]
    seen.until(lambda: seen.states[-1][1].error_code == 1013)
    times = [t for t, _ in seen.states]
    out["rate_hz"] = (len(times) - 1) / (times[-1] - times[0])
    print(json.dumps(out), flush=True)  # noqa: T201
    os._exit(0)  # the SDK's threads do not end by themselves


main()
