"""The zones of a room over HTTP: `POST /zones/{room}/{call}` of the driver that keeps them, and its client."""

from __future__ import annotations

import math
import ssl
from collections.abc import Callable
from typing import Any

import httpx2
from pydantic import TypeAdapter, ValidationError
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.routing import Route

from agentrob.errors import RobotError, RobotUnreachable
from agentrob.robots.codec import display_name
from agentrob.robots.zones.area import Area
from agentrob.robots.zones.keeper import ZoneKeeper
from agentrob.robots.zones.ledger import (
    Answer,
    LeaseGone,
    Message,
    OldSession,
    Other,
    Place,
    StillHeard,
    ZoneLease,
)

#: A report that takes longer is of no use: the next one is due.
CALL_S = 1.0
_MESSAGE, _PLACE, _AREA = TypeAdapter(Message), TypeAdapter(Place), TypeAdapter(Area)
_ANSWER, _OTHERS, _LEASE = TypeAdapter(Answer), TypeAdapter(list[Other]), TypeAdapter(ZoneLease | None)
_REFUSALS = {"old_session": OldSession, "lease_gone": LeaseGone, "still_heard": StillHeard}


# ---------------------------------------------------------------------- the side that keeps the room
def zone_routes(room: str, keeper: ZoneKeeper) -> list[Route]:
    """The routes of the driver that keeps a room."""
    calls: dict[str, Callable[[dict[str, Any]], Any]] = {
        "hello": lambda data: keeper.hello(_name(data["robot"])),
        "take": lambda data: _shown(_ANSWER, keeper.take(
            _MESSAGE.validate_python(data["message"]), _place(data["place"]), _area(data["area"]), _name(data["doing"])
        )),
        "report": lambda data: _shown(_OTHERS, keeper.report(
            _MESSAGE.validate_python(data["message"]), int(data["lease"]), _place(data["place"]),
            at_rest=data["at_rest"] is True,
        )),
        "release": lambda data: _shown(_LEASE, keeper.release(_name(data["robot"]))),
        "members": lambda _: _members(keeper),
    }  # fmt: skip

    async def serve(request: Request) -> JSONResponse:
        name, call = request.path_params["room"], calls.get(request.path_params["call"])
        if call is None or name != room:
            return _problem(422, "invalid", f"this driver keeps the room {room!r}; valid calls: {', '.join(calls)}")
        try:
            data = await request.json()
            return JSONResponse({"answer": await run_in_threadpool(call, data)})
        except tuple(_REFUSALS.values()) as e:
            return _problem(409, next(code for code, kind in _REFUSALS.items() if isinstance(e, kind)), "")
        except RobotUnreachable as e:
            return _problem(503, "unavailable", str(e))
        except (ValueError, TypeError, KeyError) as e:
            return _problem(422, "invalid", f"{type(e).__name__}: {display_name(str(e))}")

    return [Route("/zones/{room}/{call}", serve, methods=["POST"])]


def _problem(status: int, code: str, detail: str) -> JSONResponse:
    return JSONResponse({"status": status, "code": code, "detail": detail}, status)


def _members(keeper: ZoneKeeper) -> Any:
    members, waiting = keeper.members()
    return {"members": _shown(_OTHERS, members), "waiting": waiting}


def _shown(adapter: TypeAdapter[Any], value: Any) -> Any:
    """As JSON: infinity becomes null."""
    return adapter.dump_python(value, mode="json")


def _name(text: Any) -> str:
    if not isinstance(text, str) or not text or text != display_name(text):
        raise ValueError(f"not a name: {text!r}")
    return text


def _place(data: Any) -> Place:
    place = _PLACE.validate_python(data)
    _finite(place.error_m, *((place.pose.x_m, place.pose.y_m, place.pose.yaw_rad) if place.pose else ()))
    return place


def _area(data: Any) -> Area:
    area: Area = _AREA.validate_python(None if data is None else [tuple(capsule) for capsule in data])
    _finite(*(number for capsule in area or () for number in capsule))
    if area == ():
        raise ValueError("an area has at least one capsule")
    return area


def _finite(*numbers: float) -> None:
    if not all(map(math.isfinite, numbers)):
        raise ValueError("a number is not finite")


# ---------------------------------------------------------------------- the other side
class RemoteKeeper:
    """The zones of a room that the driver at `url` keeps; see `ZoneKeeper`. Thread-safe."""

    def __init__(self, room: str, url: str, tls: ssl.SSLContext | None = None, token: str = "") -> None:
        self.room, self.url = room, url.rstrip("/")
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._http = httpx2.Client(
            base_url=self.url, verify=tls or False, headers=headers, timeout=CALL_S, trust_env=False
        )

    def hello(self, robot: str) -> int:
        return int(self._call("hello", {"robot": robot}))

    def take(self, message: Message, place: Place, area: Area, doing: str) -> Answer:
        body = {"message": message, "place": _shown(_PLACE, place), "area": area, "doing": doing}
        return _read(_ANSWER, _silence(self._call("take", body)))  # type: ignore[no-any-return]

    def report(self, message: Message, lease: int, place: Place, *, at_rest: bool) -> list[Other]:
        body = {"message": message, "lease": lease, "place": _shown(_PLACE, place), "at_rest": at_rest}
        return _read(_OTHERS, [_silence(other) for other in self._call("report", body)])  # type: ignore[no-any-return]

    def release(self, robot: str) -> ZoneLease | None:
        return _read(_LEASE, self._call("release", {"robot": robot}))  # type: ignore[no-any-return]

    def members(self) -> tuple[list[Other], list[str]]:
        found = self._call("members", {})
        return _read(_OTHERS, [_silence(other) for other in found["members"]]), [str(r) for r in found["waiting"]]

    def close(self) -> None:
        self._http.close()

    def _call(self, call: str, body: dict[str, Any]) -> Any:
        try:
            answer = self._http.post(f"/zones/{self.room}/{call}", json=body)
            data = answer.json()
            if answer.is_success:
                return data["answer"]
            code, detail = str(data.get("code")), str(data.get("detail"))
        except (httpx2.HTTPError, OSError, RuntimeError) as e:
            raise RobotUnreachable(f"the driver at {self.url} that keeps the room does not answer ({e!r})") from None
        except (ValueError, KeyError, AttributeError):
            raise RobotUnreachable(f"the answer of {self.url} cannot be read; is it an AgentRob driver?") from None
        if code in _REFUSALS:
            raise _REFUSALS[code]
        raise RobotUnreachable(f"the driver at {self.url} does not keep the room for us: {display_name(detail)}")


def _silence(data: Any) -> Any:
    """JSON knows no infinity: a driver that was never heard."""
    known = isinstance(data, dict) and data.get("silent_s") is not None
    return data if known or not isinstance(data, dict) else {**data, "silent_s": math.inf}


def _read(adapter: TypeAdapter[Any], data: Any) -> Any:
    try:
        return adapter.validate_python(data)
    except ValidationError:
        raise RobotError("an answer about the room cannot be read") from None
