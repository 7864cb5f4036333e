"""A typed client of a forum's MCP server: starts or connects to one, and has a method for each tool.

    async with ForumClient.spawn("agentrob", "mcp", "forum") as forum:
        for board in (await forum.list_boards()).boards:
            print(board.name)

It needs only the MCP SDK and pydantic. A tool error raises `ToolFailed` with the envelope's fields; a server that
ended or does not answer raises `ServerUnavailable`, and the next call reconnects. Cancelling a call cancels it at the
server.
"""

from __future__ import annotations

import asyncio
import base64
import json
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar

from pydantic import BaseModel, ValidationError

from agentrob.errors import McpError
from agentrob.mcp import results as r

if TYPE_CHECKING:
    from mcp.client.client import Client

R = TypeVar("R", bound=BaseModel)
#: Timeout of one call.
TIMEOUT_S = 30.0
#: How long a cancelled call or a closing connection may take to end.
LEAVE_S = 5.0
#: Upper bound of `retry_after_s`.
LONGEST_RETRY_S = 3600.0


class ToolFailed(McpError):
    """A tool returned an error. `trace_id` finds the call in the server's log."""

    def __init__(self, code: str, message: str, hint: str = "", retryable: bool = False, trace_id: str = "") -> None:
        super().__init__(f"{message}; {hint}" if hint else message)
        self.code, self.hint, self.retryable, self.trace_id = code, hint, retryable, trace_id
        self.retry_after_s = 1.0


class ServerUnavailable(McpError):
    """The server did not start, ended, or did not answer in time."""


