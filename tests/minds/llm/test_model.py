"""A configured model against a server that fails in every way: a clear error in time, never with the API key in it."""

from __future__ import annotations

import asyncio
import json
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, ConfigDict, Field

from agentrob.minds.llm.chat import Image, Tool, ToolResult, UserMessage
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.model import ConfiguredModel
from tests.minds.faulty_server import KEY, FaultyServer, anthropic_called, called, said

pytestmark = pytest.mark.usefixtures("model_libraries")

Make = Callable[..., ConfiguredModel]


class Distance(BaseModel):
    model_config = ConfigDict(extra="forbid")
    distance_m: Annotated[float, Field(gt=0, le=5)]


MOVE = Tool("act_move", "Walks forward.", Distance)


def answers(server: FaultyServer, *script: tuple[int, Any] | str, **headers: str) -> None:
    """Script the server's responses in order; the last one is repeated."""
    left = list(script)

    def answer(handler: Any, _: Any) -> None:
        one = left.pop(0) if len(left) > 1 else left[0]
        if isinstance(one, str):
            getattr(handler, one)()
        else:
            status, body = one
            data = body if isinstance(body, bytes) else json.dumps(body).encode()
            handler.send(status, data, **headers if status == 429 else {})

    server.answer = answer


async def fault_of(model: ConfiguredModel) -> ModelError:
    with pytest.raises(ModelError) as caught:
        await model.chat("Be brief.", "Hello")
    await model.close()
    shown = f"{caught.value!r} {''.join(traceback.format_exception(caught.value))} {model!r} {vars(model)}"
    assert KEY not in shown
    return caught.value


async def test_chat_returns_text_and_usage(server: FaultyServer, make: Make) -> None:
    answers(server, (200, said("Good day.")))
    model = make(server.url + "/v1", price={"input_per_million": 1.0, "output_per_million": 10.0})
    answer = await model.chat("Be brief.", "Hello")
    assert answer.value == "Good day."
    (usage,) = answer.usage
    assert (usage.mind, usage.model, usage.input_tokens, usage.output_tokens) == ("clever", "served-model", 100, 20)
    assert usage.cost == pytest.approx(0.0003)
    assert usage.latency_ms > 0
    assert "100 + 20 tokens, 0.0003 USD" in usage.line()
    assert server.paths == ["/v1/chat/completions"]
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    assert [m["role"] for m in server.requests[0]["messages"]] == ["system", "user"]
    await model.close()


