"""The client of a robot's driver, as its settings say: on this machine, or on the robot's own computer."""

from __future__ import annotations

from agentrob.config.robots import RobotConfig
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.connection import DriverAddress
from agentrob.robots.driver.credentials import client_tls, token_of


def driver_client(name: str, settings: RobotConfig) -> DriverClient:
    """A client of the driver at `driver_url`, else at its usual Unix socket. Raises `ConfigError` for certificates or a
    token that cannot be used."""
    return DriverClient(name, address=driver_address(settings) if settings.driver_url else None)


def driver_address(settings: RobotConfig) -> DriverAddress:
    """`driver_url` with what it needs. Raises `ConfigError`."""
    url, token = settings.driver_url.rstrip("/"), token_of(settings)
    return DriverAddress(url=url, tls=client_tls(settings, url), token=token)
