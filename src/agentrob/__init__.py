"""AgentRob: a post comes in, a robot moves, a reply goes out.

    from agentrob import drive_go2_robot

    drive_go2_robot("walk forward 1 m and wave")

The names in `__all__` are the public part of the package; everything else is private and may change in any version.
Each name is imported from its module when it is first used, so that `import agentrob` and the command line start
quickly.
"""

from importlib import import_module
from typing import Any

__version__ = "0.2.0"
#: The public names by the module that defines them. `__init__.pyi` repeats them for type checkers.
PUBLIC = {
    "wiring.drive": ("Driven", "drive_g1_robot", "drive_go2_robot", "robot_command_driver"),
    "mcp.client": ("ForumClient", "ServerUnavailable", "ToolFailed"),
    "robots.protocol": ("Robot", "Simulator", "Watch", "limits_of"),
    "robots.contract": ("RobotContract", "go_on"),
    "robots.control.step_runner": ("REST_LIMIT_S", "run_step"),
    "robots.control.controller": ("RATE_HZ", "Gait", "Velocity", "wrap"),
    "robots.control.timed": ("run_for",),
    "robots.fake": ("FakeRobot",),
    "process.child": ("print_ready",),
    "config.robots": ("RobotConfig",),
    "eyes.protocol": ("Detection", "Detector"),
    "eyes.contract": ("check_detector",),
    "minds.protocol": ("Addressee", "Mind"),
    "minds.rules": ("RulesMind",),
    "forums.protocol": ("Board", "Event", "Forum", "Topic", "Written"),
    "forums.contract": ("ForumContract", "World"),
    "forums.cards": ("card_by",),
    "config.forum": ("ForumConfig",),
    "model": (
        "Account",
        "AccountKind",
        "ActionClass",
        "ActionResult",
        "Capabilities",
        "Choice",
        "CommandState",
        "Direction",
        "EventKind",
        "Intent",
        "Limits",
        "Number",
        "Op",
        "Operation",
        "Option",
        "Outcome",
        "Page",
        "Plan",
        "Pose",
        "Post",
        "Primitive",
        "Quantity",
        "RobotState",
        "Role",
        "StatusCard",
        "StopResult",
        "Understanding",
        "Unit",
    ),
    "errors": (
        "AgentRobError",
        "ConfigError",
        "ForumDenied",
        "ForumError",
        "ForumLimited",
        "ForumNotFound",
        "ForumUnoffered",
        "ForumUnreachable",
        "MindError",
        "RobotBusy",
        "RobotError",
        "RobotUnreachable",
        "SimError",
    ),
}
_MODULES = {name: module for module, names in PUBLIC.items() for name in names}
__all__ = ["__version__", *_MODULES]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return getattr(import_module(f"agentrob.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
