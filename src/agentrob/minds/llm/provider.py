"""The only module that uses the model libraries: converts messages and turns errors into `ModelError`. Imported lazily.

It asks once, in one of pydantic-ai's output modes; `model` adds retries and budgets. The libraries never hold the key
(see `http`).
"""

from __future__ import annotations

import socket
import ssl
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

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
from pydantic_ai.output import OutputObjectDefinition
from pydantic_ai.profiles.openai import OpenAIModelProfile
from pydantic_ai.providers.anthropic import AnthropicProvider
from pydantic_ai.providers.openai import OpenAIProvider
from pydantic_ai.settings import ModelSettings
from pydantic_ai.tools import ToolDefinition

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.chat import ModelReply, Question, Tool, ToolCall, ToolResult, UserMessage
from agentrob.minds.llm.errors import ErrorKind, ModelError, one_line
from agentrob.minds.llm.http import TooBig, client
from agentrob.minds.llm.tool_calls import schema_of

_NO_KEY = "held-elsewhere"
_PROMPTED_OUTPUT = "Answer with one JSON object and no other words. Its JSON schema:\n{schema}"


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

    async def ask(self, question: Question) -> ProviderAnswer:
        """Ask once. Raises `ModelError`."""
        settings = ModelSettings(max_tokens=self._config.max_output_tokens, timeout=self._config.timeout_s)
        parameters = ModelRequestParameters(function_tools=[_definition(tool) for tool in question.tools])
        if question.output is not None and self._config.answers == "tools":
            parameters.output_mode, parameters.allow_text_output = "tool", False
            parameters.output_tools = [_definition(question.output, "output")]
        elif question.output is not None:
            schema = schema_of(question.output.arguments)
            parameters.output_mode, parameters.prompted_output_template = "prompted", _PROMPTED_OUTPUT
            parameters.output_object = OutputObjectDefinition(schema)
            if self._config.answers == "json_object":  # with the schema, which pydantic-ai does not send here
                settings["extra_body"] = {"response_format": {"type": "json_object", "schema": schema}}
        request = self._model, _to_pydantic(question)
        try:
            if self._config.kind == "hosted":
                return self._parsed(
                    await direct.model_request(*request, model_settings=settings, model_request_parameters=parameters)
                )
            # As a stream, since closing that tells the server to stop computing.
            async with direct.model_request_stream(
                *request, model_settings=settings, model_request_parameters=parameters
            ) as stream:
                async for _ in stream:
                    pass
                return self._parsed(stream.get())
        except Exception as e:  # also a library's own surprise at what a server sent: it is that server's fault
            fault = self._fault(e)
        raise fault  # outside of the handlers: a chained traceback would show the library's request

    async def close(self) -> None:
        await self._http.aclose()

    # ------------------------------------------------------------ the two dialects
    def _openai(self) -> Model:
        sdk = openai.AsyncOpenAI(api_key=_NO_KEY, base_url=self._url, max_retries=0, http_client=self._http)
        profile = OpenAIModelProfile(supports_json_object_output=False)  # only if the configuration asks for it
        if self._config.provider != "openai":  # older spellings and one system message, which every server knows
            profile["openai_chat_supports_multiple_system_messages"] = False
            profile["openai_chat_supports_max_completion_tokens"] = False
            profile["openai_supports_strict_tool_definition"] = False
        return OpenAIChatModel(self._config.model, provider=OpenAIProvider(openai_client=sdk), profile=profile)

    def _anthropic(self) -> Model:
        url = self._url.removesuffix("/v1")
        sdk = anthropic.AsyncAnthropic(api_key=_NO_KEY, base_url=url, max_retries=0, http_client=self._http)
        return AnthropicModel(self._config.model, provider=AnthropicProvider(anthropic_client=sdk))

    def _parsed(self, response: ModelResponse) -> ProviderAnswer:
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
        if isinstance(error, exceptions.ModelHTTPError):
            return self._http_fault(error)
        kind, why = _transport_fault(error)
        return ModelError(kind, f"{self._name}: {why} ({self._url})")

    def _http_fault(self, error: exceptions.ModelHTTPError) -> ModelError:
        status, mind, url = error.status_code, self._name, self._url
        words = one_line(_message(error.body), self._secrets)
        detail = f"; the server says: {words}" if words else ""
        if status in (401, 403):
            where = self._config.key_variable
            hint = f"check the key in {where}" if where else "it wants a key: name its variable in key_env"
            return ModelError("denied", f"{mind}: {url} does not accept us (HTTP {status}); {hint}{detail}")
        if status == 404:
            hint = f"check base_url and model ({self._config.model!r})"
            if self._config.provider == "compatible" and not url.rstrip("/").endswith("/v1"):
                hint += f'; most servers want base_url = "{url.rstrip("/")}/v1"'
            return ModelError("not_found", f"{mind}: {url} does not know this (HTTP 404); {hint}{detail}")
        if status in (402, 429):
            final = isinstance(error, exceptions.ModelQuotaExceededError)
            what = "says that the quota is used up" if final else "wants fewer requests"
            message = f"{mind}: {url} {what} (HTTP {status}){detail}"
            return ModelError("limited", message, error.retry_after, final=final)
        if status >= 500:
            return ModelError("server", f"{mind}: {url} failed (HTTP {status}){detail}", error.retry_after)
        return ModelError("rejected", f"{mind}: {url} rejects the request (HTTP {status}){detail}")


def _transport_fault(error: Exception) -> tuple[ErrorKind, str]:
    """Return the stable word and the sentence for an error without an HTTP status."""
    for cause in _causes(error):
        if isinstance(cause, TooBig):
            return "too_big", "the answer is too long to be one"
        if isinstance(cause, socket.gaierror):
            return "dns", "no such host; check base_url"
        if isinstance(cause, ssl.SSLError):
            reason = getattr(cause, "verify_message", "") or cause.reason or cause
            return "tls", f"no trusted connection: {one_line(reason)}"
    if isinstance(error, exceptions.ModelTimeoutError):
        return "timeout", "no answer in time"
    if isinstance(error, exceptions.ModelConnectionError):
        if error.phase == "connect":
            return "unreachable", "nothing answers there; is the server running?"
        return ("broken", "the answer broke off") if error.phase else ("unreachable", "the connection failed")
    return "malformed", "the answer is not in the provider's format; check provider and base_url"


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    for _ in range(20):
        if error is None:
            return
        yield error
        error = error.__cause__ or error.__context__


def _message(body: object) -> str:
    """Return the server's message in an error: {"error": {"message": …}} and similar."""
    if isinstance(body, dict):
        inner = body.get("error", body)
        if isinstance(inner, dict):
            return str(inner.get("message", ""))
        return str(inner) if isinstance(inner, str) else str(body.get("message", ""))
    return ""


# ---------------------------------------------------------------------- our messages, their messages
def _definition(tool: Tool, kind: Literal["function", "output"] = "function") -> ToolDefinition:
    schema = schema_of(tool.arguments)
    return ToolDefinition(name=tool.name, description=tool.description, parameters_json_schema=schema, kind=kind)


def _to_pydantic(question: Question) -> list[ModelMessage]:
    found: list[ModelMessage] = []
    for message in question.conversation:
        if isinstance(message, ModelReply):
            parts = [TextPart(message.text)] if message.text else []
            calls = [ToolCallPart(c.name, _raw(c), c.id) for c in message.calls]
            found.append(ModelResponse(parts=[*parts, *calls]))
            continue
        if not (found and isinstance(found[-1], ModelRequest)):
            found.append(ModelRequest(parts=[], instructions=question.system_prompt))
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
