"""A Go2 and a G1 in one served world, each on a domain of its own, seen by the vendor's SDK and by HTTP."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import httpx2
import numpy as np
import pytest
from PIL import Image

from agentrob.errors import SimError
from agentrob.sim.server import parse_domains
from tests.host_numbers import dds_number
from tests.sim.served_world import ServedWorld, start_world

pytestmark = pytest.mark.sim

G1_DOMAIN = 211 + dds_number()


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    world = start_world(tmp_path_factory.mktemp("both"), "--domain", f"g1={G1_DOMAIN}")
    yield world
    if world.process.poll() is None:
        world.end()


@pytest.fixture(scope="module")
def sdk(both: ServedWorld) -> dict[str, Any]:
    """Return what the vendor's client observed of the G1 in one run."""
    script = "tests.sim.services.sdk_g1_client"
    command = [sys.executable, "-m", script, str(G1_DOMAIN)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    seen: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return seen


def test_one_process_serves_both_robots(both: ServedWorld) -> None:
    assert both.ready["domains"] == {"go2": both.domain, "g1": G1_DOMAIN}
    with httpx2.Client(base_url=both.url, timeout=100) as room:
        robots = room.get("/truth").json()["robots"]
        assert {name: pose["contacts"] for name, pose in robots.items()} == {"go2": [], "g1": []}
        assert all(pose["upright"] > 0.98 for pose in robots.values())
        overview = Image.open(io.BytesIO(room.get("/overview.jpg").content))
        assert overview.size == (800, 450)


def test_the_sdk_gets_the_state_and_true_codes(sdk: dict[str, Any]) -> None:
    assert sdk["fsm"] == [0, 500]
    assert sdk["height"][1] == pytest.approx(0.77, abs=0.03)
    assert sdk["old_start"] == 3204, "the SDK's Start sends the state of older firmware"
    assert sdk["velocity"] == 0
    assert (sdk["clap"], sdk["release"], sdk["bad_id"]) == (4201, 0, 7402)
    code, actions = sdk["actions"]
    assert code == 0
    assert {99, 17, 20, 26, 27} <= {action["id"] for action in actions}


def test_a_velocity_is_held_as_long_as_it_says(sdk: dict[str, Any]) -> None:
    (x0, y0, _), (x1, y1, yaw) = sdk["start"], sdk["held"]
    assert 0.35 < x1 - x0 < 0.9
    assert abs(y1 - y0) < 0.15
    assert abs(yaw) < 15


def test_its_low_state_is_that_of_a_humanoid(sdk: dict[str, Any]) -> None:
    assert sdk["low"]["motors"] == 35
    assert sdk["low"]["whole"], "its checksum"
    assert np.abs(sdk["low"]["joints"][6:12]).max() < 1.2
    assert sdk["low"]["quaternion"][0] ** 2 > 0.98
    assert 25 < sdk["rate_hz"] < 55


def test_its_camera_gives_a_picture_by_our_convention(sdk: dict[str, Any]) -> None:
    assert sdk["image"]["code"] == 0
    image = Image.open(io.BytesIO(bytes.fromhex(sdk["image"]["hex"])))
    assert (image.format, image.size) == ("JPEG", (640, 480))
    assert np.asarray(image).std() > 20


def test_a_reset_puts_both_back(both: ServedWorld, sdk: dict[str, Any]) -> None:
    with httpx2.Client(base_url=both.url, timeout=100) as room:
        away = room.get("/truth").json()["robots"]["g1"]["x_m"]
        assert room.post("/reset").json() == {"reset": True}
        back = room.get("/truth").json()["robots"]["g1"]["x_m"]
        assert back == pytest.approx(1.17, abs=0.05)
        assert back - away > 0.25


def test_domains_are_read_and_a_number_alone_is_the_go2s() -> None:
    assert parse_domains(["3"]) == {"go2": 3}
    assert parse_domains(["go2=1", "g1=2"]) == {"go2": 1, "g1": 2}
    for wrong in ("g1", "g1=", "g1=x", "=-1", ""):
        with pytest.raises(SimError, match="not ROBOT=DOMAIN"):
            parse_domains([wrong])


def test_two_robots_on_one_domain_are_refused() -> None:
    command = [sys.executable, "-m", "agentrob.sim.server", "--domain", "go2=170", "--domain", "g1=170"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 1
    assert "each simulated robot needs a DDS domain of its own" in done.stderr
    assert done.stderr.count("\n") == 1
