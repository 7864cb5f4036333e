"""The driver's API over TCP: real TLS with real certificates, tokens, and limits against strangers."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import ssl
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, Fenced, LeaseLost, RobotBusy, RobotError, RobotUnreachable
from agentrob.model import EMERGENCY_STOP, FencingToken, Op, Pose, Primitive
from agentrob.robots.driver.admission import STRANGERS_PER_ADDRESS, WRONG, Admission
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.credentials import token_of
from agentrob.robots.driver.network import BODY_BYTES, NetworkListener
from agentrob.robots.driver.stop import halt_robot, stop_all, stop_robot
from tests.robots.driver.network_scene import TOKEN_ENV, Authority, NetworkDrivers
from tests.robots.driver_scene import FAR, NEAR, at_rest, moving, seconds_until

WAYS = ["certificate", "token", "plain"]


@pytest.fixture
def network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[NetworkDrivers]:
    monkeypatch.setenv(TOKEN_ENV, "")  # restored after the test
    started = NetworkDrivers(tmp_path)
    yield started
    started.close()


async def homed(robot: DriverClient) -> Pose:
    """Its home is set as soon as the driver has seen it stand still for a moment."""
    async with asyncio.timeout(60):
        while True:
            with contextlib.suppress(RobotError):
                return await robot.home("owner")
            await asyncio.sleep(0.05)


# ------------------------------------------------------------------ the same API
@pytest.mark.parametrize("way", WAYS)
async def test_a_robot_is_driven_and_stopped_over_the_network_as_over_the_socket(
    network: NetworkDrivers, way: str
) -> None:
    name = network.serve(by=way)
    async with network.remote(name, way) as far, network.client(name) as near:
        assert (await far.capabilities()).model == "fake"
        async with far.lease("agent") as lease:
            result = await far.step(lease, NEAR, 10)
            assert result.ok
            assert 0 < result.started_s <= result.ended_s <= time.monotonic()
            assert (await far.step(lease, Primitive(Op.GET_FRONT_IMAGE), 10)).image
            with pytest.raises(RobotBusy, match="agent"):
                async with near.lease("shell"):
                    pass
            step = asyncio.create_task(far.step(lease, FAR, 60))
            await moving(far)
            stopped = await far.stop("a person")
            assert stopped.confirmed
            assert 0 < stopped.latency_ms < 1000
            assert (await step).reason == "stop"
        await far.halt("owner")
        assert (await near.state()).halted
        lock = await far.release("owner")
        assert lock is not None
        assert lock.why == EMERGENCY_STOP
        assert (await homed(far)).x_m > 0


async def test_law_13_a_stop_from_anywhere_ends_the_step_of_a_client_anywhere(network: NetworkDrivers) -> None:
    name = network.serve()
    settings = network.settings(name)
    async with network.remote(name) as agent, network.remote(name) as other, network.client(name) as near:
        for stop in (other.stop, near.stop):
            async with agent.lease("agent") as lease:
                step = asyncio.create_task(agent.step(lease, FAR, 60))
                await moving(agent)
                assert (await stop("a person")).confirmed
                assert (await step).reason == "stop"
        await asyncio.to_thread(stop_robot, name, settings, "shell")
        results = await asyncio.to_thread(stop_all, "shell", among="no such lock", remote={name: settings})
        assert results[name].confirmed
        await asyncio.to_thread(halt_robot, name, settings, "shell")
        assert (await near.state()).halted
    nobody = network.settings(name, port=1)
    assert isinstance(stop_all("shell", among="no such lock", remote={"gone": nobody})["gone"], RobotUnreachable)


async def test_law_11_a_client_that_disappears_stops_the_robot(network: NetworkDrivers) -> None:
    name = network.serve(options={"faults": {"stop_s": 0.03}})
    async with network.client(name) as near:
        far = network.remote(name)
        held = far.lease("agent")
        lease = await held.__aenter__()
        step = asyncio.create_task(far.step(lease, FAR, 60))
        await moving(near)
        await far.close()
        with contextlib.suppress(RobotError):
            await step
        assert await seconds_until(near, at_rest) <= 1.5


async def test_law_11_over_the_network_a_shared_robot_is_leased_only_with_a_fencing_number(
    network: NetworkDrivers,
) -> None:
    name = network.serve()
    async with network.remote(name) as worker, network.remote(name) as other, network.client(name) as near:
        async with other.lease("without"):
            pass
        await worker.fence(FencingToken("db", 1))
        with pytest.raises(Fenced, match="over the network a lease needs one"):
            async with other.lease("without"):
                pass
        for client in (worker, near):
            async with client.lease("with, or on the robot's machine"):
                pass
        assert (await other.stop("without")).confirmed, "a stop needs none"


# ------------------------------------------------------------------ who gets in
async def test_strangers_are_refused_and_told_why(network: NetworkDrivers, tmp_path: Path) -> None:
    by_certificate, by_token = network.serve(), network.serve(by="token")
    foreign = Authority(tmp_path / "foreign")
    for client in (
        network.remote(by_certificate, **foreign.issue("agent")),  # does not trust the driver
        network.remote(by_certificate, **foreign.issue("agent") | {"driver_ca": network.authority.ca}),
        network.remote(by_certificate, **network.authority.issue("expired", days=-1)),
        network.remote(by_certificate, driver_cert="", driver_key="", driver_token_env=TOKEN_ENV),
        network.remote(by_token, "token", driver_ca=foreign.ca),
    ):
        async with client:
            for call in (client.state(), client.stop("a stranger"), client.lease("a stranger").__aenter__()):
                with pytest.raises(RobotUnreachable, match="trust each other's certificates"):
                    await call


async def test_a_certificate_for_another_host_is_not_trusted(network: NetworkDrivers) -> None:
    name = network.serve()
    wrong = network.listens[name].replace("127.0.0.1", "localhost")
    async with network.remote(name, driver_url=f"https://{wrong}") as client:
        with pytest.raises(RobotUnreachable, match="CERTIFICATE_VERIFY_FAILED"):
            await client.state()


async def test_a_wrong_token_is_refused_and_too_many_close_the_door_but_not_to_who_is_inside(
    network: NetworkDrivers, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = network.serve(by="token")
    async with network.remote(name, "token") as inside:
        await inside.stop("warm up")
        monkeypatch.setenv(TOKEN_ENV, "not-the-token-of-this-driver")
        async with network.remote(name, "token") as stranger:
            with pytest.raises(RobotUnreachable, match="send the driver's token"):
                await stranger.state()
        for _ in range(WRONG.amount):
            async with network.remote(name, "token") as stranger:
                with pytest.raises(RobotUnreachable):
                    await stranger.state()
        async with network.remote(name, "token") as stranger:
            with pytest.raises(RobotUnreachable, match="Error"):  # not even a handshake
                await stranger.state()
        assert (await inside.stop("inside")).confirmed
    async with network.client(name) as near:
        assert (await near.stop("near")).confirmed


async def request(listen: str, head: str, body: bytes = b"") -> bytes:
    """The raw answer to a raw request over plain HTTP."""
    host, port = listen.split(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    writer.write(head.encode() + body)
    try:
        return await asyncio.wait_for(reader.read(2000), 10)
    except ConnectionResetError:
        return b""
    finally:
        writer.close()


async def test_bodies_and_headers_are_limited(network: NetworkDrivers, monkeypatch: pytest.MonkeyPatch) -> None:
    name = network.serve(by="plain")
    listen = network.listens[name]
    bearer = "Authorization: Bearer a-token-of-a-test-0123456789\r\n"
    begin = f"POST /lease HTTP/1.1\r\nHost: x\r\n{bearer}"
    answer = await request(listen, f"{begin}Content-Length: {BODY_BYTES + 1}\r\n\r\n")
    assert b" 413 " in answer
    chunk = b"10000\r\n" + b" " * 0x10000 + b"\r\n"
    answer = await request(listen, f"{begin}Transfer-Encoding: chunked\r\n\r\n", chunk * 2)
    assert b" 422 " in answer
    answer = await request(listen, f"{begin}X-Long: {'x' * 200_000}\r\n\r\n")
    assert b" 400 " in answer
    answer = await request(listen, "POST /stop HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\n{}")
    assert b" 401 " in answer, "a stop over the network needs credentials"


async def test_law_15_a_flood_of_strangers_does_not_delay_a_stop(network: NetworkDrivers) -> None:
    name = network.serve()
    host, port = network.listens[name].split(":")
    ended, tried = asyncio.Event(), 0
    context = ssl.create_default_context(cafile=network.authority.ca)

    async def flood() -> None:
        nonlocal tried
        while not ended.is_set():
            tried += 1
            with contextlib.suppress(OSError, ssl.SSLError, TimeoutError):
                async with asyncio.timeout(2):
                    _, writer = await asyncio.open_connection(host, int(port), ssl=context)
                    writer.close()
            await asyncio.sleep(0)

    async def idle() -> AsyncIterator[None]:
        idle = [socket.create_connection((host, int(port))) for _ in range(STRANGERS_PER_ADDRESS * 2)]
        yield
        for connection in idle:
            connection.close()

    async with network.remote(name) as robot, network.client(name) as near:
        await robot.stop("opens the connections")
        await robot.state()
        floods = [asyncio.create_task(flood()) for _ in range(8)]
        async with contextlib.asynccontextmanager(idle)():
            for client in (robot, near) * 5:
                began_s = time.monotonic()
                assert (await client.stop("a person")).confirmed
                assert time.monotonic() - began_s < 1.0
        ended.set()
        await asyncio.gather(*floods)
    assert tried > 50


def test_admission_bounds_strangers_and_lets_nobody_close_a_trusted_connection() -> None:
    admission = Admission()
    assert admission.admit(("10.0.0.1", 1))
    admission.trust(("10.0.0.1", 1))
    strangers = [("10.0.0.2", port) for port in range(STRANGERS_PER_ADDRESS)]
    assert all(map(admission.admit, strangers))
    assert not admission.admit(("10.0.0.2", 99))
    assert admission.admit(("10.0.0.3", 1)), "another address has places of its own"
    admission.closed(strangers[0])
    assert admission.admit(("10.0.0.2", 99))
    assert admission.trusted(("10.0.0.1", 1))
    assert not admission.trusted(("10.0.0.2", 99))


def test_an_ipv6_network_counts_as_one_address() -> None:
    admission = Admission()
    assert admission.wrong(("2001:db8::1", 1)), "the first is logged"
    for port in range(WRONG.amount):
        assert not admission.wrong((f"2001:db8::{port}", 1))
    assert not admission.admit(("2001:db8::ffff", 2))
    assert admission.admit(("2001:db8:0:1::1", 2))


# ------------------------------------------------------------------ settings
TLS = {"driver_cert": "c", "driver_key": "k"}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"driver_listen": "0.0.0.0:8093"}, "needs TLS: set driver_cert and driver_key"),
        ({"driver_listen": "0.0.0.0:8093", "driver_token_env": "T"}, "needs TLS: set driver_cert and driver_key"),
        ({"driver_listen": "0.0.0.0:8093", **TLS}, "set driver_ca, .* or driver_token_env"),
        ({"driver_listen": "127.0.0.1:8093"}, "without TLS needs driver_token_env"),
        ({"driver_listen": "8093", "driver_token_env": "T"}, "is not host:port"),
        ({"driver_cert": "c"}, "set both or neither"),
        ({"driver_url": "http://192.168.1.20:8093", "driver_token_env": "T"}, "must be https://host:port"),
        ({"driver_url": "https://u:p@h:1", "driver_token_env": "T"}, "must be https://host:port"),
        ({"driver_url": "https://192.168.1.20:8093", "driver_ca": "c"}, "needs driver_token_env, .*, or driver_cert"),
        ({"driver_url": "http://127.0.0.1:8093", **TLS}, "needs driver_token_env"),
    ],
)
def test_settings_that_protect_nothing_are_refused_with_what_is_valid(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        RobotConfig(**settings)


@pytest.mark.parametrize(
    "settings",
    [
        {"driver_listen": "0.0.0.0:8093", **TLS, "driver_ca": "a"},
        {"driver_listen": "[::]:8093", **TLS, "driver_token_env": "T"},
        {"driver_listen": "127.0.0.1:8093", "driver_token_env": "T"},
        {"driver_url": "https://robot.example:8093", **TLS},
        {"driver_url": "http://127.0.0.1:8093", "driver_token_env": "T"},
    ],
)
def test_settings_that_protect_the_driver_are_accepted(settings: dict[str, Any]) -> None:
    RobotConfig(**settings)


def test_files_and_tokens_that_cannot_be_used_are_refused_before_anything_listens(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = Authority(tmp_path).issue("driver")
    torn = tmp_path / "torn.pem"
    torn.write_text("no certificate")
    listen = {"driver_listen": "127.0.0.1:0"}
    for change, message in (
        ({"driver_cert": str(tmp_path / "missing.pem")}, "missing.pem .*No such file"),
        ({"driver_key": str(torn)}, "valid: a PEM certificate and its key"),
        ({"driver_ca": str(torn)}, "valid: PEM certificates"),
    ):
        with pytest.raises(ConfigError, match=message):
            NetworkListener(RobotConfig(**{**listen, **good, **change}))
    monkeypatch.setenv("T", "too short")
    for _ in range(2):
        with pytest.raises(ConfigError, match="T must hold the driver's token, at least 16"):
            token_of(RobotConfig(driver_token_env="T"))
        monkeypatch.delenv("T", raising=False)
    with (
        NetworkListener(RobotConfig(**listen, **good)) as first,
        pytest.raises(RobotBusy, match="Address already in use"),
    ):
        NetworkListener(RobotConfig(**good, driver_listen=first.address))


async def test_a_lease_that_was_lost_while_no_driver_answered_is_reported_after_its_restart(
    network: NetworkDrivers,
) -> None:
    name = network.serve()
    async with network.remote(name) as robot:
        held = robot.lease("agent")
        lease = await held.__aenter__()
        network.processes[0].kill()
        network.processes[0].communicate()
        with pytest.raises(RobotUnreachable):
            await robot.step(lease, NEAR, 10)
        network.serve(name)
        with pytest.raises(LeaseLost):
            await robot.step(lease, NEAR, 10)
        async with robot.lease("agent") as again:
            assert (await robot.step(again, NEAR, 10)).ok
