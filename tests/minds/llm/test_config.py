"""`[minds.NAME]`: errors name the valid values and never repeat API keys, and any model name is accepted."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.config.load import Config, parse
from agentrob.errors import ConfigError
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.rules import RulesMind
from agentrob.wiring.app import make_mind

GOOD = {"provider": "openai", "model": "gpt-x"}


def minds(**tables: Any) -> Config:
    return parse({"minds": tables})


def test_three_lines_of_configuration_are_enough() -> None:
    config = minds(
        clever=GOOD, claude={"provider": "anthropic", "model": "c"}, doubao={"provider": "ark", "model": "ep-1"}
    )
    assert config.minds["clever"].key_variable == "OPENAI_API_KEY"
    assert config.minds["claude"].key_variable == "ANTHROPIC_API_KEY"
    assert config.minds["doubao"].key_variable == "ARK_API_KEY"
    assert config.minds["doubao"].address == "https://ark.cn-beijing.volces.com/api/v3"
    local = minds(local={"provider": "compatible", "model": "qwen", "base_url": "http://127.0.0.1:11434/v1/"})
    assert local.minds["local"].key_variable == ""
    assert local.minds["local"].address == "http://127.0.0.1:11434/v1"


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (
            {"provider": "openai", "model": "m", "api_key": "sk-secret"},
            r"minds\.clever\.api_key is not a setting; valid",
        ),
        (
            {**GOOD, "limits": {"per_day": 1}},
            r"limits\.per_day is not a setting; valid here: command_cost, command_tok",
        ),
        ({**GOOD, "price": {"usd": 1}}, r"price\.usd is not a setting; valid here: currency, input_per_million"),
        ({"provider": "gemini", "model": "m"}, r"'openai', 'anthropic', 'ark' or 'compatible'"),
        ({"provider": "compatible", "model": "m"}, "needs base_url"),
        ({**GOOD, "key_env": "sk-secret-1234"}, "key_env"),
        ({**GOOD, "base_url": "https://user:sk-secret@host/v1"}, "without a user, key or query"),
        ({**GOOD, "base_url": "https://host/v1?key=sk-secret"}, "without a user, key or query"),
        ({**GOOD, "base_url": "ftp://host"}, "must be http"),
        ({**GOOD, "limits": {"day_cost": 5}}, "needs a price"),
        ({**GOOD, "timeout_s": 0}, "timeout_s"),
        (
            {**GOOD, "fallbacks": ["other"]},
            r"fallbacks: invalid other; valid: rules \(last\)",
        ),
        ({**GOOD, "fallbacks": ["clever"]}, "fallbacks: invalid clever"),
    ],
)
def test_errors_name_valid_values_and_no_keys(table: dict[str, Any], says: str) -> None:
    with pytest.raises(ConfigError, match=says) as caught:
        minds(clever=table)
    assert "sk-secret" not in str(caught.value)


def test_errors_of_robots_name_valid_values() -> None:
    with pytest.raises(ConfigError, match=r"robots\.rex\.fence\.x is not a setting; valid here: x_max_m"):
        parse({"robots": {"rex": {"fence": {"x": 1}}}})
    valid = "board, data, forum, images, journal, mcp, mcp_robot, minds, robots, service, worker"
    with pytest.raises(ConfigError, match=f"robot is not a setting; valid here: {valid}"):
        parse({"robot": {}})


def test_rules_cannot_be_renamed() -> None:
    with pytest.raises(ConfigError, match="built-in mind"):
        minds(rules=GOOD)


@given(st.text(min_size=1, max_size=60))
def test_model_names_are_never_validated(name: str) -> None:
    assert minds(clever={**GOOD, "model": name}).minds["clever"].model == name


def test_a_mind_is_made_by_its_name() -> None:
    config = minds(clever=GOOD)
    assert isinstance(make_mind("clever", config), ModelMind)
    assert isinstance(make_mind("rules", config), RulesMind)
    with pytest.raises(
        ConfigError, match=r"mind 'other' is not installed; installed minds: rules; configured as .*: clever"
    ):
        make_mind("other", config)
