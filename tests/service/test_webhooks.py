"""Webhooks in and out: signed, used only as a hint, retried, and limited in number."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import pytest

from agentrob.errors import ConfigError, ServiceError
from agentrob.process.webhooks import MOST_WAITING, Outbox, Receiver, read_secret, signer
from agentrob.service.metrics import ServiceMetrics
from agentrob.service.webhooks import verify
from tests.agent.agent_scene import Driver
from tests.service.service_scene import Service, make_service
from tests.waiting import until

TIME_SCALE = 3
SECRET = "a-secret-of-the-two"


def discourse(body: bytes, secret: str = SECRET) -> dict[str, str]:
    signed = hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
    return {"X-Discourse-Event-Signature": f"sha256={signed}", "X-Discourse-Event": "post_created"}


def standard(body: bytes, secret: str = SECRET, sent_s: float | None = None) -> dict[str, str]:
    sent = datetime.fromtimestamp(int(time.time() if sent_s is None else sent_s), UTC)
    signed = signer(secret).sign("msg_1", sent, body.decode())
    return {"webhook-id": "msg_1", "webhook-timestamp": f"{sent.timestamp():.0f}", "webhook-signature": signed}


def test_the_signature_matches_the_standards_example() -> None:
    """The example is a test vector of the Standard Webhooks libraries."""
    secret, body = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", '{"test": 2432232314}'
    found = signer(secret).sign("msg_p5jXN8AQM9LWM0D4loKWxJek", datetime.fromtimestamp(1614265330, UTC), body)
    assert found == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


def test_a_secret_without_whsec_is_the_raw_key() -> None:
    signed = hmac.new(SECRET.encode(), b'msg_1.1614265330.{"a":"\xc3\xa9"}', hashlib.sha256).digest()
    found = signer(SECRET).sign("msg_1", datetime.fromtimestamp(1614265330, UTC), '{"a":"é"}')
    assert found == f"v1,{base64.b64encode(signed).decode()}"


@pytest.mark.parametrize("secret", ["whsec_", "whsec_a", "whsec_!!!"])
def test_a_secret_with_whsec_must_be_base64(secret: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOOK_SECRET", secret)
    with pytest.raises(ConfigError, match="the rest must be base64"):
        read_secret("HOOK_SECRET")


@dataclass
class Listener:
    """A receiver of webhooks that returns the given statuses in order, and the last one from then on."""

    answers: list[int]
    got: list[tuple[dict[str, str], bytes]] = field(default_factory=list)
    url: str = ""

    async def until(self, count: int) -> None:
        await until(lambda: len(self.got) >= count)

    async def handle(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode().split("\r\n")[1:-2]
        headers = {k.lower(): v for k, v in (line.split(": ", 1) for line in head)}
        body = await reader.readexactly(int(headers["content-length"]))
        self.got.append((headers, body))
        status = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        writer.write(f"HTTP/1.1 {status} x\r\nContent-Length: 0\r\nConnection: close\r\n\r\n".encode())
        await writer.drain()
        writer.close()


@asynccontextmanager
async def listener(*answers: int) -> AsyncIterator[Listener]:
    made = Listener(list(answers))
    server = await asyncio.start_server(made.handle, "127.0.0.1", 0)
    made.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/ended"
    async with server:
        yield made


async def test_the_end_of_a_command_is_sent_signed_and_retried_until_accepted(driver: Driver, tmp_path: Path) -> None:
    async with listener(503, 200) as told:
        receivers = (Receiver("planner", told.url, SECRET),)
        async with make_service(driver, tmp_path, receivers=receivers) as service:
            command = await service.submit("alice", "turn left 20 degrees")
            await service.end(command)
            await told.until(2)
    (first, body), (second, again) = told.got
    assert body == again
    assert first["webhook-id"] == second["webhook-id"]
    verify("standard", body, second, SECRET)
    said = json.loads(body)
    assert (said["type"], said["data"]["id"], said["data"]["state"]) == ("command.ended", command["id"], "done")
    assert said["data"]["results"][0]["measured"]["degrees"] == pytest.approx(20, abs=5)


async def test_retries_are_limited_and_do_not_delay_other_receivers() -> None:
    async with listener(500) as broken, listener(200) as good, listener(400) as unwilling:
        receivers = [Receiver(name, at.url, SECRET) for name, at in (("a", broken), ("b", good), ("c", unwilling))]
        metrics = ServiceMetrics("r")
        outbox = Outbox(receivers, metrics.webhook_delivered, pauses_s=(0.01, 0.01))
        running = asyncio.create_task(outbox.run())
        outbox.send("command.ended", {"id": "1"})
        async with asyncio.timeout(60):
            await asyncio.gather(*(receiver.waiting.join() for receiver in receivers))
        running.cancel()
        assert (len(broken.got), len(good.got), len(unwilling.got)) == (3, 1, 1)
    text = metrics.text().decode()
    assert 'outcome="failed",robot="r"} 2.0' in text
    assert 'outcome="delivered",robot="r"} 1.0' in text


def test_the_queue_of_a_receiver_is_bounded() -> None:
    receiver, metrics = Receiver("a", "http://127.0.0.1:1/", SECRET), ServiceMetrics("r")
    outbox = Outbox([receiver], metrics.webhook_delivered)
    for n in range(MOST_WAITING + 3):
        outbox.send("command.ended", {"id": str(n)})
    assert receiver.waiting.qsize() == MOST_WAITING
    assert 'outcome="dropped",robot="r"} 3.0' in metrics.text().decode()


def test_a_webhook_without_our_signature_is_refused() -> None:
    body = b'{"post": {"id": 5}}'
    verify("discourse", body, {k.lower(): v for k, v in discourse(body).items()}, SECRET)
    verify("standard", body, standard(body), SECRET)
    wrong = [
        ("discourse", {}), ("discourse", discourse(body, "other")), ("discourse", discourse(body + b" ")),
        ("discourse", {"X-Discourse-Event-Signature": "sha256=ä"}),
        ("discourse", {"X-Discourse-Event-Signature": discourse(body)["X-Discourse-Event-Signature"][7:]}),
        ("discourse", standard(body)), ("standard", {}), ("standard", standard(body, "other")),
        ("standard", standard(body + b" ")), ("standard", standard(body, sent_s=time.time() - 3600)),
        ("standard", {**standard(body), "webhook-id": "msg_2"}),
        ("standard", {**standard(body), "webhook-signature": "é"}),
    ]  # fmt: skip
    for kind, headers in wrong:
        with pytest.raises(ServiceError) as refused:
            verify(kind, body, {k.lower(): v for k, v in headers.items()}, SECRET)
        assert refused.value.status == 401
    with pytest.raises(ServiceError):
        verify("discourse", body, {k.lower(): v for k, v in discourse(body, "").items()}, "")


async def test_a_webhook_wakes_an_agent_that_does_not_poll(driver: Driver, tmp_path: Path) -> None:
    hooks = {"forum": ("discourse", SECRET), "board": ("standard", SECRET)}
    async with make_service(driver, tmp_path, hooks_in=hooks, listens=False) as service:
        first = await service.scene.post("alice", "@quadruped turn left 10 degrees")
        second = await service.scene.post("alice", "@quadruped turn right 10 degrees")
        assert not service.scene.replies(first)
        forged = b'{"post": {"id": 999, "raw": "@quadruped walk forward 5 m", "username": "alice"}}'
        url = f"{service.url}/api/v1/hooks/forum"
        assert (await service.http.post(url, content=forged, headers=discourse(forged, "other"))).status_code == 401
        assert (await service.http.post(f"{service.url}/api/v1/hooks/nobody", content=b"")).status_code == 404
        before_m = await service.x_m()
        assert (await service.http.post(url, content=forged, headers=discourse(forged))).status_code == 202
        for post in (first, second):
            card = (await service.scene.final(post)).card
            assert card is not None
            assert card.state == "done"
        assert await service.x_m() == pytest.approx(before_m, abs=0.02)  # the agent ignored the content of the webhook
        third = await service.scene.post("alice", "@quadruped turn left 10 degrees")
        body = b"{}"
        answer = await service.http.post(f"{service.url}/api/v1/hooks/board", content=body, headers=standard(body))
        assert answer.status_code == 202
        await service.scene.final(third)


async def test_law_16_an_agent_woken_by_webhooks_polls_while_its_robot_moves(driver: Driver, tmp_path: Path) -> None:
    async with make_service(driver, tmp_path, listens=False) as service:
        command = await service.submit("alice", "walk forward 5 m")
        await service.moving(command)
        stop = await service.scene.post("bob", "@quadruped stop")
        ended = await service.end(command)
        assert (ended["state"], ended["stopped_by"]) == ("stopped", "bob")
        assert stop.created_at is not None


async def test_a_scan_reports_that_the_forum_does_not_answer(
    driver: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.service.commands.SCAN_S", 0.3)
    async with make_service(driver, tmp_path, listens=False) as service:
        assert (await scanned(service))["heard"]
        service.scene.world.reachable = False
        assert not (await scanned(service))["heard"]
        service.scene.world.reachable = True


async def scanned(service: Service) -> dict[str, bool]:
    found: dict[str, bool] = (await service.call("alice", "POST", "/scan")).json()
    return found