async def test_a_key_in_the_environment_for_another_provider_is_not_sent(
    server: FaultyServer, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("OPENAI_API_KEY", "OPENAI_ORG_ID", "OPENAI_PROJECT_ID", "ANTHROPIC_API_KEY", "ANTHROPIC_AUTH_TOKEN"):
        monkeypatch.setenv(name, f"another-{name}")
    answers(server, (200, said("Hello.")))
    model = make(server.url + "/v1", key_env="")
    await model.chat("", "Hello")
    claude = make(server.url, provider="anthropic", name="claude")
    answers(server, (200, anthropic_called("answer", {"distance_m": 1})))
    await claude.answer("", "Hello", Distance)
    sent = json.dumps(server.headers)
    assert "another-" not in sent
    assert "authorization" not in server.headers[0]
    assert server.headers[1]["x-api-key"] == KEY
    await model.close()
    await claude.close()


@pytest.mark.parametrize(
    ("script", "kind", "says", "asked"),
    [
        ([(401, {"error": {"message": f"bad key {KEY}"}})], "denied", "check the key in TEST_KEY", 1),
        ([(403, {"error": "no"})], "denied", "HTTP 403", 1),
        ([(404, {"error": {"message": "no model"}})], "not_found", "check base_url and model", 1),
        ([(400, {"error": {"message": "no tools"}})], "rejected", "no tools", 1),
        ([(302, b"")], "malformed", "check provider and base_url", 1),
        ([(402, {"error": {"message": "pay"}})], "limited", "quota", 1),
        ([(429, {"error": {"message": "slow down"}})], "limited", "fewer requests", 3),
        ([(500, {"error": {"message": "oh"}})], "server", "HTTP 500", 3),
        ([(503, b"<html>")], "server", "HTTP 503", 3),
        (["break_off"], "broken", "broke off", 3),
        ([(200, b"<html>hello</html>")], "malformed", "not in the provider's format", 1),
        ([(200, b'{"choices": [')], "malformed", "not in the provider's format", 1),
        ([(200, {"choices": []})], "malformed", "", 1),
        ([(200, said("  "))], "malformed", "empty answer", 1),
    ],
)
async def test_a_failing_server_is_one_clear_error(
    server: FaultyServer, make: Make, script: list[Any], kind: str, says: str, asked: int
) -> None:
    answers(server, *script, retry_after="0")
    fault = await fault_of(make(server.url + "/v1", retries=2))
    assert fault.kind == kind
    assert says in str(fault)
    assert len(server.requests) == asked
    assert "\n" not in str(fault)
    (usage,) = fault.usage
    assert usage.failed in (kind, "")
    assert usage.attempts == asked


async def test_a_temporary_failure_is_retried(server: FaultyServer, make: Make) -> None:
    answers(server, (500, {}), "break_off", (200, said("At last.")))
    model = make(server.url + "/v1", retries=2)
    answer = await model.chat("", "Hello")
    assert answer.value == "At last."
    assert answer.usage[0].attempts == 3
    await model.close()


async def test_retry_after_is_respected(server: FaultyServer, make: Make) -> None:
    answers(server, (429, {}), (200, said("Now.")), retry_after="1")
    model = make(server.url + "/v1", retries=1)
    began = time.monotonic()
    await model.chat("", "Hello")
    assert time.monotonic() - began >= 1.0
    await model.close()


async def test_a_retry_after_beyond_the_timeout_fails_at_once(server: FaultyServer, make: Make) -> None:
    answers(server, (429, {}), retry_after="3600")
    began = time.monotonic()
    fault = await fault_of(make(server.url + "/v1", retries=5, total_s=30))
    assert fault.kind == "limited"
    assert fault.retry_after_s == 3600
    assert time.monotonic() - began < 10
    assert len(server.requests) == 1


async def test_a_hanging_server_times_out(server: FaultyServer, make: Make) -> None:
    answers(server, "hang")
    began = time.monotonic()
    fault = await fault_of(make(server.url + "/v1", timeout_s=0.3, retries=1))
    assert fault.kind == "timeout"
    assert "0.3 s" in str(fault)
    assert len(server.requests) == 2
    assert time.monotonic() - began < 10


async def test_all_attempts_together_have_a_timeout(server: FaultyServer, make: Make) -> None:
    answers(server, "hang")
    fault = await fault_of(make(server.url + "/v1", timeout_s=60, total_s=0.4, retries=9))
    assert fault.kind == "timeout"
    assert "0.4 s" in str(fault)


async def test_a_response_of_10_mb_is_aborted(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.flood(10_000_000)
    fault = await fault_of(make(server.url + "/v1", retries=2))
    assert fault.kind == "too_big"
    assert len(server.requests) == 1


async def test_a_redirect_is_not_followed(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.send(307, b"", location=f"{server.url}/elsewhere")
    fault = await fault_of(make(server.url + "/v1"))
    assert fault.kind in ("malformed", "rejected")
    assert server.paths == ["/v1/chat/completions"]


async def test_connection_dns_and_tls_errors(server: FaultyServer, make: Make) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"http://127.0.0.1:{free.getsockname()[1]}/v1"
    assert (await fault_of(make(nobody, retries=0))).kind == "unreachable"
    dns = await fault_of(make("http://no-such-host.invalid/v1", retries=5))
    assert dns.kind == "dns"
    assert "check base_url" in str(dns)
    tls = await fault_of(make(server.url.replace("http:", "https:") + "/v1", retries=5))
    assert tls.kind == "tls"


async def test_without_a_key_nothing_is_sent(server: FaultyServer, make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("TEST_KEY")
    fault = await fault_of(make(server.url + "/v1"))
    assert fault.kind == "no_key"
    assert "TEST_KEY must hold the key" in str(fault)
    assert server.requests == []


@pytest.mark.parametrize("raw", ['{"distance_m": 2', "[1, 2]", {"distance_m": 50}, {"distance_m": "nan"}, {"far": 2}])
async def test_typed_output_is_valid_or_an_error(server: FaultyServer, make: Make, raw: Any) -> None:
    answers(server, (200, called("answer", raw)))
    model = make(server.url + "/v1")
    with pytest.raises(ModelError, match="no usable answer") as caught:
        await model.answer("", "How far?", Distance)
    assert caught.value.kind == "malformed"
    assert len(server.requests) == 2, "it is told once what is wrong"
    assert len(caught.value.usage) == 2
    await model.close()


async def test_invalid_output_may_be_corrected(server: FaultyServer, make: Make) -> None:
    answers(server, (200, called("answer", {"distance_m": 50})), (200, called("answer", {"distance_m": 5})))
    model = make(server.url + "/v1")
    answer = await model.answer("", "How far?", Distance)
    assert answer.value == Distance(distance_m=5)
    assert "less than or equal to 5" in json.dumps(server.requests[1])
    assert len(answer.usage) == 2
    await model.close()


@pytest.mark.parametrize("mode", ["json", "json_object"])
async def test_prompted_json_for_models_without_tools(server: FaultyServer, make: Make, mode: str) -> None:
    answers(server, (200, said('Sure! ```json\n{"distance_m": 2.5}\n``` Anything else?')))
    model = make(server.url + "/v1", answers=mode)
    assert (await model.answer("Read.", "How far?", Distance)).value == Distance(distance_m=2.5)
    (request,) = server.requests
    assert "tools" not in request
    assert '"distance_m"' in request["messages"][0]["content"]
    assert ("response_format" in request) is (mode == "json_object")
    await model.close()


async def test_prompted_tools(server: FaultyServer, make: Make) -> None:
    answers(server, (200, said('{"tool": "act_move", "arguments": {"distance_m": 1}}')), (200, said("I walked.")))
    model = make(server.url + "/v1", answers="json")
    talk: list[Any] = [UserMessage("Walk 1 m.")]
    first = await model.turn("You drive a robot.", talk, [MOVE])
    (call,) = first.value.calls
    assert call.arguments == Distance(distance_m=1)
    talk += [first.value, ToolResult(call, "measured 0.98 m")]
    assert (await model.turn("You drive a robot.", talk, [MOVE])).value.text == "I walked."
    assert "measured 0.98 m" in server.requests[1]["messages"][-1]["content"]
    await model.close()


async def test_invalid_tool_calls_are_returned_with_the_problem(server: FaultyServer, make: Make) -> None:
    model = make(server.url + "/v1")
    answers(server, (200, called("act_explode", {})))
    (call,) = (await model.turn("", [UserMessage("Go.")], [MOVE])).value.calls
    assert call.arguments is None
    assert call.problem == "There is no tool act_explode. Valid: act_move."
    answers(server, (200, called("act_move", {"distance_m": 500})))
    (call,) = (await model.turn("", [UserMessage("Go.")], [MOVE])).value.calls
    assert call.arguments is None
    assert "distance_m: Input should be less than or equal to 5" in call.problem
    answers(server, (200, called("act_move", "{" * 5000)))
    (call,) = (await model.turn("", [UserMessage("Go.")], [MOVE])).value.calls
    assert call.problem == "This is not a JSON object."
    await model.close()


async def test_pictures_are_sent_inline_also_as_results(server: FaultyServer, make: Make) -> None:
    answers(server, (200, called("act_move", {"distance_m": 1})), (200, said("A red ball.")))
    model = make(server.url + "/v1")
    talk: list[Any] = [UserMessage("Look.", (Image(b"\xff\xd8\xff"),))]
    first = await model.turn("", talk, [MOVE])
    talk += [first.value, ToolResult(first.value.calls[0], "done", (Image(b"\xff\xd8\xfe"),))]
    assert (await model.turn("", talk, [MOVE])).value.text == "A red ball."
    sent = json.dumps(server.requests[1])
    assert "data:image/jpeg;base64,/9j/" in sent
    assert "data:image/jpeg;base64,/9j+" in sent
    assert [m["role"] for m in server.requests[1]["messages"][-3:]] == ["assistant", "tool", "user"]
    await model.close()


async def test_a_mind_without_vision_gets_no_picture(server: FaultyServer, make: Make) -> None:
    model = make(server.url + "/v1", images=False)
    with pytest.raises(ModelError, match="takes no images"):
        await model.answer("", "What is this?", Distance, images=[Image(b"\xff\xd8\xff")])
    assert server.requests == []


async def test_truncated_output_is_an_error(server: FaultyServer, make: Make) -> None:
    answers(server, (200, said("I would walk and", finish="length")))
    model = make(server.url + "/v1")
    with pytest.raises(ModelError, match="max_output_tokens"):
        await model.turn("", [UserMessage("Go.")], [MOVE])
    await model.close()


@pytest.mark.parametrize(("concurrency", "overlaps"), [(1, False), (2, True)])
async def test_concurrent_requests_are_limited(
    server: FaultyServer, make: Make, concurrency: int, overlaps: bool
) -> None:
    active, both = threading.Semaphore(1), threading.Event()

    def answer(handler: Any, _: Any) -> None:
        alone = active.acquire(blocking=False)
        if not alone:
            both.set()
        both.wait(0.3 if concurrency == 1 else 20)  # another one may arrive while this one is being answered
        if alone:
            active.release()
        handler.send(200, json.dumps(said("Hello.")).encode())

    server.answer = answer
    model = make(server.url + "/v1", concurrency=concurrency, timeout_s=60, total_s=60)
    await asyncio.gather(*(model.chat("", "Hello") for _ in range(3)))
    assert both.is_set() is overlaps
    assert len(server.requests) == 3
    await model.close()


async def test_without_tools_text_that_looks_like_a_call_is_text(server: FaultyServer, make: Make) -> None:
    answers(server, (200, said('{"tool": "act_move", "arguments": {}}')))
    model = make(server.url + "/v1", answers="json")
    reply = (await model.turn("", [UserMessage("Hello")], [])).value
    assert reply.calls == ()
    assert reply.text.startswith('{"tool"')
    await model.close()


async def test_a_request_can_be_cancelled(server: FaultyServer, make: Make) -> None:
    answers(server, "hang")
    model = make(server.url + "/v1", timeout_s=60, total_s=60)
    thinking = asyncio.ensure_future(model.chat("", "Hello"))
    await asyncio.to_thread(server.came.wait, 20)
    began = time.monotonic()
    thinking.cancel()
    with pytest.raises(asyncio.CancelledError):
        await thinking
    assert time.monotonic() - began < 5
    await model.close()


async def test_law_15_the_library_is_imported_on_another_thread(
    server: FaultyServer, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The import takes a second or more, and a stop that arrives meanwhile must not wait."""
    threads: list[threading.Thread] = []
    from agentrob.minds.llm import provider

    made = provider.Provider.__init__

    def note(self: provider.Provider, *args: Any) -> None:
        threads.append(threading.current_thread())
        made(self, *args)

    monkeypatch.setattr(provider.Provider, "__init__", note)
    answers(server, (200, said("Hello.")))
    model = make(server.url + "/v1")
    await asyncio.gather(model.chat("", "Hello"), model.chat("", "Hello"))
    (thread,) = threads
    assert thread is not threading.main_thread()
    await model.close()


async def test_correcting_output_counts_towards_the_timeout(server: FaultyServer, make: Make) -> None:
    answers(server, (200, called("answer", {"far": 1})), "hang")
    model = make(server.url + "/v1", timeout_s=60, total_s=1.5, retries=3)
    began = time.monotonic()
    with pytest.raises(ModelError) as caught:
        await model.answer("", "How far?", Distance)
    assert caught.value.kind == "timeout"
    assert [u.failed for u in caught.value.usage] == ["", "timeout"]
    assert time.monotonic() - began < 10
    await model.close()


async def test_without_the_libraries_it_says_what_to_install(
    server: FaultyServer, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "agentrob.minds.llm.provider", None)
    fault = await fault_of(make(server.url + "/v1"))
    assert fault.kind == "no_library"
    assert "agentrob[models]" in str(fault)
