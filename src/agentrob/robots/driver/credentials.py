"""The certificates and the token by which a driver and its clients on other machines trust each other."""

from __future__ import annotations

import os
import ssl

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError

SHORTEST_TOKEN = 16


def token_of(settings: RobotConfig) -> str:
    """The token that `driver_token_env` names; empty if the settings name none. Raises `ConfigError`."""
    if not (variable := settings.driver_token_env):
        return ""
    token = os.environ.get(variable, "")
    if len(token) < SHORTEST_TOKEN or not token.isascii() or not token.isprintable() or " " in token:
        raise ConfigError(
            f"the environment variable {variable} must hold the driver's token, at least {SHORTEST_TOKEN} "
            "letters and digits; make one with: openssl rand -hex 32"
        )
    return token


def load_certificates(context: ssl.SSLContext, settings: RobotConfig) -> None:
    """Load `driver_cert`, `driver_key` and `driver_ca`, of a client or a driver. Raises `ConfigError`."""
    context.minimum_version = ssl.TLSVersion.TLSv1_3  # both ends are ours
    try:
        if settings.driver_cert:
            context.load_cert_chain(os.path.expanduser(settings.driver_cert), os.path.expanduser(settings.driver_key))
    except (OSError, ssl.SSLError) as e:
        files = f"driver_cert {settings.driver_cert} and driver_key {settings.driver_key}"
        raise ConfigError(f"cannot use {files} ({e.strerror or e}); valid: a PEM certificate and its key") from None
    try:
        if settings.driver_ca:
            context.load_verify_locations(os.path.expanduser(settings.driver_ca))
    except (OSError, ssl.SSLError) as e:
        reason = e.strerror or str(e)
        raise ConfigError(f"cannot use driver_ca {settings.driver_ca} ({reason}); valid: PEM certificates") from None


def client_tls(settings: RobotConfig, url: str) -> ssl.SSLContext | None:
    """The TLS context of a client of `url`; None for plain HTTP, the end of a tunnel. Raises `ConfigError`."""
    if url.startswith("http:"):
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    load_certificates(context, settings)
    if not settings.driver_ca:
        context.load_default_certs()
    if not (settings.driver_token_env or settings.driver_cert):
        raise ConfigError(f"{url} needs a certificate or a token for this machine")
    return context
