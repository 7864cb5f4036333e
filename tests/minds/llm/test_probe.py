"""`agentrob mind check`: one line for each mind, an exit code, and errors with advice."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.probe import ProbeResult, probe
from tests.in_process import Said, agentrob
from tests.minds.faulty_server import FaultyServer, called, said
from tests.minds.model_double import Double

#: Never set: a server that waits for it is too slow.
never = threading.Event()
Start = Callable[[list[dict[str, Any]]], Double]
TOOL = {
    "match": {"userMessage": "set_number"},
    "response": {"toolCalls": [{"name": "set_number", "arguments": {"number": 7}}]},
}
FORWARD = {"action": "move", "direction": "forward", "amount": 1, "unit": "m", "words": "go ahead for one metre"}
READ = {"intent": "command", "steps": [FORWARD]}
FINE = {"decision": "fine"}
READS = {
    "match": {"systemMessage": "Reading posts"},
    "response": {"toolCalls": [{"name": "answer", "arguments": READ}]},
}
LOOKS = {
    "match": {"systemMessage": "Looking at"},
    "response": {"toolCalls": [{"name": "answer", "arguments": FINE}]},
}
RED = {"match": {"userMessage": "Which colour"}, "response": {"content": "Red."}}


def at(url: str, **more: Any) -> MindConfig:
    return MindConfig.model_validate({"provider": "compatible", "model": "some-model", "base_url": url, **more})


def right_answer(body: dict[str, Any]) -> tuple[int, Any] | None:
    """Return the correct response to an agent's request and to the tool call; None for any other request."""
    if "tools" not in body:
        return None
    system = body["messages"][0]["content"]
    if "tried out" in system:
        return 200, called("set_number", {"number": 7})
    return 200, called("answer", READ if system.startswith("# Reading posts") else FINE)


@pytest.mark.parametrize(("provider", "path"), [("openai", "/v1"), ("anthropic", "")])
async def test_a_good_mind(double: Start, tmp_path: Path, key: str, provider: str, path: str) -> None:
    running = double([LOOKS, READS, TOOL, RED])
    config = at(running.url + path, provider=provider, key_env="TEST_KEY")
    found = await probe("clever", config, tmp_path / "x.sqlite")
    assert found.ok
    assert (found.reachable, found.tool_calls, found.images) == (True, "yes", "yes")
    assert found.latency_ms > 0
    assert found.reading_s > 0
    assert found.line().startswith("clever: reachable, model some-model, tool calls yes, images yes, ")


@pytest.mark.parametrize(
    ("answer", "tool_calls", "images", "ok"),
    [
        (lambda b: (200, said("seven")), "no", "no", False),
        (lambda b: (200, called("set_number", {"number": 700})), "no", "no", False),
        (lambda b: (400, {"error": "no tools"}) if "tools" in b else (200, said("yes")), "no", "no", False),
        (lambda b: right_answer(b) or (400, {}), "yes", "no", True),
        (lambda b: right_answer(b) or (500, {}), "yes", "no", True),
        (lambda b: right_answer(b) or (200, said("green")), "yes", "no", True),
    ],
)
async def test_missing_abilities_of_a_mind(
    server: FaultyServer, tmp_path: Path, answer: Any, tool_calls: str, images: str, ok: bool
) -> None:
    def reply(handler: Any, body: Any) -> None:
        status, data = answer(body)
        handler.send(status, json.dumps(data).encode())

    server.answer = reply
    found = await probe("clever", at(server.url + "/v1"), tmp_path / "x.sqlite")
    assert found.reachable
    assert (found.tool_calls, found.images, found.ok) == (tool_calls, images, ok)
    assert ('answers = "json"' if not ok else "set images = false in [minds.clever]") in found.line()


async def test_the_report_of_a_weak_mind(server: FaultyServer, tmp_path: Path) -> None:
    def reply(handler: Any, body: Any) -> None:
        system = body["messages"][0]["content"]
        right = READ if system.startswith("# Reading posts") else FINE if system.startswith("# Looking") else None
        text = json.dumps(right or {"tool": "set_number", "arguments": {"number": 7}})
        handler.send(200, json.dumps(said(f"Of course: {text}")).encode())

    server.answer = reply
    found = await probe("weak", at(server.url + "/v1", answers="json", images=False), tmp_path / "x.sqlite")
    assert (found.ok, found.tool_calls, found.images) == (True, "yes", "off")


@pytest.mark.parametrize(
    ("reading", "says"),
    [
        (lambda: (200, called("answer", {"intent": "dance"})), 'set answers = "json_object"'),
        (lambda: (400, {"error": {"message": "exceeds the available context size"}}), "4096 tokens"),
        (lambda: never.wait(1.5) or (200, said("late")), 'timeout_s = 1 s to read; set a longer one or kind = "local"'),
    ],
)
async def test_a_mind_that_an_agent_cannot_use_is_a_failure_with_advice(
    server: FaultyServer, tmp_path: Path, reading: Any, says: str
) -> None:
    def reply(handler: Any, body: Any) -> None:
        system = body["messages"][0]["content"]
        status, data = reading() if system.startswith("# Reading") else right_answer(body) or (200, said("red"))
        handler.send(status, json.dumps(data).encode())

    server.answer = reply
    found = await probe("clever", at(server.url + "/v1", timeout_s=1.0), tmp_path / "x.sqlite")
    assert (found.reachable, found.tool_calls, found.ok) == (True, "yes", False)
    assert says in found.line()


