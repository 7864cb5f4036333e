"""How often a configured model is called: never for a post that the rules understand, once for one they ask back."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from agentrob.language.visible_text import visible_text
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.protocol import Addressee, Reading
from agentrob.minds.rules import RulesMind
from agentrob.model import Capabilities, Intent, Op
from agentrob.wiring import app
from tests.language.parser import generated_posts
from tests.minds.scripted_model import ScriptedModel, running_scripted_model
from tests.sizes import size

pytestmark = pytest.mark.usefixtures("model_libraries")

LISTENER = Addressee(("quadruped",), ("dog2",), Capabilities("go2", frozenset(Op)))
TESTS = Path(__file__).parents[1]
ASKED_BACK = TESTS / "language/asks_back.jsonl"
PLAIN = TESTS / "semantic/plain_posts.jsonl"


@pytest.fixture
def scripted_model() -> Iterator[ScriptedModel]:
    with running_scripted_model() as made:
        yield made


@pytest.fixture
def configured(scripted_model: ScriptedModel, tmp_path: Path) -> Callable[[], ModelMind]:
    """Return a function that makes the mind `clever` from a configuration with only the model and its price."""

    def make() -> ModelMind:
        table = {"provider": "compatible", "model": "some-model", "base_url": f"{scripted_model.server.url}/v1"}
        price = {"input_per_million": 2.0, "output_per_million": 10.0}
        minds = {"clever": {**table, "price": price, "limits": {"day_tokens": 0}}}
        mind = app.make_mind("clever", app.configuration.parse({"data": str(tmp_path), "minds": minds}))
        assert isinstance(mind, ModelMind)
        return mind

    return make


def rows(path: Path) -> list[str]:
    return [json.loads(line)["text"] for line in path.read_text(encoding="utf-8").splitlines()]


async def readings(texts: list[str], mind: ModelMind) -> list[tuple[Intent, Reading]]:
    """Return for each text the reading by the rules and the reading by the mind."""
    found = []
    for text in texts:
        post = visible_text(f"@quadruped {text}")
        found.append(((await RulesMind().understand(post, LISTENER)).intent, await mind.read(post, LISTENER)))
    await mind.close()
    return found


async def test_posts_that_the_rules_understand_call_no_model(
    scripted_model: ScriptedModel, configured: Callable[[], ModelMind]
) -> None:
    texts = rows(PLAIN) + [post.text for post in generated_posts.posts(size(500, 10_000))]
    texts = [text for text in texts if (await RulesMind().understand(text, LISTENER)).intent is not Intent.ASK_BACK]
    found = await readings(texts, configured())
    assert len(found) > 300
    assert {(reading.mind, tuple(reading.usage), reading.fallback) for _, reading in found} == {("rules", (), "")}
    assert sum(reading.understanding.intent is Intent.COMMAND for _, reading in found) > 250
    assert scripted_model.server.requests == []


async def test_a_post_that_the_rules_ask_back_calls_the_model_once(
    scripted_model: ScriptedModel, configured: Callable[[], ModelMind]
) -> None:
    texts = rows(ASKED_BACK)[:: size(6, 1)]
    found = await readings(texts, configured())
    assert {intent for intent, _ in found} == {Intent.ASK_BACK}
    assert [kind for kind, _ in scripted_model.asked] == ["read"] * len(found)
    assert {(reading.mind, len(reading.usage)) for _, reading in found} == {("clever", 1)}
    assert all(reading.usage[0].cost for _, reading in found)
