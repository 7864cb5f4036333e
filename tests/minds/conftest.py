"""Servers on loopback that the minds call."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.model import ConfiguredModel
from tests.minds.faulty_server import KEY, FaultyServer, faulty_server
from tests.minds.model_double import Double, model_double


@pytest.fixture
def server() -> Iterator[FaultyServer]:
    """Run a provider whose failures are scripted."""
    with faulty_server() as running:
        yield running


@pytest.fixture
def double(tmp_path: Path) -> Iterator[Callable[[list[dict[str, Any]]], Double]]:
    """Return a function that starts the double of both providers with fixtures."""
    with ExitStack() as stack:
        yield lambda fixtures: stack.enter_context(model_double(tmp_path, fixtures))


@pytest.fixture
def key(monkeypatch: pytest.MonkeyPatch) -> str:
    """Set an API key in the environment variable TEST_KEY."""
    monkeypatch.setenv("TEST_KEY", KEY)
    return KEY


@pytest.fixture
def make(tmp_path: Path, key: str) -> Callable[..., ConfiguredModel]:
    """Return a function that makes a configured model: `make(url, provider=…, retries=…)`. Retries wait only for
    Retry-After."""

    def make_model(url: str, name: str = "clever", **settings: Any) -> ConfiguredModel:
        given = {"provider": "compatible", "model": "some-model", "key_env": "TEST_KEY", "base_url": url, **settings}
        return ConfiguredModel(name, MindConfig.model_validate(given), tmp_path / "minds.sqlite", chance=lambda: 0.0)

    return make_model
