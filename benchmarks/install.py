"""Install AgentRob from its wheels without our locks, and open the demo's page: seconds, packages and megabytes.

    make dist && python benchmarks/install.py [--with pip|uvx] [--dist DIR]

`pip` makes an empty environment, installs `agentrob[sim]` into it with nothing cached, and starts the demo; `uvx` lets
uv do the same in one command, with an empty cache of its own (needs `uv`). The time counts from the first command until
the address of the page is printed and answers. What it downloads depends on the network. Prints one JSON object.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import httpx2

DIST = Path(__file__).resolve().parents[1] / "dist"
PAGE_S = 600.0


def with_pip(folder: Path, dist: Path) -> dict[str, Any]:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "venv", folder / "env"], check=True)
    python = folder / "env/bin/python"
    made = time.perf_counter()
    command = [python, "-m", "pip", "install", "--quiet", "--no-cache-dir", "--find-links", dist, "agentrob[sim]"]
    subprocess.run(command, check=True)
    installed = time.perf_counter()
    opened = until_page([str(folder / "env/bin/agentrob")], folder, {})
    done = time.perf_counter()
    listed = subprocess.run([python, "-m", "pip", "list", "--format", "json"], capture_output=True, check=True)
    packages = [one["name"] for one in json.loads(listed.stdout) if one["name"] not in ("pip", "setuptools")]
    return {
        "environment_s": round(made - began, 1),
        "install_s": round(installed - made, 1),
        "demo_s": round(opened, 1),
        "from_nothing_to_page_s": round(done - began, 1),
        "packages": len(packages),
        "megabytes": round(size_mb(folder / "env"), 1),
        "megabytes_without_pyc_and_pip": round(size_mb(folder / "env", ("__pycache__", "pip")), 1),
    }


def with_uvx(folder: Path, dist: Path) -> dict[str, Any]:
    (wheel,) = dist.glob("agentrob-*.whl")
    command = ["uvx", "--find-links", str(dist), "--from", f"agentrob[sim] @ {wheel.as_uri()}", "agentrob"]
    took = until_page(command, folder, {"UV_CACHE_DIR": str(folder / "cache")})
    return {"from_nothing_to_page_s": round(took, 1), "megabytes": round(size_mb(folder / "cache"), 1)}


def until_page(agentrob: list[str], folder: Path, environment: Mapping[str, str]) -> float:
    """Start the demo, wait until its page answers, end it; return the seconds until then."""
    began = time.perf_counter()
    command = [*agentrob, "demo", "--no-browser", "--port", "0", "--data", str(folder / "data")]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}, start_new_session=True
    )
    try:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"http://127\.0\.0\.1:\d+", line):
                httpx2.get(found[0], timeout=PAGE_S, follow_redirects=True).raise_for_status()
                return time.perf_counter() - began
        raise RuntimeError(f"the demo ended with {process.wait()}")
    finally:
        os.killpg(process.pid, signal.SIGINT)
        process.wait(60)


def size_mb(folder: Path, leaving_out: Collection[str] = ()) -> float:
    """Return the size of the files of a folder, without folders of these names; a file linked twice counts once."""
    paths = [path for path in folder.rglob("*") if not set(leaving_out) & set(path.relative_to(folder).parts)]
    files = {(found.st_dev, found.st_ino): found.st_size for found in (path.lstat() for path in paths)}
    return sum(files.values()) / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--with", dest="tool", choices=["pip", "uvx"], default="pip")
    parser.add_argument("--dist", type=Path, default=DIST, help="the folder with the wheels")
    arguments = parser.parse_args()
    if not list(arguments.dist.glob("agentrob-*.whl")):
        sys.exit(f"no wheel in {arguments.dist}; build them with: make dist")
    with tempfile.TemporaryDirectory() as folder:
        load = os.getloadavg()[0]
        measure = {"pip": with_pip, "uvx": with_uvx}[arguments.tool]
        print(
            json.dumps({"tool": arguments.tool, "load_before": round(load, 1), **measure(Path(folder), arguments.dist)})
        )


if __name__ == "__main__":
    main()
