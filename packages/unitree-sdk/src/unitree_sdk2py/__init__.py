from . import idl, utils, core, rpc, go2, b2

__all__ = [
    "idl"
    "utils"
    "core",
    "rpc",
    "go2",
    "b2",
]