class ForumClient:
    """A connection to a forum's MCP server, opened on first use and again after it broke."""

    def __init__(
        self, connect: Callable[[], Client], *, timeout_s: float = TIMEOUT_S, close: Callable[[], Any] | None = None
    ) -> None:
        """`connect` returns an SDK client that was not entered yet; `spawn` and `connect` provide the usual ones."""
        self._connect = connect
        self._timeout_s = timeout_s
        self._close = close
        self._lock = asyncio.Lock()
        self._connection: _Connection | None = None

    @classmethod
    def spawn(
        cls, command: str, *args: str, env: Mapping[str, str] | None = None, timeout_s: float = TIMEOUT_S
    ) -> Self:
        """Start a server as a child process, which ends when this client is closed. It logs to our standard error."""

        def connect() -> Client:
            from mcp.client.client import Client
            from mcp.client.stdio import StdioServerParameters

            parameters = StdioServerParameters(command=command, args=list(args), env=dict(env) if env else None)
            return Client(parameters, mode="auto", read_timeout_seconds=timeout_s, cache=None)

        return cls(connect, timeout_s=timeout_s)

    @classmethod
    def connect(cls, url: str, token: str, *, timeout_s: float = TIMEOUT_S) -> Self:
        """Connect to a server over HTTP with a bearer token."""
        made: list[Any] = []

        def connect() -> Client:
            import httpx2
            from mcp.client.client import Client
            from mcp.client.streamable_http import streamable_http_client

            from agentrob.process.tls import tls

            http = httpx2.AsyncClient(
                headers={"Authorization": f"Bearer {token}"},
                timeout=httpx2.Timeout(timeout_s, connect=5.0),
                trust_env=False,
                verify=tls(),
            )
            made.append(http)
            transport = streamable_http_client(url, http_client=http)
            return Client(transport, mode="auto", read_timeout_seconds=timeout_s, cache=None)

        async def close() -> None:
            while made:
                await made.pop().aclose()

        return cls(connect, timeout_s=timeout_s, close=close)

    # ---------------------------------------------------------------- life
    async def __aenter__(self) -> Self:
        await self._connected()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connection, and end the server when it is a child process."""
        async with self._lock:
            if self._connection is not None:
                await self._connection.close()
                self._connection = None
            if self._close is not None:
                await self._close()

    async def _connected(self) -> Client:
        async with self._lock:
            if self._connection is not None and self._connection.broken:
                await self._connection.close()
                self._connection = None
            if self._connection is None:
                connection = _Connection(self._connect)
                try:
                    async with asyncio.timeout(self._timeout_s):
                        await connection.open()
                except TimeoutError:
                    await connection.close()
                    raise ServerUnavailable(f"the MCP server was not ready after {self._timeout_s:g} s") from None
                self._connection = connection
            assert self._connection.client is not None
            return self._connection.client

    # ---------------------------------------------------------------- one call
    async def call(self, tool: str, result: type[R], /, **arguments: Any) -> R:
        """Call any tool; arguments that are None are left out. Raises `ToolFailed` and `ServerUnavailable`."""
        given = {k: v for k, v in arguments.items() if v is not None}
        limit_s = self._timeout_s + float(given.get("wait_s", 0))
        client = await self._connected()
        answer = await self._answered(client.call_tool(tool, given, read_timeout_seconds=limit_s), limit_s)
        envelope = answer.structured_content
        if not isinstance(envelope, dict) or not isinstance(envelope.get("ok"), bool):
            raise McpError(f"{tool} did not answer with an envelope")
        if not envelope["ok"]:
            raise _tool_failed(envelope)
        return _read(result, envelope.get("data", {}), tool)

    async def read(self, uri: str, result: type[R], limit_s: float | None = None) -> R:
        """Read a resource that is JSON. Raises `ToolFailed` and `ServerUnavailable`."""
        for content in await self._contents(uri, limit_s):
            if (text := getattr(content, "text", None)) is not None:
                return _read_json(result, text, uri)
        raise McpError(f"{uri} has no text")

    async def read_bytes(self, uri: str) -> bytes:
        """Read a binary resource."""
        for content in await self._contents(uri, None):
            if (blob := getattr(content, "blob", None)) is not None:
                try:
                    return base64.b64decode(blob)
                except ValueError as e:
                    raise McpError(f"{uri} is not base64: {e}") from None
        raise McpError(f"{uri} has no bytes")

    async def _contents(self, uri: str, limit_s: float | None) -> Sequence[Any]:
        client = await self._connected()
        answer = await self._answered(client.read_resource(uri), limit_s or self._timeout_s)
        return list(answer.contents)

    async def _answered(self, asked: Any, limit_s: float) -> Any:
        from mcp.shared.exceptions import MCPError

        connection = self._connection
        asking = asyncio.ensure_future(asked)
        ended = asyncio.ensure_future(connection.ended.wait()) if connection else None
        try:
            async with asyncio.timeout(limit_s):
                await asyncio.wait([t for t in (asking, ended) if t], return_when=asyncio.FIRST_COMPLETED)
                if not asking.done():
                    raise ServerUnavailable("the MCP server ended")
                return asking.result()
        except TimeoutError:
            raise ServerUnavailable(f"the MCP server did not answer within {limit_s:g} s") from None
        except MCPError as e:
            raise _protocol_error(e, connection) from None
        except (OSError, RuntimeError, EOFError, ValidationError) as e:
            raise _unavailable(e, connection) from None
        except Exception as e:
            if type(e).__module__.partition(".")[0] not in ("anyio", "httpx2", "mcp"):
                raise
            raise _unavailable(e, connection) from None
        finally:
            if ended is not None:
                ended.cancel()
            if not await _left(asking, LEAVE_S) and connection is not None:
                connection.broken = True  # it does not even answer a cancellation

    # ---------------------------------------------------------------- the tools
    async def get_manual(self, tool: str | None = None) -> r.Manual:
        return await self.call("get_manual", r.Manual, tool=tool)

    async def list_boards(self, cursor: str | None = None, limit: int | None = None) -> r.Boards:
        return await self.call("list_boards", r.Boards, cursor=cursor, limit=limit)

    async def list_posts(self, board_id: str, cursor: str | None = None, limit: int | None = None) -> r.Topics:
        return await self.call("list_posts", r.Topics, board_id=board_id, cursor=cursor, limit=limit)

    async def get_topic(
        self, topic_id: str, cursor: str | None = None, limit: int | None = None, max_chars: int | None = None
    ) -> r.TopicPosts:
        return await self.call(
            "get_topic", r.TopicPosts, topic_id=topic_id, cursor=cursor, limit=limit, max_chars=max_chars
        )

    async def create_topic(
        self,
        board_id: str,
        title: str,
        body: str,
        *,
        status: str | None = None,
        images: Sequence[str] = (),
        key: str | None = None,
    ) -> r.WrittenPost:
        more = {"status": status, "images": list(images) or None, "key": key}
        return await self.call("create_topic", r.WrittenPost, board_id=board_id, title=title, body=body, **more)

    async def reply_to_topic(
        self,
        topic_id: str,
        body: str,
        *,
        reply_to: str | None = None,
        status: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | None = None,
        key: str | None = None,
    ) -> r.WrittenPost:
        more = {"status": status, "images": list(images) or None, "key": key, "card": dict(card) if card else None}
        return await self.call("reply_to_topic", r.WrittenPost, topic_id=topic_id, body=body, reply_to=reply_to, **more)

    async def edit_post(
        self,
        post_id: str,
        body: str,
        *,
        status: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | None = None,
        key: str | None = None,
    ) -> r.WrittenPost:
        more = {"status": status, "images": list(images) or None, "key": key, "card": dict(card) if card else None}
        return await self.call("edit_post", r.WrittenPost, post_id=post_id, body=body, **more)

    async def login_account(self, account: str, token: str | None = None) -> r.SignedIn:
        return await self.call("login_account", r.SignedIn, account=account, token=token)

    async def register_account(
        self, account: str, kind: str | None = None, display_name: str | None = None
    ) -> r.SignedIn:
        return await self.call("register_account", r.SignedIn, account=account, kind=kind, display_name=display_name)

    async def search_posts(
        self, query: str, board_id: str | None = None, cursor: str | None = None, limit: int | None = None
    ) -> r.Found:
        return await self.call("search_posts", r.Found, query=query, board_id=board_id, cursor=cursor, limit=limit)

    async def upload_media(self, picture: bytes) -> r.Uploaded:
        return await self.call("upload_media", r.Uploaded, data=base64.b64encode(picture).decode())

    async def subscribe_topic(self, topic_id: str, after: str | None = None, wait_s: float = 0.0) -> r.TopicUpdates:
        return await self.call("subscribe_topic", r.TopicUpdates, topic_id=topic_id, after=after, wait_s=wait_s)

    async def list_notifications(self, cursor: str | None = None, limit: int | None = None) -> r.Notifications:
        return await self.call("list_notifications", r.Notifications, cursor=cursor, limit=limit)

    async def manage_permissions(
        self, account: str, role: str | None = None, suspended: bool | None = None
    ) -> r.SignedIn:
        return await self.call("manage_permissions", r.SignedIn, account=account, role=role, suspended=suspended)

    async def updates(self, *uris: str) -> AsyncIterator[str]:
        """Yield the address of each of these resources when it changes (protocol 2026-07-28 only)."""
        client = await self._connected()
        async with client.listen(resource_subscriptions=list(uris)) as events:
            async for event in events:
                if (uri := getattr(event, "uri", None)) is not None:
                    yield str(uri)


class _Connection:
    """An SDK client in a task of its own, since it must be exited in the task that entered it."""

    def __init__(self, connect: Callable[[], Client]) -> None:
        self._connect = connect
        self._leave = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self.client: Client | None = None
        self.ended = asyncio.Event()
        self.broken = False

    async def open(self) -> None:
        ready = asyncio.get_running_loop().create_future()
        self._task = asyncio.create_task(self._run(ready))
        await ready

    async def _run(self, ready: asyncio.Future[None]) -> None:
        try:
            async with self._connect() as client:
                self.client = client
                if not ready.done():
                    ready.set_result(None)
                await self._leave.wait()
        except BaseException as e:
            if not ready.done():
                why = e
                while isinstance(why, BaseExceptionGroup):
                    why = why.exceptions[0]
                error = ServerUnavailable(f"the MCP server cannot be used: {type(why).__name__} {why}".rstrip()[:300])
                ready.set_exception(error)
            if isinstance(e, asyncio.CancelledError):
                raise
        finally:
            self.broken = True
            self.ended.set()

    async def close(self) -> None:
        self._leave.set()
        if self._task is not None:
            await asyncio.wait({self._task}, timeout=LEAVE_S)
            await _left(self._task, LEAVE_S)


async def _left(task: asyncio.Future[Any], limit_s: float) -> bool:
    """Cancel a task and wait up to `limit_s` for its end; return whether it ended. Its exception is ignored."""
    task.add_done_callback(lambda t: t.cancelled() or t.exception())
    if not task.done():
        task.cancel()
        await asyncio.wait({task}, timeout=limit_s)
    return task.done()


def _tool_failed(envelope: dict[str, Any]) -> ToolFailed:
    error = envelope.get("error")
    error = error if isinstance(error, dict) else {}
    failed = ToolFailed(
        str(error.get("code", "internal")),
        str(error.get("message", "")),
        str(error.get("hint", "")),
        bool(error.get("retryable")),
        str(envelope.get("trace_id", "")),
    )
    with suppress(ValueError, TypeError, OverflowError):
        failed.retry_after_s = min(max(0.0, float(error.get("retry_after_s", 1.0))), LONGEST_RETRY_S)
    return failed


def _protocol_error(error: Any, connection: _Connection | None) -> McpError:
    """A JSON-RPC error: our server's carry the envelope's error as data, others mean a broken connection."""
    data = error.error.data
    if isinstance(data, dict) and "code" in data:
        return _tool_failed({"error": {**data, "message": error.error.message}, "trace_id": data.get("trace_id", "")})
    return _unavailable(error, connection)


def _unavailable(error: Exception, connection: _Connection | None) -> ServerUnavailable:
    if connection is not None:
        connection.broken = True
    return ServerUnavailable(f"the MCP server does not answer: {type(error).__name__} {error}".rstrip()[:300])


def _read(result: type[R], data: Any, what: str) -> R:
    try:
        return result.model_validate(data)
    except ValidationError as e:
        raise McpError(f"{what} answered with an unknown result: {e.error_count()} errors") from None
    except Exception as e:
        raise McpError(f"{what} answered with an unreadable result: {e!r}"[:300]) from None


def _read_json(result: type[R], text: str, what: str) -> R:
    """As `_read`, from text. Replaces lone surrogates, which pydantic's JSON parser rejects."""
    try:
        return result.model_validate_json(text)
    except ValidationError:
        pass
    try:
        data = json.loads(text)
        data = json.loads(json.dumps(data, ensure_ascii=False).encode("utf-8", "replace"))
    except (ValueError, RecursionError) as e:
        raise McpError(f"{what} is not JSON: {e!r}"[:300]) from None
    return _read(result, data, what)
