"""AgentRob: a post comes in, a robot moves, a reply goes out.

    from agentrob import drive_g1_robot, drive_go2_robot

    drive_go2_robot("walk forward 1 m and wave")

These functions and their result (`Driven`) are in `agentrob.wiring.drive`, which is imported on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from agentrob.wiring.drive import Driven, drive_g1_robot, drive_go2_robot, robot_command_driver

__version__ = "0.1.0"
__all__ = ["Driven", "__version__", "drive_g1_robot", "drive_go2_robot", "robot_command_driver"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("agentrob.wiring.drive"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
