"""docs/forum/discourse.md is accurate; the double can be started as a command and departs from Discourse's document
only where stated."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from agentrob.config import load
from agentrob.errors import ForumError
from agentrob.forums.discourse.settings import DiscourseOptions
from tests.doubles import discourse
from tests.doubles.discourse.document import DEPARTURES, filled, paths
from tests.doubles.discourse.site import DEFAULTS, LIFTED
from tests.forums.discourse.discourse_world import double_world

ROOT = Path(__file__).parents[3]
GUIDE = (ROOT / "docs/forum/discourse.md").read_text(encoding="utf-8")


def test_the_configuration_in_the_guide_is_valid() -> None:
    (text,) = re.findall(r"^```toml\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    forum = load.parse(tomllib.loads(text)).forum
    options = DiscourseOptions.of(forum.options)
    assert (forum.kind, options.operators) == ("discourse", ("robot-operators", "trust_level_3"))


def test_lifted_limits_are_settings_of_discourse() -> None:
    assert LIFTED.keys() <= DEFAULTS.keys()
    for name in ("rate limit create post", "max edits per day", "approve post count"):
        assert name in GUIDE
        assert name.replace(" ", "_") in DEFAULTS


def _properties(at: Any, beside: str) -> Iterator[dict[str, Any]]:
    for item in at.values() if isinstance(at, dict) else at if isinstance(at, list) else ():
        yield from _properties(item, beside)
    if isinstance(at, dict) and isinstance(found := at.get("properties"), dict) and beside in found:
        yield found


@pytest.mark.parametrize("departure", DEPARTURES, ids=lambda d: f"{d[0]} {d[2]}")
def test_each_departure_from_the_document_still_applies(departure: tuple[str, str, str, dict[str, Any], str]) -> None:
    where, beside, name, schema, why = departure
    document = json.loads((files(discourse) / "openapi.json").read_text(encoding="utf-8"))["paths"]
    operations = {f"{m} {p}": o for p, methods in document.items() for m, o in methods.items()}
    found = [p for o, operation in operations.items() if where in ("*", o) for p in _properties(operation, beside)]
    assert found
    assert any(p.get(name) != schema for p in found)
    assert why


def test_responses_contain_all_required_fields() -> None:
    answer = filled("get", "/posts/{id}.json", {"id": 7, "raw": "words"})
    schema = paths()["/posts/{id}.json"]["get"]["responses"]["200"]["content"]["application/json"]["schema"]
    assert set(schema["required"]) <= answer.keys()
    assert (answer["id"], answer["raw"], answer["cooked"], answer["wiki"]) == (7, "words", "", False)


def test_the_extract_is_small_and_names_its_source() -> None:
    text = (files(discourse) / "openapi.json").read_text(encoding="utf-8")
    assert len(text) < 80_000
    assert "Copyright (c) 2016 Civilized Discourse Construction Kit, Inc." in text


@pytest.mark.slow
def test_the_contract_runs_against_a_discourse_at_a_url() -> None:
    command = [sys.executable, "-m", "tests.doubles.discourse", "--lifted", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as double:
        assert double.stdout is not None
        url, key, _ = (double.stdout.readline().strip() for _ in range(3))
        try:
            for _ in range(2):  # the second time, the forum is no longer new
                done = subprocess.run(
                    [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "Live",
                     str(ROOT / "tests/forums/discourse/test_contract.py")],
                    env={**os.environ, "AGENTROB_TEST_DISCOURSE_URL": url,
                         "AGENTROB_TEST_DISCOURSE_KEY": key.rpartition(" ")[2]},
                    capture_output=True, text=True, timeout=100, check=False, cwd=ROOT,
                )  # fmt: skip
                assert done.returncode == 0, done.stdout[-3000:]
                assert re.search(r"\d\d passed", done.stdout)
        finally:
            double.terminate()


async def test_traffic_outside_the_document_is_reported() -> None:
    """The validator reports a violation, so its silence in the other tests is meaningful."""
    async with double_world() as (world, double):
        alice = await world.sign_in("alice")
        assert double.violations == []
        await alice._client.ask("GET", "/user_actions.json", params={"username": "alice", "filter": "4", "offset": 0})
        topic = await alice.create_topic("robots", "A topic", "hello there", key="1")
        with pytest.raises(ForumError):
            await alice._client.ask("POST", "/posts.json", json={"topic_id": int(topic.post.topic_id), "raw": ""})
        about = {"upload_type": "composer", "colour": "red"}
        files_ = {"file": ("1.png", b"a picture", "image/png")}
        await alice._client.ask("POST", "/uploads.json", data=about, files=files_)
        body = {"raw": "some words here", "topic_id": int(topic.post.topic_id), "colour": "red"}
        await alice._client.ask("POST", "/posts.json", json=body)
        assert [v.partition(":")[0] for v in double.violations] == [
            "post /uploads.json request",
            "post /posts.json request",
        ]
        assert all("colour" in v for v in double.violations)
        double.violations.clear()
