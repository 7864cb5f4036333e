"""The only module that uses the model libraries: converts messages and turns errors into `ModelError`. Imported lazily.

It asks once; `model` adds retries, budgets and schemas. The libraries never hold the key (see `http`).
"""

from __future__ import annotations

import socket
import ssl
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import anthropic
import openai
from pydantic_ai import direct, exceptions
from pydantic_ai.messages import (
    BinaryContent,
    ModelMessage,
    ModelRequest,
    ModelResponse,
    TextPart,
    ToolCallPart,
    ToolReturnPart,
    UserPromptPart,
)
from pydantic_ai.models import Model, ModelRequestParameters
from pydantic_ai.models.anthropic import AnthropicModel
from pydantic_ai.models.openai import OpenAIChatModel
from pydantic_ai.profiles.openai import OpenAIModelProfile
from pydantic_ai.providers.anthropic import AnthropicProvider
from pydantic_ai.providers.openai import OpenAIProvider
from pydantic_ai.settings import ModelSettings
from pydantic_ai.tools import ToolDefinition

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.chat import Message, ModelReply, Tool, ToolCall, ToolResult, UserMessage
from agentrob.minds.llm.errors import ErrorKind, ModelError, one_line
from agentrob.minds.llm.http import TooBig, client
from agentrob.minds.llm.tool_calls import schema_of

_NO_KEY = "held-elsewhere"


@dataclass(frozen=True, slots=True)
class ProviderAnswer:
    """One answer as received. `cut`: the model reached the limit of output tokens."""

    text: str
    calls: tuple[tuple[str, str, Any], ...]
    input_tokens: int | None
    output_tokens: int | None
    model: str
    cut: bool


class Provider:
    """One configured model, called through its library."""

    def __init__(self, name: str, config: MindConfig, key: str) -> None:
        self._name = name
        self._config = config
        self._secrets = (key,) if key else ()
        self._url = config.address
        header = {"x-api-key": key} if config.provider == "anthropic" else {"authorization": f"Bearer {key}"}
        self._http = client(self._url, header if key else {}, config.timeout_s)
        self._model = self._anthropic() if config.provider == "anthropic" else self._openai()

    def __repr__(self) -> str:
        return f"Provider({self._name!r}, {self._url!r})"

    async def ask(
        self,
        system_prompt: str,
        conversation: Sequence[Message],
        tools: Sequence[Tool] = (),
        must_call: bool = False,
        json_schema: dict[str, Any] | None = None,
    ) -> ProviderAnswer:
        """Ask once. `json_schema` requests JSON for `answers = "json_object"`. Raises `ModelError`."""
        settings = ModelSettings(max_tokens=self._config.max_output_tokens, timeout=self._config.timeout_s)
        if json_schema is not None:
            settings["extra_body"] = {"response_format": {"type": "json_object", "schema": json_schema}}
        definitions = [_definition(tool, must_call) for tool in tools]
        parameters = ModelRequestParameters(
            function_tools=[] if must_call else definitions,
            output_tools=definitions if must_call else [],
            output_mode="tool" if must_call else "text",
            allow_text_output=not must_call,
        )
        request = self._model, _theirs(conversation, system_prompt)
        try:
            if self._config.kind == "hosted":
                return self._heard(
                    await direct.model_request(*request, model_settings=settings, model_request_parameters=parameters)
                )
            # As a stream, since closing that tells the server to stop computing.
            async with direct.model_request_stream(
                *request, model_settings=settings, model_request_parameters=parameters
            ) as stream:
                async for _ in stream:
                    pass
                return self._heard(stream.get())
        except Exception as e:  # also a library's own surprise at what a server sent: it is that server's fault
            fault = self._fault(e)
        raise fault  # outside of the handlers: a chained traceback would show the library's request

    async def close(self) -> None:
        await self._http.aclose()

    # ------------------------------------------------------------ the two dialects
    def _openai(self) -> Model:
        sdk = openai.AsyncOpenAI(api_key=_NO_KEY, base_url=self._url, max_retries=0, http_client=self._http)
        profile = None
        if self._config.provider != "openai":  # older spellings, which every server knows
            profile = OpenAIModelProfile(
                openai_chat_supports_max_completion_tokens=False, openai_supports_strict_tool_definition=False
            )
        return OpenAIChatModel(self._config.model, provider=OpenAIProvider(openai_client=sdk), profile=profile)

    def _anthropic(self) -> Model:
        url = self._url.removesuffix("/v1")
        sdk = anthropic.AsyncAnthropic(api_key=_NO_KEY, base_url=url, max_retries=0, http_client=self._http)
        return AnthropicModel(self._config.model, provider=AnthropicProvider(anthropic_client=sdk))

    def _heard(self, response: ModelResponse) -> ProviderAnswer:
        calls = tuple((p.tool_call_id, p.tool_name, p.args) for p in response.parts if isinstance(p, ToolCallPart))
        text = "".join(p.content for p in response.parts if isinstance(p, TextPart))
        usage = response.usage
        known = bool(usage.input_tokens or usage.output_tokens)
        return ProviderAnswer(
            text=text,
            calls=calls,
            input_tokens=usage.input_tokens if known else None,
            output_tokens=usage.output_tokens if known else None,
            model=one_line(response.model_name or self._config.model, self._secrets, 80),
            cut=response.finish_reason == "length",
        )

    # ------------------------------------------------------------ their errors
    def _fault(self, error: Exception) -> ModelError:
        status = getattr(error, "status_code", None)
        causes = list(_causes(error))
        retry_after_s = getattr(error, "retry_after", None)
        if isinstance(error, exceptions.ModelHTTPError) and isinstance(status, int):
            return self._by_status(status, error, retry_after_s)
        kind, why = _by_causes(causes)
        return ModelError(kind, f"{self._name}: {why} ({self._url})")

    def _by_status(self, status: int, error: exceptions.ModelHTTPError, retry_after_s: float | None) -> ModelError:
        words = one_line(_message(error.body), self._secrets)
        told = f"; the server says: {words}" if words else ""
        mind, url = self._name, self._url
        if status in (401, 403):
            where = self._config.key_variable
            hint = f"check the key in {where}" if where else "it wants a key: name its variable in key_env"
            return ModelError("denied", f"{mind}: {url} does not accept us (HTTP {status}); {hint}{told}")
        if status == 404:
            hint = f"check base_url and model ({self._config.model!r})"
            if self._config.provider == "compatible" and not url.rstrip("/").endswith("/v1"):
                hint += f'; most servers want base_url = "{url.rstrip("/")}/v1"'
            return ModelError("not_found", f"{mind}: {url} does not know this (HTTP 404); {hint}{told}")
        if status in (402, 429):
            final = status == 402 or isinstance(error, exceptions.ModelQuotaExceededError)
            what = "says that the quota is used up" if final else "wants fewer requests"
            return ModelError("limited", f"{mind}: {url} {what} (HTTP {status}){told}", retry_after_s, final=final)
        if status >= 500:
            return ModelError("server", f"{mind}: {url} failed (HTTP {status}){told}", retry_after_s)
        return ModelError("rejected", f"{mind}: {url} rejects the request (HTTP {status}){told}")


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    for _ in range(20):
        if error is None:
            return
        yield error
        error = error.__cause__ or error.__context__


