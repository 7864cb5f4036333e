"""HTTP to all forums: timeouts, and which certificates are trusted."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from ipaddress import ip_address
from pathlib import Path

import httpx2
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumLimited, ForumUnreachable
from agentrob.forums import http as wire
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.protocol import Forum
from agentrob.process.tls import tls

THERE = datetime(2031, 5, 6, 7, 8, 9, tzinfo=UTC)


def _answer(retry_after: str | None, date: bool = True) -> httpx2.Response:
    headers = {"retry-after": retry_after} if retry_after is not None else {}
    return httpx2.Response(429, headers={**headers, **({"date": format_datetime(THERE, usegmt=True)} if date else {})})


@pytest.mark.parametrize(
    ("told", "wait_s"),
    [
        ("7", 7.0),
        ("0.5", 0.5),
        ("0", 0.1),
        ("-3", 0.1),
        ("inf", 3600.0),
        ("1e300", 3600.0),
        ("99999999", 3600.0),
        ("nan", 1.0),
        ("soon", 1.0),
        ("", 1.0),
        (None, 1.0),
        ("Tue, 06 May 2031 07:08:51 GMT", 42.0),
        ("Tue, 06 May 2031 07:08:51 -0000", 42.0),
        ("Tue, 06 May 2031 09:08:51 +0200", 42.0),
        ("Tue, 06 May 2031 07:00:00 GMT", 0.1),
        ("Tue, 31 Dec 9999 23:59:59 GMT", 3600.0),
        ("Tue, 99 May 2031 07:08:51 GMT", 1.0),
    ],
)
def test_retry_after_is_a_number_or_a_date_by_the_forums_clock(told: str | None, wait_s: float) -> None:
    assert wire.retry_after_s(_answer(told)) == wait_s


def test_without_the_forums_clock_a_date_is_compared_with_ours() -> None:
    ends = format_datetime(datetime.now(UTC) + timedelta(seconds=60), usegmt=True)
    assert 55 < wire.retry_after_s(_answer(ends, date=False)) <= 60


# ---------------------------------------------------------------------- certificates
@pytest.fixture
def fresh_certificates() -> Iterator[None]:
    """Certificates are cached per process; clear the cache before and after each of these tests."""
    tls.cache_clear()
    yield
    tls.cache_clear()


def _authority(folder: Path) -> Path:
    """Create a self-signed certificate of 127.0.0.1 with its key, in one file."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "a lab's own")])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - timedelta(minutes=1))
        .not_valid_after(now + timedelta(hours=1))
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ip_address("127.0.0.1"))]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(key, hashes.SHA256())
    )
    private = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    path = folder / "lab.pem"
    path.write_bytes(private + made.public_bytes(serialization.Encoding.PEM))
    return path


@asynccontextmanager
async def _limiting(pem: Path) -> AsyncIterator[str]:
    """Run a TLS server that answers every request with "try again later"."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 429 Too Many\r\nRetry-After: 7\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        await writer.drain()
        writer.close()

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(pem)
    server = await asyncio.start_server(serve, "127.0.0.1", 0, ssl=context)
    yield f"https://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    server.close()


@pytest.mark.usefixtures("fresh_certificates")
@pytest.mark.parametrize("kind", [BoardForum, NodeBBForum, DiscourseForum])
async def test_a_self_signed_certificate_named_by_ssl_cert_file_is_trusted(
    kind: Callable[[ForumConfig, str], Forum], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pem = _authority(tmp_path)
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)
    monkeypatch.delenv("SSL_CERT_DIR", raising=False)
    async with _limiting(pem) as url:
        stranger = kind(ForumConfig(url=url), "token")
        with pytest.raises(ForumUnreachable, match=r"(?i)certificate"):
            await stranger.boards()
        await stranger.close()
        tls.cache_clear()
        monkeypatch.setenv("SSL_CERT_FILE", str(pem))
        believed = kind(ForumConfig(url=url), "token")
        with pytest.raises(ForumLimited) as told:
            await believed.boards()
        assert told.value.retry_after_s == 7
        await believed.close()


# ---------------------------------------------------------------------- connections
class _CountingServer:
    """Limits every request of a client; lists the connections, each with the tokens that were sent on it."""

    def __init__(self) -> None:
        self.connections: list[list[str]] = []

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        tokens: list[str] = []
        self.connections.append(tokens)
        while True:
            try:
                head = (await reader.readuntil(b"\r\n\r\n")).decode()
            except asyncio.IncompleteReadError:
                return writer.close()
            tokens += [line.split()[-1] for line in head.splitlines() if line.lower().startswith("authorization:")]
            writer.write(b"HTTP/1.1 429 Too Many\r\nRetry-After: 7\r\nContent-Length: 0\r\n\r\n")


async def test_accounts_of_a_worker_share_connections_and_keep_their_own_tokens() -> None:
    counting = _CountingServer()
    async with await asyncio.start_server(counting.serve, "127.0.0.1", 0) as server:
        settings = ForumConfig(url=f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}")
        async with wire.shared_connections():
            rex, ada = BoardForum(settings, "of-rex"), BoardForum(settings, "of-ada")
            for forum in (rex, ada, rex):
                with pytest.raises(ForumLimited):
                    await forum.boards()
            await rex.close()  # ends nothing of the others
            with pytest.raises(ForumLimited):
                await ada.boards()
            assert counting.connections == [["of-rex", "of-ada", "of-rex", "of-ada"]]
            await ada.close()
        alone = [BoardForum(settings, name) for name in ("one", "two")]
        for forum in alone:
            with pytest.raises(ForumLimited):
                await forum.boards()
            await forum.close()
        assert counting.connections[1:] == [["one"], ["two"]]
