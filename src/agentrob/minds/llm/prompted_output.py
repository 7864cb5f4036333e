"""Typed answers and tools for models that support neither: requested in the prompt, parsed from the text. Pure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel, ConfigDict

from agentrob.minds.llm.chat import Message, ModelReply, Tool, ToolResult, UserMessage
from agentrob.minds.llm.tool_calls import checked_call, found_in, schema_of


class _Asked(BaseModel):
    model_config = ConfigDict(extra="ignore")

    tool: str
    arguments: dict[str, Any] = {}


def with_schema(system_prompt: str, kind: type[BaseModel]) -> str:
    """Return a system prompt that asks for one JSON object and nothing else."""
    schema = json.dumps(schema_of(kind), ensure_ascii=False)
    return f"{system_prompt}\n\nAnswer with one JSON object and no other words. Its JSON schema:\n{schema}\n"


def with_tools(system_prompt: str, tools: Sequence[Tool]) -> str:
    """Return a system prompt that describes the tools and how to call one."""
    lines = [f"- {t.name}: {t.description} Arguments: {json.dumps(schema_of(t.arguments))}" for t in tools]
    return "\n".join(
        [
            system_prompt,
            "",
            "You have these tools:",
            *lines,
            'To use one, answer only with {"tool": "its name", "arguments": {…}}; its result is the next message.',
            "To end, answer in plain words without JSON.",
        ]
    )


def without_tools(conversation: Sequence[Message]) -> list[Message]:
    """Return the conversation as text: calls as JSON, results as our messages."""
    words: list[Message] = []
    for message in conversation:
        if isinstance(message, ModelReply):
            calls = [json.dumps({"tool": c.name, "arguments": _data(c.raw)}, ensure_ascii=False) for c in message.calls]
            words.append(ModelReply("\n".join([message.text, *calls] if message.text else calls)))
        elif isinstance(message, ToolResult):
            words.append(UserMessage(f"Result of {message.call.name}: {message.content}", message.images))
        else:
            words.append(message)
    return words


def reply_in(text: str, number: int, tools: Sequence[Tool]) -> ModelReply:
    """Parse a text into at most one tool call, or plain words. `number` makes the call's id."""
    asked, _ = found_in(text, _Asked)
    if asked is None or not tools:
        return ModelReply(text.strip())
    return ModelReply("", (checked_call(f"call_{number}", asked.tool, asked.arguments, tools),))


def _data(raw: Any) -> Any:
    if isinstance(raw, str):
        try:
            return json.loads(raw)
        except (ValueError, RecursionError):
            return {}
    return raw
