"""Listen addresses: valid ones, invalid ones, and which of them are loopback."""

from __future__ import annotations

import pytest

from agentrob.process.listen import base_url, is_loopback, open_listener, parse_listen


@pytest.mark.parametrize(
    ("listen", "host", "port"),
    [("127.0.0.1:8088", "127.0.0.1", 8088), ("[::1]:0", "::1", 0), ("localhost:65535", "localhost", 65535)],
)
def test_an_address_has_a_host_and_a_port(listen: str, host: str, port: int) -> None:
    assert parse_listen(listen) == (host, port)


@pytest.mark.parametrize(
    "listen", ["", "8088", "127.0.0.1", ":8088", "127.0.0.1:x", "127.0.0.1:65536", "h:1/x", "me@h:1", "[::1", "h:-1"]
)
def test_what_is_not_an_address_is_named_with_an_example(listen: str) -> None:
    with pytest.raises(ValueError, match=r"is not host:port, for example 127\.0\.0\.1:8088"):
        parse_listen(listen)


def test_loopback_addresses_are_recognised() -> None:
    assert all(map(is_loopback, ("127.0.0.1", "127.8.0.1", "::1", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "192.168.1.2", "example.org", "")))


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_port_0_takes_a_free_port_and_the_url_names_it(host: str) -> None:
    with open_listener(host, 0) as listener:
        port = listener.getsockname()[1]
        with pytest.raises(OSError, match="in use"):
            open_listener(host, port)
    assert base_url(host, port) == (f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}")
