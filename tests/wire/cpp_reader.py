"""Read a robot's state with Unitree's own C++ library on domain 0: `cpp_reader.py go2|g1 SECONDS`; prints JSON.

If a checksum is wrong, the library writes an error to standard error and returns zeros.
"""

import json
import os
import sys
import time

import unitree_interface

robot = getattr(unitree_interface.UnitreeInterface, f"create_{sys.argv[1]}")("lo")
end_s = time.monotonic() + float(sys.argv[2])
while time.monotonic() < end_s:
    low, odometry = robot.read_low_state(), robot.read_odom_state()
    if any(low.imu.quat) and any(odometry.quat):
        break
    time.sleep(0.05)
facts = {
    "position": odometry.position,
    "quaternion": odometry.quat,
    "joints": low.motor.q,
    "low_quaternion": low.imu.quat,
}
print("\n" + json.dumps(facts), flush=True)  # noqa: T201
os._exit(0)  # the library's destructors sometimes fail an assertion (`prevent_callbacks`)
