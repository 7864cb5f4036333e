from .default import *
from . import builtin_interfaces, geometry_msgs, sensor_msgs, std_msgs, unitree_go, unitree_api

__all__ = [
    "builtin_interfaces",
    "geometry_msgs",
    "sensor_msgs",
    "std_msgs",
    "unitree_go",
    "unitree_hg",
    "unitree_api",
]
