"""Drives a G1 with the vendor's SDK and prints its observations as one JSON object: `sdk_g1_client.py DOMAIN`."""

import json
import os
import sys
import threading
import time

from tests.sim.services.sdk_seen import TopicCollector, made, pose  # patches DDS: before IDL types

# isort: split
from unitree_sdk2py.core.channel import ChannelFactoryInitialize
from unitree_sdk2py.g1.arm.g1_arm_action_client import G1ArmActionClient
from unitree_sdk2py.g1.loco.g1_loco_client import LocoClient
from unitree_sdk2py.go2.video.video_client import VideoClient
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowState_
from unitree_sdk2py.utils.crc import CRC


def number(sport, api_id):
    code, data = sport._Call(api_id, "{}")
    return [code, json.loads(data)["data"]]


def main():
    ChannelFactoryInitialize(int(sys.argv[1]), "lo")
    sport, arm, video = made(LocoClient(), 5.0), made(G1ArmActionClient(), 20.0), made(VideoClient(), 5.0)
    other = made(G1ArmActionClient(), 10.0)
    seen = TopicCollector("rt/odommodestate", LowState_)
    seen.until(lambda: seen.states and seen.lows)
    out = {"fsm": number(sport, 7001), "height": number(sport, 7005), "old_start": sport.SetFsmId(200)}
    low = seen.lows[-1][1]
    out["low"] = {"motors": len(low.motor_state), "joints": [m.q for m in low.motor_state[:29]]}
    out["low"]["quaternion"] = list(low.imu_state.quaternion)
    out["low"]["whole"] = CRC().Crc(low) == low.crc
    code, image = video.GetImageSample()
    out["image"] = {"code": code, "hex": bytes(image).hex()}
    out["actions"] = arm.GetActionList()

    start = seen.states[-1][1]
    out["start"] = pose(start)
    out["velocity"] = sport.SetVelocity(0.3, 0.0, 0.0, 2.0)  # once: held for two seconds, then it stands by itself
    seen.until(lambda: seen.states[-1][1].position[0] - start.position[0] > 0.3)
    seen.until(lambda: number(sport, 7002) == [0, 0])
    out["held"] = pose(seen.states[-1][1])

    answers = []
    clapping = threading.Thread(target=lambda: answers.append(arm.ExecuteAction(17)))
    began = time.monotonic()
    clapping.start()
    while other.ExecuteAction(26) != 7400:  # the first may not be there yet
        assert time.monotonic() - began < 5
    out["bad_id"], out["release"] = other.ExecuteAction(4711), other.ExecuteAction(99)
    clapping.join()
    out["clap"] = answers[0]
    times = [t for t, _ in seen.states]
    out["rate_hz"] = (len(times) - 1) / (times[-1] - times[0])
    print(json.dumps(out), flush=True)  # noqa: T201
    os._exit(0)  # the SDK's threads do not end by themselves


main()
