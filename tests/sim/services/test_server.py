"""The served world seen from outside: by the vendor's SDK on DDS, by HTTP, and by signals."""

import io
import json
import resource
import signal
import subprocess
import sys

import httpx2
import numpy as np
import pytest
from PIL import Image

from agentrob.sim.domains import PrivateDomain
from tests.sim.served_world import start_world

pytestmark = pytest.mark.sim

#: The libraries that a served world imports: physics, pictures, HTTP and DDS.
LIBRARIES = ("numpy", "mujoco", "PIL.Image", "http.server", "cyclonedds.domain", "unitree_sdk2py.idl.default")


@pytest.fixture(scope="module")
def sdk(served):
    """Return what the vendor's client observed in one run."""
    script = "tests.sim.services.sdk_client"
    done = subprocess.run(
        [sys.executable, "-m", script, str(served.domain)], capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.strip().splitlines()[-1])


def test_it_is_ready(served):
    assert served.ready["ready"] is True
    assert served.ready["domains"] == {"go2": served.domain}


def test_its_start_takes_a_few_times_the_work_of_importing_its_libraries(served):
    """About 3.5 times. In processor time, because the machine may be busy; relative, because it may be slow."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", f"import {', '.join(LIBRARIES)}"], timeout=100, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    imports_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert served.cpu_until_ready_s < 6.0 * imports_s


def test_the_sdk_gets_true_codes(sdk):
    assert sdk["balance"] == 0
    assert sdk["left_flip"] == 3203
    assert sdk["select"] == 3203
    assert sdk["mode"][0] == 0
    assert sdk["second_gesture"] == 4205


def test_the_sdk_gets_a_fresh_picture(sdk):
    assert sdk["image"]["code"] == 0
    image = Image.open(io.BytesIO(bytes.fromhex(sdk["image"]["hex"])))
    assert (image.format, image.size) == ("JPEG", (640, 480))
    assert np.asarray(image).std() > 20


def test_one_move_is_held_a_second_and_then_the_robot_stops(sdk):
    (x0, y0, _), (x1, y1, yaw) = sdk["start"]["pose"], sdk["held"]["pose"]
    assert 0.3 < x1 - x0 < 0.75
    assert abs(y1 - y0) < 0.1
    assert abs(yaw) < 8
    assert 1.0 < sdk["held"]["seconds"] < 4.0


def test_a_stop_is_answered_at_once_and_breaks_off_the_gesture(sdk):
    code, seconds = sdk["stop"]
    assert code == 0
    assert seconds < 1.0
    assert sdk["hello"][0] == 4201
    assert sdk["hello"][1] < 7.0


def test_the_topics_come_as_on_the_real_robot(sdk):
    assert 25 < sdk["rate_hz"] < 55
    assert sdk["start"]["codes"] == [1013, 1]
    assert 0 < sdk["low"]["soc"] <= 100
    assert sdk["low"]["whole"], "its checksum"
    assert 24 < sdk["low"]["volts"] < 34
    assert sdk["low"]["joints"] == pytest.approx([0, 0.8, -1.5] * 4, abs=0.25)
    assert sdk["start"]["ranges"][0] > 3.0


def test_the_ledger_tells_what_the_robot_did(served, sdk):
    events = [json.loads(line) for line in served.event_log.read_text().splitlines()]
    names = [e["event"] for e in events]
    begin, end = names.index("move_begin"), names.index("move_end")
    walked = events[end]["pose"]["x_m"] - events[begin]["pose"]["x_m"]
    odometry = sdk["held"]["pose"][0] - sdk["start"]["pose"][0]
    assert walked == pytest.approx(odometry, abs=0.03)
    assert {"action_begin", "stop_move", "action_end"} <= set(names)


def test_reset_puts_the_robot_back_and_restarts_its_odometry(served, sdk):
    with httpx2.Client(base_url=served.url, timeout=100) as room:
        away = room.get("/truth").json()["robots"]["go2"]
        assert away["x_m"] > -1.2
        assert room.post("/reset").json() == {"reset": True}
        back = room.get("/truth").json()["robots"]["go2"]
        assert back["x_m"] == pytest.approx(-1.42, abs=0.03)
        assert back["upright"] > 0.99
        assert back["contacts"] == []


def test_the_room_shows_itself_and_its_health(served):
    with httpx2.Client(base_url=served.url, timeout=100) as room:
        picture = room.get("/overview.jpg")
        assert picture.headers["content-type"] == "image/jpeg"
        assert Image.open(io.BytesIO(picture.content)).size == (800, 450)
        film = room.get("/film/go2.jpg?ago_s=0.5")
        assert Image.open(io.BytesIO(film.content)).size == (640, 360)
        for wrong in ("/film/spot.jpg", "/film/go2.jpg?ago_s=500", "/film/go2.jpg?ago_s=soon"):
            answer = room.get(wrong)
            assert answer.status_code == 404
            assert "ago_s from 0 to 120 seconds" in answer.json()["error"]
        health = room.get("/health").json()
        assert health["frames_rendered"] >= 1
        assert health["real_time_factor"] > 0.5
        assert health["trouble"] == []
        assert room.get("/nothing").status_code == 404
        assert room.post("/nothing").status_code == 404


def test_a_web_page_cannot_reset_the_room(served):
    with httpx2.Client(base_url=served.url, timeout=100) as room:
        assert room.post("/reset", headers={"Origin": "https://evil.example"}).status_code == 403
        assert room.get("/truth", headers={"Host": "evil.example"}).status_code == 403


def test_a_second_world_on_the_domain_is_one_clear_line(served):
    command = [sys.executable, "-m", "agentrob.sim.server", "--domain", str(served.domain)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert f"domain {served.domain} (lo) is already held" in done.stderr


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--interface", "lo9"], "no network interface 'lo9'"),
        (["--domain", "999"], "valid: 0 to 230"),
        (["--domain", "171", "--event-log", "/no/such/folder/x"], "cannot write the event log"),
    ],
)
def test_wrong_settings_are_one_clear_line(options, expected):
    command = [sys.executable, "-m", "agentrob.sim.server", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert expected in done.stderr


@pytest.mark.parametrize("number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_it_ends_at_a_signal_and_leaves_the_domain_free(tmp_path, number):
    own = PrivateDomain()  # which no other test can take in between
    world = start_world(tmp_path, environment={"MUJOCO_GL": "off"}, domains=[own.number])
    assert world.ready["camera"] == "ray"
    assert world.end(number) < 1.0
    assert world.process.returncode == 0
    assert world.process.communicate()[1] == ""
    port = world.url.rsplit(":", 1)[1]
    start_world(tmp_path, "--http-port", port, environment={"MUJOCO_GL": "off"}, domains=[own.number]).end()
