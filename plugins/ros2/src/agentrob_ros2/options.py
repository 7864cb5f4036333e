"""The table `[robots.NAME.options]` of a ROS 2 base: topics, QoS, frames, body, places.

[robots.turtle.options]
namespace = "tb4"                        # of all topics whose names have no leading slash
cmd_vel = { stamped = true }             # TwistStamped instead of Twist
scan = { mount_m = [0.0, 0.0], mount_deg = 90 }
body = { length_m = 0.34, width_m = 0.34 }
places.kitchen = { x_m = 4.2, y_m = -1.0, words = { en = "kitchen", zh = "厨房" } }
"""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, field_validator

from agentrob.config.load import changed
from agentrob.config.robots import RobotConfig
from agentrob.config.section import Section

_TOPIC = re.compile(r"(/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*)?")


def _ros_name(name: str) -> str:
    if not _TOPIC.fullmatch(name):
        raise ValueError("not a ROS name: letters, digits and _ between slashes, no part begins with a digit")
    return name


#: A topic: absolute with a leading slash, else inside the namespace. Empty where there is none.
TopicName = Annotated[str, AfterValidator(_ros_name), Field(max_length=200)]
PlaceName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{1,39}$")]
Reliability = Literal["reliable", "best_effort"]
Durability = Literal["volatile", "transient_local"]
_Metres = Annotated[float, Field(allow_inf_nan=False, ge=-1000, le=1000)]
_Degrees = Annotated[float, Field(allow_inf_nan=False, ge=-360, le=360)]


class TopicOptions(Section):
    """QoS of one subscription. The defaults match every publisher; `reliable` or `transient_local` here match only a
    publisher that offers them too."""

    reliability: Reliability = "best_effort"
    durability: Durability = "volatile"


class CommandOptions(Section):
    """Where velocities are published. `stamped`: as TwistStamped (the default of newer distributions), with `frame`."""

    topic: TopicName = "cmd_vel"
    stamped: bool = False
    frame: str = "base_link"
    reliability: Reliability = "reliable"
    durability: Durability = "volatile"


class PoseOptions(TopicOptions):
    """Where its position comes from: `odom`, an Odometry topic, or `tf`, the transform from `odom_frame` to
    `base_frame`. `topic` is `odom` or `/tf` unless it is set."""

    source: Literal["odom", "tf"] = "odom"
    topic: TopicName = ""
    odom_frame: str = "odom"
    base_frame: str = "base_link"


class ScanOptions(TopicOptions):
    """The laser scanner. Where it sits on the base comes from `/tf_static` unless `mount_m` (forward, left) is set;
    `mount_deg` is then the direction of its angle zero, counter-clockwise from ahead."""

    topic: TopicName = "scan"
    mount_m: tuple[_Metres, _Metres] | None = None
    mount_deg: _Degrees = 0.0
    upside_down: bool = False


class ImageOptions(TopicOptions):
    """Its camera: a topic of Image, or, with `compressed`, of CompressedImage (JPEG or PNG)."""

    topic: TopicName = ""
    compressed: bool = False


class BatteryOptions(TopicOptions):
    topic: TopicName = "battery_state"


class ImuOptions(TopicOptions):
    """Its attitude, to notice that it has tipped over; without it, that of its odometry counts."""

    topic: TopicName = ""


class BodyOptions(Section):
    """Its outline seen from above, around the origin of its base frame, and how far it coasts."""

    length_m: Annotated[float, Field(gt=0.05, le=3)] = 0.36
    width_m: Annotated[float, Field(gt=0.05, le=3)] = 0.36
    coast_s: Annotated[float, Field(ge=0, le=1)] = 0.12
    least_speed_mps: Annotated[float, Field(gt=0, le=0.2)] = 0.05
    least_turn_dps: Annotated[float, Field(gt=0, le=30)] = 8.0


class PlaceOptions(Section):
    """A place on the map that Nav2 can drive to: metres in the frame of `navigation`, and perhaps which way to face.
    `words` are what people call it, by language, alternatives separated by |; in English its name, if they are not set.
    """

    x_m: _Metres
    y_m: _Metres
    facing_deg: _Degrees | None = None
    words: dict[str, str] = Field(default_factory=dict)


class NavigationOptions(Section):
    """Nav2's action `NavigateToPose`, used if there are `places`. A goal takes at most `seconds`, and the base at most
    `travel_m` from where it began; it is there within `tolerance_m`."""

    action: TopicName = "navigate_to_pose"
    frame: str = "map"
    seconds: Annotated[float, Field(gt=0, le=600)] = 60.0
    travel_m: Annotated[float, Field(gt=0, le=100)] = 20.0
    tolerance_m: Annotated[float, Field(gt=0, le=2)] = 0.35


class Ros2Options(Section):
    """See the module docstring. `peers` are addresses of robots on a network without multicast. With `use_sim_time` a
    step is timed by `/clock`; the age of states and all limits stay on this machine's clock."""

    namespace: TopicName = ""
    use_sim_time: bool = False
    holonomic: bool = False
    peers: tuple[Annotated[str, Field(pattern=r"^[A-Za-z0-9.:_-]{1,100}$")], ...] = ()
    cmd_vel: CommandOptions = Field(default_factory=CommandOptions)
    pose: PoseOptions = Field(default_factory=PoseOptions)
    scan: ScanOptions = Field(default_factory=ScanOptions)
    image: ImageOptions = Field(default_factory=ImageOptions)
    battery: BatteryOptions = Field(default_factory=BatteryOptions)
    imu: ImuOptions = Field(default_factory=ImuOptions)
    body: BodyOptions = Field(default_factory=BodyOptions)
    navigation: NavigationOptions = Field(default_factory=NavigationOptions)
    places: dict[PlaceName, PlaceOptions] = Field(default_factory=dict)

    @field_validator("cmd_vel")
    @classmethod
    def _has_commands(cls, value: CommandOptions) -> CommandOptions:
        if not value.topic:
            raise ValueError("topic must name where velocities are published, such as cmd_vel")
        return value

    def absolute(self, topic: str) -> str:
        """The absolute name of a topic: `scan` in the namespace `tb4` is `/tb4/scan`."""
        if topic.startswith("/"):
            return topic
        namespace = self.namespace.strip("/")
        return f"/{namespace}/{topic}" if namespace else f"/{topic}"

    @property
    def pose_topic(self) -> str:
        return self.absolute(self.pose.topic or ("odom" if self.pose.source == "odom" else "/tf"))


def options_of(settings: RobotConfig) -> Ros2Options:
    """The validated options of a robot. Raises `ConfigError`, which names what is valid."""
    return changed(Ros2Options(), "options of a ROS 2 base", **settings.options)
