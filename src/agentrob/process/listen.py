"""Listen addresses: parses `host:port`, tells whether it is on this machine only or in use, and opens its socket."""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit


def parse_listen(listen: str) -> tuple[str, int]:
    """Host and port of `127.0.0.1:8088` or `[::1]:8088`; port 0 takes a free one. Raises `ValueError`."""
    try:
        parts = urlsplit(f"//{listen}")
        if parts.hostname and parts.port is not None and parts.netloc == listen and not parts.username:
            return parts.hostname, parts.port
    except ValueError:
        pass
    raise ValueError(f"{listen!r} is not host:port, for example 127.0.0.1:8088")


def host_in_url(host: str) -> str:
    """The host as it stands in a URL: an IPv6 address in brackets."""
    return f"[{host}]" if ":" in host else host


def base_url(host: str, port: int) -> str:
    """`http://host:port`."""
    return f"http://{host_in_url(host)}:{port}"


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach `host`."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def is_free(host: str, port: int) -> bool:
    """Return whether a server can listen on the address now: no other program does, and it is this machine's."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as s:
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            s.bind((host, port))
        except OSError:
            return False
    return True


def open_listener(host: str, port: int) -> socket.socket:
    """A socket that listens on the address. Raises `OSError`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    return socket.create_server((host, port), family=family, backlog=512)
