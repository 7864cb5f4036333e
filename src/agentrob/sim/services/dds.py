"""Services and topics on DDS for a simulator: one participant per robot's domain, several in one process.

The SDK's own server handles requests one at a time, and its factory allows one domain per process. Here the listener
only decodes a request and passes it on; the answer is sent later, from any thread.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from agentrob.process import dds  # before any IDL type is built

# isort: split
from cyclonedds.core import DDSException
from cyclonedds.domain import Domain
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration
from unitree_sdk2py.idl.unitree_api.msg.dds_ import Request_, Response_, ResponseHeader_, ResponseStatus_

from agentrob.errors import SimError

OK, INTERNAL, NOT_IMPLEMENTED, BAD_PARAMETER = 0, 3202, 3203, 3204
API_VERSION = 1  # every service answers this one with its version

_WAIT = duration(milliseconds=100)
REQUESTS = Qos(Policy.Reliability.Reliable(_WAIT), Policy.History.KeepAll)  # unpaced Moves must not be lost
RESPONSES = Qos(Policy.Reliability.Reliable(_WAIT), Policy.History.KeepLast(16))
STATE = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1))  # never blocks the world


class Node:
    """A participant in one domain on one interface."""

    def __init__(self, domain: int, interface: str) -> None:
        """Raises `SimError` when DDS cannot use the interface."""
        try:
            self._domain = Domain(domain, dds.config(interface))
            self._participant = dds.DomainParticipant(domain)
        except DDSException as e:
            raise SimError(f"DDS cannot use domain {domain} on the interface {interface!r}: {e.msg.strip()}") from None

    def writer(self, topic: str, kind: type, qos: Qos = STATE) -> Any:
        return DataWriter(self._participant, dds.Topic(self._participant, topic, kind), qos=qos)

    def reader(self, topic: str, kind: type, on_sample: Callable[[Any], None]) -> Any:
        """Calls `on_sample` in a DDS thread; it must return at once."""

        def on_data(reader: Any) -> None:
            for sample in reader.take(64):
                if not isinstance(sample, InvalidSample):
                    on_sample(sample)

        listener = dds.Listener(on_data_available=on_data)
        return dds.DataReader(
            self._participant, dds.Topic(self._participant, topic, kind), qos=REQUESTS, listener=listener
        )


@dataclass(frozen=True, slots=True)
class ServiceCall:
    """One decoded request. `answer(code, data, binary)` may be called once, from any thread."""

    api_id: int
    parameter: dict[str, Any]
    answer: Callable[..., None]


class Service:
    """Requests on `rt/api/<name>/request`, handed to `handle` in a DDS thread; `handle` must return at once."""

    def __init__(self, node: Node, name: str, version: str, handle: Callable[[ServiceCall], None]) -> None:
        self._version = version
        self._handle = handle
        self._out = node.writer(f"rt/api/{name}/response", Response_, RESPONSES)
        self._in = node.reader(f"rt/api/{name}/request", Request_, self._on_request)

    def _on_request(self, request: Any) -> None:
        identity, quiet = request.header.identity, request.header.policy.noreply

        def answer(code: int, data: str = "", binary: bytes = b"") -> None:
            if not quiet:
                header = ResponseHeader_(identity, ResponseStatus_(code))
                with contextlib.suppress(DDSException):  # the caller is gone or does not read
                    self._out.write(Response_(header, data, binary))

        if identity.api_id == API_VERSION:
            answer(OK, self._version)
            return
        try:
            parameter = json.loads(request.parameter) if request.parameter else {}
        except ValueError:
            answer(BAD_PARAMETER)
            return
        # The SDK sends [] for an empty binary.
        call = ServiceCall(identity.api_id, parameter if isinstance(parameter, dict) else {}, answer)
        try:
            self._handle(call)
        except Exception:  # a bad request must never end the DDS thread
            answer(INTERNAL)