def _by_causes(causes: Sequence[BaseException]) -> tuple[ErrorKind, str]:
    """Return the stable word and sentence for a transport error."""
    names = " ".join(type(c).__name__ for c in causes)
    if any(isinstance(c, TooBig) for c in causes):
        return "too_big", "the answer is too long to be one"
    if any(isinstance(c, socket.gaierror) for c in causes):
        return "dns", "no such host; check base_url"
    if any(isinstance(c, ssl.SSLError) for c in causes):
        reason = next(c for c in causes if isinstance(c, ssl.SSLError))
        return (
            "tls",
            f"no trusted connection: {one_line(getattr(reason, 'verify_message', '') or reason.reason or reason)}",
        )
    if "Timeout" in names:
        return "timeout", "no answer in time"
    if any(isinstance(c, ConnectionRefusedError) for c in causes) or "ConnectError" in names:
        return "unreachable", "nothing answers there; is the server running?"
    if "RemoteProtocolError" in names or "ReadError" in names:
        return "broken", "the answer broke off"
    if "Connection" in names or "TransportError" in names:
        return "unreachable", "the connection failed"
    return "malformed", "the answer is not in the provider's format; check provider and base_url"


def _message(body: object) -> str:
    """Return the server's message in an error: {"error": {"message": …}} and similar."""
    if isinstance(body, dict):
        inner = body.get("error", body)
        if isinstance(inner, dict):
            return str(inner.get("message", ""))
        return str(inner) if isinstance(inner, str) else str(body.get("message", ""))
    return ""


# ---------------------------------------------------------------------- our messages, their messages
def _definition(tool: Tool, is_output: bool) -> ToolDefinition:
    return ToolDefinition(
        name=tool.name,
        description=tool.description,
        parameters_json_schema=schema_of(tool.arguments),
        kind="output" if is_output else "function",
    )


def _theirs(conversation: Sequence[Message], system_prompt: str) -> list[ModelMessage]:
    found: list[ModelMessage] = []
    for message in conversation:
        if isinstance(message, ModelReply):
            parts = [TextPart(message.text)] if message.text else []
            calls = [ToolCallPart(c.name, _raw(c), c.id) for c in message.calls]
            found.append(ModelResponse(parts=[*parts, *calls]))
            continue
        if not (found and isinstance(found[-1], ModelRequest)):
            found.append(ModelRequest(parts=[], instructions=system_prompt))
        request = found[-1]
        assert isinstance(request, ModelRequest)
        request.parts = [*request.parts, *_parts(message)]
    for request in found:  # what tools returned comes first; pictures, which tool results cannot hold, after it
        if isinstance(request, ModelRequest):
            request.parts = sorted(request.parts, key=lambda p: not isinstance(p, ToolReturnPart))
    return found


def _parts(message: UserMessage | ToolResult) -> list[Any]:
    images = [BinaryContent(data=i.data, media_type=i.media_type) for i in message.images]
    if isinstance(message, UserMessage):
        return [UserPromptPart([message.text, *images] if images else message.text)]
    result = ToolReturnPart(message.call.name, message.content, message.call.id)
    return [result, UserPromptPart([f"Image of {message.call.name}:", *images])] if images else [result]


def _raw(call: ToolCall) -> Any:
    return call.raw if isinstance(call.raw, str | dict) else {}
