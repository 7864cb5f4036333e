"""A G1 served by Unitree's own C++ library on domain 0: `cpp_g1.py SHIM CALLS`; each call goes to file CALLS.

The RPC server and the state publishers are the library's; only the content of their messages is made here.
"""

import ctypes
import json
import math
import os
import sys
import time

from tests.wire.peer_body import PICTURE, Body, CallLog

sys.setdlopenflags(os.RTLD_GLOBAL | os.RTLD_NOW)  # the shim finds the server in it
import unitree_interface  # noqa: E402

WALK = 500
Handler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_char_p, ctypes.POINTER(ctypes.c_char))


class Services:
    def __init__(self, shim, call_log):
        self._library, self._call_log, self._kept = ctypes.CDLL(shim), call_log, []
        self._library.server_new.restype = ctypes.c_void_p

    def serve(self, name, handlers, pictures=()):
        """Serve an RPC service; `handlers` maps an API id to a function from the decoded parameter to the response."""
        server = ctypes.c_void_p(self._library.server_new(name.encode(), b"1.0.0.1"))
        for api_id, work in handlers.items():
            handler = Handler(self._handler(name, work))
            self._kept.append(handler)
            self._library.server_handle(server, api_id, handler)
        for api_id in pictures:
            self._library.server_picture(server, api_id, PICTURE, len(PICTURE))
        self._library.server_start(server)

    def _handler(self, name, work):
        def call(api_id, parameter, answer):
            text = parameter.decode()
            self._call_log.note(name, api_id, text)
            said = work(json.loads(text) if text else {})
            if said is not None:
                data = json.dumps(said).encode() + b"\0"
                ctypes.memmove(answer, data, len(data))
            return 0

        return call


def main():
    robot = unitree_interface.UnitreeInterface.create_g1("lo")
    body, services = Body(), Services(sys.argv[1], CallLog(sys.argv[2]))

    def move(asked):
        body.command(*asked["velocity"], hold_s=asked["duration"])

    nothing = lambda _: None  # noqa: E731
    services.serve("sport", {7001: lambda _: {"data": WALK}, 7101: nothing, 7105: move})
    services.serve("arm", {7106: nothing})
    services.serve("videohub", {}, pictures=[1001])
    odometry = unitree_interface.OdomState()
    low = unitree_interface.LowState(29)
    print("ready", flush=True)  # noqa: T201
    while True:
        (x, y, yaw), (forward, left, turning) = body.look()
        odometry.position, odometry.velocity, odometry.yaw_speed = [x, y, 0.76], [forward, left, 0.0], turning
        odometry.quat = [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]
        robot.publish_odom_state(odometry)
        robot.publish_low_state(low)
        time.sleep(0.02)


main()
