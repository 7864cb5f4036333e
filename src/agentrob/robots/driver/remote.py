"""The client of a robot's driver, as its settings say: on this machine, or on the robot's own computer."""

from __future__ import annotations

import ssl

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.connection import DriverAddress
from agentrob.robots.driver.credentials import load_certificates, token_of


def driver_client(name: str, settings: RobotConfig) -> DriverClient:
    """A client of the driver at `driver_url`, else at its usual Unix socket. Raises `ConfigError` for certificates or a
    token that cannot be used."""
    return DriverClient(name, address=driver_address(settings) if settings.driver_url else None)


def driver_address(settings: RobotConfig) -> DriverAddress:
    """`driver_url` with what it needs. Raises `ConfigError`."""
    url, token = settings.driver_url.rstrip("/"), token_of(settings)
    if url.startswith("http:"):
        return DriverAddress(url=url, token=token)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    load_certificates(context, settings)
    if not settings.driver_ca:
        context.load_default_certs()
    if not (token or settings.driver_cert):
        raise ConfigError("driver_url needs a certificate or a token for this machine")
    return DriverAddress(url=url, tls=context, token=token)
