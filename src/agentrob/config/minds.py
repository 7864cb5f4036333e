"""The `[minds.NAME]` tables: language models, with their limits and prices.

[minds.clever]                # the key is in the environment
provider = "openai"
model = "gpt-5-mini"
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from agentrob.config.section import Address, Section, Variable


class MindLimitsConfig(Section):
    """The token and cost limits of one mind. 0 disables a limit.

    `command_tokens` and `command_cost` bound one command, `day_tokens` and `day_cost` a UTC day; costs are in the
    currency of its price.
    """

    command_tokens: Annotated[int, Field(ge=0)] = 100_000
    day_tokens: Annotated[int, Field(ge=0)] = 2_000_000
    command_cost: Annotated[float, Field(ge=0)] = 0.0
    day_cost: Annotated[float, Field(ge=0)] = 0.0


class PriceConfig(Section):
    """The price of a million tokens: `input_per_million` and `output_per_million`, in `currency`.

    Costs are computed from this alone; no price list is fetched.
    """

    input_per_million: Annotated[float, Field(ge=0)] = 0.0
    output_per_million: Annotated[float, Field(ge=0)] = 0.0
    currency: str = "USD"


#: The default address and key variable of each provider.
_PROVIDERS = {
    "openai": ("https://api.openai.com/v1", "OPENAI_API_KEY"),
    "anthropic": ("https://api.anthropic.com", "ANTHROPIC_API_KEY"),
    "ark": ("https://ark.cn-beijing.volces.com/api/v3", "ARK_API_KEY"),
    "compatible": ("", ""),
}


#: Defaults for `kind = "local"`. An uncached prompt took 17 s on two cores with llama.cpp.
_LOCAL = {"timeout_s": 60.0, "total_s": 120.0, "concurrency": 1}
#: The maximum total time of a mind and its fallbacks: by default a queued command expires after 600 s, and both a
#: reading and a safety review must fit in that time.
CHAIN_S = 300.0


class MindConfig(Section):
    """One model. The environment variable that `key_env` names holds the key; the key is never in this file.

    `provider` selects the API dialect; `compatible` is any OpenAI-compatible server (Ollama, vLLM, llama.cpp) and
    needs a `base_url`. `answers` selects how typed answers are requested: `tools` by tool calls, `json` in the prompt
    (for weak local models), `json_object` in the prompt with `response_format` and the schema (llama.cpp).
    `model` is the model's name for the provider, unchecked. With `images = false` it is sent no pictures.
    `timeout_s` bounds one attempt, `total_s` one answer with all retries and pauses. `retries` is how often an attempt
    that failed for a temporary reason is repeated, `concurrency` how many questions one process asks at a time,
    `max_output_tokens` the length of one answer. `fallbacks` are other minds, tried
    in order when this one fails; the rules always come last. An agent waits for each of them as long as it is allowed.
    `kind = "local"` is for a slow server of your own (llama.cpp, Ollama): 60 s per attempt and 120 s in total, one
    request at a time, no retry after a timeout, prompts with a common prefix that is cached when the agent starts, and
    streamed answers, so that an abandoned request is not computed to its end.
    `reads`: `unclear` sends only posts that the rules do not understand; with `all`, rules and model must agree.
    """

    @model_validator(mode="before")
    @classmethod
    def _local_times(cls, data: Any) -> Any:
        return {**_LOCAL, **data} if isinstance(data, dict) and data.get("kind") == "local" else data

    provider: Literal["openai", "anthropic", "ark", "compatible"]
    kind: Literal["hosted", "local"] = "hosted"
    reads: Literal["unclear", "all"] = "unclear"
    model: Annotated[str, Field(min_length=1)]
    base_url: Address = ""
    key_env: Variable = ""
    answers: Literal["tools", "json", "json_object"] = "tools"
    images: bool = True
    timeout_s: Annotated[float, Field(gt=0, le=120)] = 15.0
    total_s: Annotated[float, Field(gt=0, le=300)] = 25.0
    retries: Annotated[int, Field(ge=0, le=10)] = 2
    concurrency: Annotated[int, Field(ge=1, le=64)] = 2
    max_output_tokens: Annotated[int, Field(ge=16)] = 2_000
    fallbacks: tuple[str, ...] = ()
    limits: MindLimitsConfig = Field(default_factory=MindLimitsConfig)
    price: PriceConfig | None = None

    @property
    def address(self) -> str:
        """`base_url`, or the provider's default."""
        return self.base_url or _PROVIDERS[self.provider][0]

    @property
    def key_variable(self) -> str:
        """The environment variable of the key: `key_env`, or the provider's default; empty if it needs no key."""
        return self.key_env or _PROVIDERS[self.provider][1]

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if self.provider == "compatible" and not self.base_url:
            raise ValueError('provider "compatible" needs base_url, for example "http://127.0.0.1:11434/v1"')
        if (self.limits.command_cost or self.limits.day_cost) and self.price is None:
            raise ValueError("a cost limit needs a price: input_per_million and output_per_million")
        return self
