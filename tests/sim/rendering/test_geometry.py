"""The shape of a robot for 3D viewers: small, complete, and where MuJoCo says its bodies are."""

from __future__ import annotations

import gzip
import json
import struct
from typing import Any

import mujoco
import numpy as np
import pytest

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering.geometry import geometry
from agentrob.sim.world.legged import Legged
from agentrob.sim.world.world import World

Array = np.ndarray[Any, Any]


@pytest.fixture(scope="module")
def world() -> World:
    return World([Go2(), G1()])


def read(shape: bytes) -> tuple[dict[str, Any], bytes]:
    data = gzip.decompress(shape)
    (length,) = struct.unpack_from("<I", data)
    return json.loads(data[4 : 4 + length]), data[4 + length :]


def rotated(turn: Array, vector: Array) -> Array:
    out = np.zeros(3)
    mujoco.mju_rotVecQuat(out, vector, turn)
    return out


def product(one: Array, other: Array) -> Array:
    out = np.zeros(4)
    mujoco.mju_mulQuat(out, one, other)
    return out


def placed(head: dict[str, Any], root_at: Array, root_turn: Array, angles: Array) -> list[Array]:
    """Where each body is, as the viewer computes it."""
    at, turned = [root_at], [root_turn]
    for body in head["bodies"][1:]:
        own, place = np.array(body["turned"]), np.array(body["at"])
        if joint := body.get("joint"):
            turn, pivot = np.zeros(4), np.array(joint["pivot"])
            mujoco.mju_axisAngle2Quat(turn, np.array(joint["axis"]), angles[joint["motor"]])
            place = place + rotated(own, pivot - rotated(turn, pivot))
            own = product(own, turn)
        parent = body["parent"]
        at.append(at[parent] + rotated(turned[parent], place))
        turned.append(product(turned[parent], own))
    return at


@pytest.mark.parametrize(("index", "joints"), [(0, 12), (1, 29)])
def test_bodies_stand_where_the_model_puts_them_for_any_joint_angles(world: World, index: int, joints: int) -> None:
    robot: Legged = world.robots[index]
    head, _ = read(geometry(world.model, robot, world.scene))
    assert sum("joint" in body for body in head["bodies"]) == joints
    data, rng = mujoco.MjData(world.model), np.random.default_rng(7)
    data.qpos[:] = world.data.qpos
    angles = rng.uniform(-0.6, 0.6, joints)
    data.qpos[robot.q] = angles
    mujoco.mj_kinematics(world.model, data)
    ids = [b for b in range(world.model.nbody) if world.model.body_rootid[b] == robot.body]
    found = placed(head, data.xpos[robot.body], data.xquat[robot.body], angles)
    assert np.abs(np.array(found) - data.xpos[ids]).max() < 0.002


def test_meshes_are_complete_and_the_file_is_small(world: World) -> None:
    for robot in world.robots:
        shape = geometry(world.model, robot, world.scene)
        head, blob = read(shape)
        assert len(shape) < 450_000
        for mesh in head["meshes"]:
            vertices = np.frombuffer(blob, "<u2", 3 * mesh["vertices"], mesh["at"])
            start = mesh["at"] + (vertices.nbytes + 3) // 4 * 4
            faces = np.frombuffer(blob, f"<u{mesh['bytes']}", 3 * mesh["faces"], start)
            assert faces.max() < mesh["vertices"]
            assert np.less(mesh["low"], mesh["high"]).all()
        assert len(head["geoms"]) >= len(head["bodies"]) // 2


def test_the_room_is_drawn_without_the_walls_in_front_of_the_camera(world: World) -> None:
    head, _ = read(geometry(world.model, world.robots[0], world.scene))
    assert len(head["room"]) > 20
    walls = [geom for geom in head["room"] if geom.get("kind") == mujoco.mjtGeom.mjGEOM_BOX and max(geom["size"]) > 2.9]
    assert {tuple(np.sign(np.round(wall["at"][:2], 2))) for wall in walls} == {(1.0, 0.0), (0.0, 1.0)}
