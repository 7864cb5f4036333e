"""Wire compatibility: our driver and simulator interoperate with the libraries that real robots run.

The peers are Unitree's Python SDK on cyclonedds 0.10, and the RPC server and topics of Unitree's own C++ library
(cyclonedds 0.10.2), as packaged in `far-unitree-sdk`. That package has no RPC client, so the Python SDK drives the
simulated robots.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.tolerances import about_m
from tests.wire.wire_scene import HERE, OURS, PEER, SHIM, Network

pytestmark = [pytest.mark.sim, pytest.mark.slow]

CONFIG = """
data = "{data}"
[robots.theirs]
model = "{model}"
interface = "lo"
domain = {domain}
allow_unknown_ranges = true
options = {options}
"""


@pytest.fixture
def network() -> Iterator[Network]:
    assert (PEER.parents[1] / ".stamp").exists(), "the peers are not installed; `make test-long` does, by scripts/peers"
    network = Network()
    yield network
    network.close()


def drive_theirs(network: Network, folder: Path, model: str, domain: int, text: str) -> dict[str, Any]:
    """Drive their robot with our driver and `agentrob.robot_command_driver`, configured as for a real robot."""
    config = folder / "agentrob.toml"
    options = "{ videohub = true }" if model == "g1" else "{}"
    config.write_text(CONFIG.format(data=folder / "data", model=model, domain=domain, options=options))
    env = {"AGENTROB_RUNTIME": str(folder)}
    network.start(OURS, "-m", "agentrob", "driver", "--config", config, log=folder / "driver.log", env=env)
    said: dict[str, Any] = json.loads(network.run(OURS, HERE / "drive_robot.py", config, "theirs", text, env=env))
    return said


def last_object(out: str) -> dict[str, Any]:
    """Return the last line that is a JSON object; Unitree's library prints other lines before and after it."""
    (*_, last) = [line for line in out.splitlines() if line.startswith("{")]
    return dict(json.loads(last))


def calls(path: Path) -> list[tuple[str, int]]:
    return [(service, api_id) for service, api_id, _ in map(json.loads, path.read_text().splitlines())]


def simulate(network: Network, folder: Path, robot: str) -> None:
    network.start(OURS, "-m", "agentrob", "sim", "--domain", f"{robot}=0", log=folder / "world.log")


# ---------------------------------------------------------------------- their client, our simulated robot
@pytest.mark.parametrize(("robot", "motors"), [("go2", 20), ("g1", 35)])
def test_unitrees_sdk_on_cyclonedds_0_10_drives_our_simulated_robot(
    network: Network, tmp_path: Path, robot: str, motors: int
) -> None:
    simulate(network, tmp_path, robot)
    seen = last_object(network.run(PEER, HERE / "python_client.py", robot, "0"))
    assert seen["walked_m"] > 0.3
    assert (seen["ready"], seen["stop"], seen["gesture"]) == (0, 0, 0)
    assert seen["unknown"] == 3203, "an API that is not there is answered so"
    assert seen["picture"] == [0, "ffd8"]
    assert seen["motors"] == motors
    assert 0 < seen.get("soc", 50) <= 100


def test_unitrees_cpp_library_reads_the_odometry_of_our_simulated_g1(network: Network, tmp_path: Path) -> None:
    simulate(network, tmp_path, "g1")
    read = last_object(network.run(PEER, HERE / "cpp_reader.py", "g1", "5"))
    assert read["position"][2] == pytest.approx(0.76, abs=0.05)
    assert sum(q * q for q in read["quaternion"]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("robot", ["go2", "g1"])
def test_unitrees_cpp_library_reads_the_joints_of_our_simulated_robot(
    network: Network, tmp_path: Path, robot: str
) -> None:
    simulate(network, tmp_path, robot)
    read = last_object(network.run(PEER, HERE / "cpp_reader.py", robot, "5"))
    assert sum(q * q for q in read["low_quaternion"]) == pytest.approx(1.0, abs=0.01)
    assert any(abs(angle) > 0.1 for angle in read["joints"])


def test_without_our_patch_of_cyclonedds_11_unitrees_cpp_library_hears_nothing(
    network: Network, tmp_path: Path
) -> None:
    """Without the patch in `agentrob.process.dds` nothing is received. If this test fails, the patch may no longer be
    needed."""
    heard = {}
    for way in ("plain", "patched"):
        network.start(OURS, HERE / "publish_odometry.py", way, log=tmp_path / f"{way}.log")
        heard[way] = last_object(network.run(PEER, HERE / "cpp_reader.py", "g1", "3"))["position"]
    assert heard == {"plain": [0, 0, 0], "patched": [1, 2, 3]}


# ---------------------------------------------------------------------- our driver, their robot
def test_our_driver_drives_a_go2_served_by_unitrees_sdk_on_cyclonedds_0_10(network: Network, tmp_path: Path) -> None:
    call_log = tmp_path / "calls"
    network.start(PEER, HERE / "python_go2.py", "3", call_log, log=tmp_path / "peer.log")
    seen = drive_theirs(network, tmp_path, "go2", 3, "walk forward 50 cm, turn left 30 degrees, wave and take a photo")
    assert seen["status"] == "done", seen
    assert seen["battery"] == 77
    assert [step["op"] for step in seen["steps"]] == ["move", "turn", "hello", "get_front_image"]
    assert seen["steps"][-1]["picture"] > 25_000
    came = calls(call_log)
    assert {("sport", 1008), ("sport", 1003), ("sport", 1016), ("videohub", 1001)} <= set(came)
    assert came.count(("sport", 1008)) > 20, "velocities, twenty a second"


def test_our_driver_drives_a_g1_served_by_unitrees_cpp_library(network: Network, tmp_path: Path) -> None:
    call_log = tmp_path / "calls"
    network.start(PEER, HERE / "cpp_g1.py", SHIM, call_log, log=tmp_path / "peer.log")
    seen = drive_theirs(network, tmp_path, "g1", 0, "walk forward 50 cm, wave and take a photo")
    assert seen["status"] == "done", seen
    assert seen["steps"][0]["measured"]["distance_m"] == about_m(0.5)
    assert seen["steps"][-1]["picture"] > 25_000
    came = calls(call_log)
    assert {("sport", 7001), ("sport", 7105), ("arm", 7106)} <= set(came)
    assert came.count(("sport", 7105)) > 20, "velocities, twenty a second"


def test_our_driver_turns_a_g1_served_by_unitrees_cpp_library(network: Network, tmp_path: Path) -> None:
    network.start(PEER, HERE / "cpp_g1.py", SHIM, tmp_path / "calls", log=tmp_path / "peer.log")
    seen = drive_theirs(network, tmp_path, "g1", 0, "turn left 20 degrees")
    assert seen["status"] == "done", seen
