"""Store the pictures of replies in an S3-compatible bucket instead of the forum, behind links that expire."""

from __future__ import annotations

import asyncio
import os
import re
import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Protocol

from agentrob.config.images import ImagesConfig
from agentrob.errors import ConfigError, ImageStoreError

if TYPE_CHECKING:
    from obstore.store import S3Store

#: The timeout for storing one picture; a reply waits for it.
KEEP_S = 6.0
_TYPES = {b"\xff\xd8": ("jpg", "image/jpeg"), b"\x89P": ("png", "image/png"), b"RI": ("webp", "image/webp")}


@dataclass(frozen=True, slots=True)
class Link:
    """A link to a picture that is valid for `valid_s` seconds after `made_at`."""

    url: str
    made_at: datetime
    valid_s: float

    @property
    def until(self) -> datetime:
        return self.made_at + timedelta(seconds=self.valid_s)


class ImageStore(Protocol):
    """Stores pictures and returns links to them."""

    async def keep(self, name: str, data: bytes) -> Link:
        """Store a JPEG, PNG, WebP or JSON lines file under a new unguessable address that contains `name`.

        Raises `ImageStoreError`, also if it takes longer than `KEEP_S`.
        """
        ...


class Bucket:
    """A bucket of any S3-compatible store, or of Volcengine TOS through its S3 endpoint."""

    def __init__(self, config: ImagesConfig) -> None:
        self._config = config
        self._store: S3Store = _open(config)

    async def keep(self, name: str, data: bytes) -> Link:
        import obstore
        from obstore.exceptions import BaseError

        kind, media_type = _TYPES.get(data[:2], ("jsonl", "application/x-ndjson"))
        now = datetime.now(UTC)
        path = f"{self._config.prefix}{now:%Y-%m-%d}/{secrets.token_urlsafe(16)}-{name}.{kind}"
        try:
            async with asyncio.timeout(KEEP_S):
                await obstore.put_async(self._store, path, data, attributes={"Content-Type": media_type})
                url = await obstore.sign_async(self._store, "GET", path, timedelta(seconds=self._config.link_s))
        except TimeoutError:
            raise ImageStoreError(f"the image store did not take {name} within {KEEP_S:g} s") from None
        except (BaseError, OSError, ValueError) as e:
            raise ImageStoreError(f"the image store did not take {name}: {_reason(e)}") from None
        return Link(url, now, self._config.link_s)


def make_store(config: ImagesConfig) -> ImageStore | None:
    """Return the configured store, or None if pictures go to the forum. Does not connect; raises `ConfigError`."""
    return None if config.store == "inline" else Bucket(config)


def _open(config: ImagesConfig) -> S3Store:
    try:
        from obstore.store import S3Store
    except ImportError:
        raise ConfigError('an image store needs the extra "images": pip install "agentrob[images]"') from None
    variables = config.key_variable, config.secret_variable
    key, secret = (os.environ.get(variable, "") for variable in variables)
    if not (key and secret):
        raise ConfigError(f"the environment variables {' and '.join(variables)} must hold the image store's keys")
    token = {"session_token": session} if (session := os.environ.get(config.session_variable, "")) else {}
    return S3Store(
        config.bucket,
        endpoint=config.bucket_address,
        region=config.region,
        access_key_id=key,
        secret_access_key=secret,
        virtual_hosted_style_request=config.virtual_hosted,
        client_options={"allow_http": config.address.startswith("http://"), "connect_timeout": "2s", "timeout": "5s"},
        retry_config={"max_retries": 2, "retry_timeout": timedelta(seconds=4)},
        **token,  # type: ignore[arg-type]
    )


def _reason(error: BaseException) -> str:
    """Return the cause in one line: the library's errors contain the address, the whole response and debug output."""
    text = str(error).partition("Debug source")[0]
    code = re.search(r"<Code>(\w{1,60})</Code>", text)
    reason = " ".join(text.partition("<?xml")[0].split()).rpartition(" - ")[2].rstrip(" :")
    return f"{reason[:200]}{f' ({code[1]})' if code else ''}" or type(error).__name__
