"""`python -m tests.doubles.discourse`: serve the double on loopback and say how to sign in."""

from __future__ import annotations

import argparse
import socket
import sys

import uvicorn

from tests.doubles.discourse.app import create_app
from tests.doubles.discourse.site import LIFTED, Site


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.doubles.discourse", description=__doc__)
    parser.add_argument("--port", type=int, default=8090, help="0 for any free one")
    parser.add_argument(
        "--lifted", action="store_true", help="with the limits lifted that docs/forum/discourse.md names"
    )
    asked = parser.parse_args()
    site = Site(LIFTED if asked.lifted else None)
    site.add_category("Robots", "robots")
    key = site.add_key()
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.bind(("127.0.0.1", asked.port))
    listener.listen()
    sys.stdout.write(f"http://127.0.0.1:{listener.getsockname()[1]}\nAPI key for all users: {key}\nan admin: system\n")
    sys.stdout.flush()
    uvicorn.Server(uvicorn.Config(create_app(site), log_level="warning")).run(sockets=[listener])


if __name__ == "__main__":
    main()
