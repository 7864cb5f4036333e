"""Where type checkers find the public names; `__init__.py` imports each on first use."""

from agentrob.config.forum import ForumConfig as ForumConfig
from agentrob.config.robots import RobotConfig as RobotConfig
from agentrob.errors import (
    AgentRobError as AgentRobError,
)
from agentrob.errors import (
    ConfigError as ConfigError,
)
from agentrob.errors import (
    ForumDenied as ForumDenied,
)
from agentrob.errors import (
    ForumError as ForumError,
)
from agentrob.errors import (
    ForumLimited as ForumLimited,
)
from agentrob.errors import (
    ForumNotFound as ForumNotFound,
)
from agentrob.errors import (
    ForumUnoffered as ForumUnoffered,
)
from agentrob.errors import (
    ForumUnreachable as ForumUnreachable,
)
from agentrob.errors import (
    MindError as MindError,
)
from agentrob.errors import (
    RobotBusy as RobotBusy,
)
from agentrob.errors import (
    RobotError as RobotError,
)
from agentrob.errors import (
    RobotUnreachable as RobotUnreachable,
)
from agentrob.errors import (
    SimError as SimError,
)
from agentrob.eyes.contract import check_detector as check_detector
from agentrob.eyes.protocol import Detection as Detection
from agentrob.eyes.protocol import Detector as Detector
from agentrob.forums.cards import card_by as card_by
from agentrob.forums.contract import ForumContract as ForumContract
from agentrob.forums.contract import World as World
from agentrob.forums.protocol import Board as Board
from agentrob.forums.protocol import Event as Event
from agentrob.forums.protocol import Forum as Forum
from agentrob.forums.protocol import Topic as Topic
from agentrob.forums.protocol import Written as Written
from agentrob.mcp.client import (
    ForumClient as ForumClient,
)
from agentrob.mcp.client import (
    ServerUnavailable as ServerUnavailable,
)
from agentrob.mcp.client import (
    ToolFailed as ToolFailed,
)
from agentrob.minds.protocol import Addressee as Addressee
from agentrob.minds.protocol import Mind as Mind
from agentrob.minds.rules import RulesMind as RulesMind
from agentrob.model import (
    Account as Account,
)
from agentrob.model import (
    AccountKind as AccountKind,
)
from agentrob.model import (
    ActionClass as ActionClass,
)
from agentrob.model import (
    ActionResult as ActionResult,
)
from agentrob.model import (
    Capabilities as Capabilities,
)
from agentrob.model import (
    Choice as Choice,
)
from agentrob.model import (
    CommandState as CommandState,
)
from agentrob.model import (
    Direction as Direction,
)
from agentrob.model import (
    EventKind as EventKind,
)
from agentrob.model import (
    Intent as Intent,
)
from agentrob.model import (
    Limits as Limits,
)
from agentrob.model import (
    Number as Number,
)
from agentrob.model import (
    Op as Op,
)
from agentrob.model import (
    Operation as Operation,
)
from agentrob.model import (
    Option as Option,
)
from agentrob.model import (
    Outcome as Outcome,
)
from agentrob.model import (
    Page as Page,
)
from agentrob.model import (
    Plan as Plan,
)
from agentrob.model import (
    Pose as Pose,
)
from agentrob.model import (
    Post as Post,
)
from agentrob.model import (
    Primitive as Primitive,
)
from agentrob.model import (
    Quantity as Quantity,
)
from agentrob.model import (
    RobotState as RobotState,
)
from agentrob.model import (
    Role as Role,
)
from agentrob.model import (
    StatusCard as StatusCard,
)
from agentrob.model import (
    StopResult as StopResult,
)
from agentrob.model import (
    Understanding as Understanding,
)
from agentrob.model import (
    Unit as Unit,
)
from agentrob.process.child import print_ready as print_ready
from agentrob.robots.contract import RobotContract as RobotContract
from agentrob.robots.contract import go_on as go_on
from agentrob.robots.control.controller import RATE_HZ as RATE_HZ
from agentrob.robots.control.controller import Gait as Gait
from agentrob.robots.control.controller import Velocity as Velocity
from agentrob.robots.control.controller import wrap as wrap
from agentrob.robots.control.step_runner import REST_LIMIT_S as REST_LIMIT_S
from agentrob.robots.control.step_runner import run_step as run_step
from agentrob.robots.control.timed import run_for as run_for
from agentrob.robots.fake import FakeRobot as FakeRobot
from agentrob.robots.protocol import Robot as Robot
from agentrob.robots.protocol import Simulator as Simulator
from agentrob.robots.protocol import Watch as Watch
from agentrob.robots.protocol import limits_of as limits_of
from agentrob.wiring.drive import (
    Driven as Driven,
)
from agentrob.wiring.drive import (
    drive_g1_robot as drive_g1_robot,
)
from agentrob.wiring.drive import (
    drive_go2_robot as drive_go2_robot,
)
from agentrob.wiring.drive import (
    robot_command_driver as robot_command_driver,
)

__version__: str
PUBLIC: dict[str, tuple[str, ...]]