async def check_failing(server: FaultyServer, tmp_path: Path, status: int) -> ProbeResult:
    server.answer = lambda handler, _: handler.send(status, b"{}")
    return await probe("clever", at(server.url + "/v1", key_env="TEST_KEY"), tmp_path / "x.sqlite")


async def test_each_failure_is_reported(server: FaultyServer, tmp_path: Path, key: str) -> None:
    denied = await check_failing(server, tmp_path, 401)
    assert not denied.ok
    assert "NOT reachable" in denied.line()
    assert "check the key in TEST_KEY" in denied.line()
    assert "check base_url and model" in (await check_failing(server, tmp_path, 404)).line()
    bare = await probe("bare", at(server.url), tmp_path / "x.sqlite")
    assert f'base_url = "{server.url}/v1"' in bare.line()
    assert key not in denied.line()
    lost = await probe("lost", at("http://no-such-host.invalid/v1"), tmp_path / "x.sqlite")
    assert "no such host; check base_url" in lost.line()
    plain = await probe("plain", at(server.url.replace("http:", "https:") + "/v1"), tmp_path / "x.sqlite")
    assert "no trusted connection" in plain.line()


def test_a_mind_can_be_tried_on_a_text(double: Start, tmp_path: Path, key: str) -> None:
    step = {"action": "move", "direction": "forward", "amount": 2, "unit": "m", "words": "meander forward 2 m"}
    answer = {"name": "answer", "arguments": {"intent": "command", "steps": [step]}}
    looked = {"name": "answer", "arguments": {"decision": "refuse", "harm": "people", "words": "the cards"}}
    fine = {"name": "answer", "arguments": {"decision": "fine"}}
    running = double(
        [
            {"match": {"systemMessage": "Looking at", "userMessage": "cards"}, "response": {"toolCalls": [looked]}},
            {"match": {"systemMessage": "Looking at"}, "response": {"toolCalls": [fine]}},
            {"match": {"userMessage": "meander"}, "response": {"toolCalls": [answer]}},
        ]
    )
    good = f'[minds.good]\nprovider = "openai"\nmodel = "m"\nbase_url = "{running.url}/v1"\nkey_env = "TEST_KEY"\n'
    (tmp_path / "agentrob.toml").write_text(good)
    tried = run_plan(tmp_path, "be a dear and meander forward 2 m")
    assert tried.returncode == 0, tried.stderr
    begin = "command: walk forward 2 m\n  read by good\n  the rules allow it; good does not object\n  good (m): "
    assert tried.stdout.startswith(begin)
    against = run_plan(tmp_path, "be a dear and meander forward 2 m, I love the cards")
    refused = "\n  refuse: A model that reviews commands objects to the words `the cards`: somebody may be hurt"
    assert refused in against.stdout
    assert "(model.people)" in against.stdout
    failed = run_plan(tmp_path, "walk forward 1 m", TEST_KEY="")
    assert "command: walk forward 1 m\n  read by rules\n" in failed.stdout
    assert "  the rules allow it; good could not review it: no_key\n" in failed.stdout


def run_mind(folder: Path, *args: str, **env: str) -> Said:
    """Run the command in this process, because importing the libraries takes seconds in every new one."""
    config = ("--config", str(folder / "agentrob.toml"))
    return agentrob(folder, "mind", *args, *config, AGENTROB_DATA=str(folder), **env)


def run_plan(folder: Path, text: str, **env: str) -> Said:
    config = ("--config", str(folder / "agentrob.toml"))
    return agentrob(folder, "plan", text, "--mind", "good", *config, AGENTROB_DATA=str(folder), **env)


def run_program(folder: Path, *args: str) -> Said:
    """Run the command as a separate program."""
    program = str(Path(sys.executable).with_name("agentrob"))
    done = subprocess.run(
        [program, "mind", *args],
        cwd=folder,
        env={**os.environ, "AGENTROB_DATA": str(folder)},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    return Said(done.returncode, done.stdout, done.stderr)


def test_the_command_has_a_line_for_each_mind_and_an_exit_code(double: Start, tmp_path: Path, key: str) -> None:
    running = double([LOOKS, READS, TOOL, RED])
    good = f'[minds.good]\nprovider = "openai"\nmodel = "some-model"\nbase_url = "{running.url}/v1"\n'
    good += 'key_env = "TEST_KEY"\n'
    keyless = '[minds.keyless]\nprovider = "anthropic"\nmodel = "other"\nkey_env = "NO_SUCH_VARIABLE"\n'
    (tmp_path / "agentrob.toml").write_text(good + keyless)
    both = run_program(tmp_path, "check")
    assert both.returncode == 1, both.stderr
    first, second, rules = both.stdout.splitlines()
    assert first.startswith("good: reachable, model some-model, tool calls yes, images yes, ")
    assert second == (
        "keyless: NOT reachable, model other: keyless: the environment variable NO_SUCH_VARIABLE must hold the key"
    )
    assert rules == "rules: always available, without a model"
    assert key not in both.stdout + both.stderr
    one = run_mind(tmp_path, "check", "good", "--json")
    assert one.returncode == 0, one.stderr
    (found,) = json.loads(one.stdout)
    assert found["ok"] is True
    unknown = run_mind(tmp_path, "check", "nobody")
    assert unknown.returncode == 1
    assert "valid: good, keyless" in unknown.stderr
