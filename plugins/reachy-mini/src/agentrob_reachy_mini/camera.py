"""A picture of the robot's camera from the address that its owner configured."""

from __future__ import annotations

import httpx2

from agentrob.errors import RobotError

LIMIT_S = 3.0
MOST_BYTES = 8_000_000


def picture(url: str) -> bytes:
    """Return a JPEG. Raises `RobotError` with a sentence if there is none."""
    content = bytearray()
    try:
        with httpx2.stream("GET", url, timeout=LIMIT_S, trust_env=False) as response:
            if response.status_code != 200:
                raise RobotError(f"its camera {url} answered {response.status_code}")
            for piece in response.iter_bytes():
                content += piece
                if len(content) > MOST_BYTES:
                    raise RobotError(f"its camera {url} sends more than {MOST_BYTES // 1_000_000} MB")
    except httpx2.HTTPError as e:
        raise RobotError(f"its camera {url} does not answer ({type(e).__name__})") from None
    if not content.startswith(b"\xff\xd8"):
        raise RobotError(f"its camera {url} sent something else than a JPEG")
    return bytes(content)
