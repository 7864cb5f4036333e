"""A driver that listens on TCP, certificates of a test authority, and clients over the network."""

from __future__ import annotations

import datetime
import ipaddress
import json
import os
from pathlib import Path
from typing import Any
from uuid import uuid4

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from agentrob.config.robots import RobotConfig
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.remote import driver_client
from tests.robots.driver_scene import Drivers

TOKEN, TOKEN_ENV = "a-token-of-a-test-0123456789", "AGENTROB_TEST_DRIVER_TOKEN"


class Authority:
    """An authority that signs certificates, and their PEM files in a folder."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self._key = folder, ec.generate_private_key(ec.SECP256R1())
        self._name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"authority {folder.name}")])
        certificate = self._builder(self._name, self._key, days=1).add_extension(
            x509.BasicConstraints(ca=True, path_length=0), critical=True
        )
        self.ca = str(self._write("ca.pem", certificate.sign(self._key, hashes.SHA256())))

    def issue(self, name: str, host: str = "127.0.0.1", days: int = 1) -> dict[str, str]:
        """The settings `driver_cert`, `driver_key` and `driver_ca` of one machine."""
        key = ec.generate_private_key(ec.SECP256R1())
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        names = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address(host))])
        certificate = self._builder(subject, key, days).add_extension(names, critical=False)
        cert = self._write(f"{name}.pem", certificate.sign(self._key, hashes.SHA256()))
        plain = serialization.NoEncryption()
        pem = key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, plain)
        path = self.folder / f"{name}.key"
        path.write_bytes(pem)
        return {"driver_cert": str(cert), "driver_key": str(path), "driver_ca": self.ca}

    def _builder(self, subject: x509.Name, key: ec.EllipticCurvePrivateKey, days: int) -> x509.CertificateBuilder:
        now = datetime.datetime.now(datetime.UTC)
        return (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(self._name)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - datetime.timedelta(days=2))
            .not_valid_after(now + datetime.timedelta(days=days))
        )

    def _write(self, name: str, certificate: x509.Certificate) -> Path:
        path = self.folder / name
        path.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
        return path


class NetworkDrivers(Drivers):
    """Drivers that also listen on a free TCP port: with certificates on both sides, or with a token."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        os.environ[TOKEN_ENV] = TOKEN
        self.authority = Authority(folder / "authority")
        self.listens: dict[str, str] = {}

    def serve(self, name: str = "", by: str = "certificate", **settings: Any) -> str:
        """Start one; clients show a `certificate`, a `token` over TLS, or a token over `plain` HTTP."""
        name = name or f"r{uuid4().hex[:8]}"
        network: dict[str, Any] = {"driver_listen": self.listens.get(name, "127.0.0.1:0")}
        if by != "plain":
            network |= self.authority.issue("driver")
        if by != "certificate":
            network |= {"driver_token_env": TOKEN_ENV, "driver_ca": ""}
        ready = json.loads(self.spawn(name, **network, **settings).stdout.readline())
        self.listens[name] = ready["listen"]
        return name

    def settings(self, name: str, by: str = "certificate", port: int = 0, **changes: Any) -> RobotConfig:
        """The settings of a client on another machine; `port` of a proxy."""
        listen = f"127.0.0.1:{port}" if port else self.listens[name]
        network: dict[str, Any] = {"driver_url": f"{'http' if by == 'plain' else 'https'}://{listen}"}
        if by == "certificate":
            network |= self.authority.issue("agent")
        else:
            network |= {"driver_token_env": TOKEN_ENV, "driver_ca": "" if by == "plain" else self.authority.ca}
        return RobotConfig(model="fake", **{**network, **changes})

    def remote(self, name: str, by: str = "certificate", port: int = 0, **changes: Any) -> DriverClient:
        return driver_client(name, self.settings(name, by, port, **changes))
