"""The table `[robots.NAME.options]` of an SO-101 arm: port, calibration, camera, joint limits, keep-out boxes.

[robots.arm.options]
port = "/dev/ttyACM0"                    # of a real arm
calibration = "my_follower"              # its id in `lerobot-calibrate`
camera = { source = "/dev/video0" }
joints = { shoulder_pan = [-60, 60] }    # narrower than the arm's own limits
keep_out = [{ name = "the monitor", from_m = [0.2, 0.1, 0.0], to_m = [0.5, 0.4, 0.6] }]
"""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, field_validator, model_validator

from agentrob.config.load import changed
from agentrob.config.robots import RobotConfig
from agentrob.config.section import Section
from agentrob_so101.kinematics import so101
from agentrob_so101.pose import NAMES, ArmPose

_Metres = Annotated[float, Field(allow_inf_nan=False, ge=-5, le=5)]
Corner = tuple[_Metres, _Metres, _Metres]


class BoxOptions(Section):
    """A box that no part of the arm may enter: two opposite corners in metres, x ahead of the arm's base, y to its
    left, z up from its foot."""

    name: Annotated[str, Field(min_length=1, max_length=40)] = "a keep-out box"
    from_m: Corner
    to_m: Corner

    @model_validator(mode="after")
    def _has_a_volume(self) -> Self:
        if not all(low < high for low, high in zip(self.from_m, self.to_m, strict=True)):
            raise ValueError("from_m must be the smaller corner and to_m the larger one, in x, y and z")
        return self


class CameraOptions(Section):
    """A camera of OpenCV's: its number or its path."""

    source: str | int = ""
    width: Annotated[int, Field(ge=16, le=4096)] = 640
    height: Annotated[int, Field(ge=16, le=4096)] = 480
    fps: Annotated[int, Field(ge=1, le=120)] = 30


class So101Options(Section):
    """See the module docstring. `table_m` is how high the table is above the arm's foot; the arm stays above it."""

    port: Annotated[str, Field(max_length=200)] = ""
    calibration: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]{0,80}$")] = ""
    calibration_folder: str = ""
    camera: CameraOptions = Field(default_factory=CameraOptions)
    table_m: _Metres = 0.0
    joints: dict[str, tuple[float, float]] = Field(default_factory=dict)
    keep_out: Annotated[tuple[BoxOptions, ...], Field(max_length=20)] = ()

    @field_validator("joints")
    @classmethod
    def _narrows(cls, joints: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        if unknown := sorted(set(joints) - set(NAMES)):
            raise ValueError(f"there is no joint {unknown[0]!r}; joints: {', '.join(NAMES)}")
        arm = so101()
        for name, (low, high) in joints.items():
            least, most = getattr(arm.lowest, name), getattr(arm.highest, name)
            if not least - 0.5 <= low < high <= most + 0.5:
                raise ValueError(
                    f"{name} must be from a smaller to a larger number within {least:.0f} to {most:.0f}, "
                    f"found {low:g} to {high:g}"
                )
        return joints

    @property
    def limits(self) -> tuple[ArmPose, ArmPose]:
        """The lowest and the highest value of each joint."""
        arm = so101()
        low = arm.lowest._replace(**{name: bounds[0] for name, bounds in self.joints.items()})
        return low, arm.highest._replace(**{name: bounds[1] for name, bounds in self.joints.items()})


def options_of(settings: RobotConfig) -> So101Options:
    """The validated options of a robot. Raises `ConfigError`, which names what is valid."""
    return changed(So101Options(), "options of an SO-101 arm", **settings.options)
