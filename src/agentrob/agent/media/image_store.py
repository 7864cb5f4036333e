"""Where pictures of replies are kept when not on the forum: a bucket that speaks S3, with links that soon expire."""

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

#: One picture is given up after this: a reply waits for it.
KEEP_S = 6.0
_TYPES = {b"\xff\xd8": ("jpg", "image/jpeg"), b"\x89P": ("png", "image/png"), b"RI": ("webp", "image/webp")}


@dataclass(frozen=True, slots=True)
class Link:
    """Whoever has `url` can see the picture for `valid_s` seconds after `made_at`."""

    url: str
    made_at: datetime
    valid_s: float

    @property
    def until(self) -> datetime:
        return self.made_at + timedelta(seconds=self.valid_s)


class ImageStore(Protocol):
    """Keeps pictures and gives links to them."""

    async def keep(self, name: str, data: bytes) -> Link:
        """Keep a JPEG, PNG, WebP or JSON lines under a new address that nobody can guess; `name` is part of it.

        Raises `ImageStoreError`, after `KEEP_S` at the latest.
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
    """The configured store; None when pictures go to the forum. Raises `ConfigError`; nothing is connected yet."""
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
    """In one line: the library's errors hold the address, the answer's whole text and their own insides."""
    text = str(error).partition("Debug source")[0]
    code = re.search(r"<Code>(\w{1,60})</Code>", text)
    told = " ".join(text.partition("<?xml")[0].split()).rpartition(" - ")[2].rstrip(" :")
    return f"{told[:200]}{f' ({code[1]})' if code else ''}" or type(error).__name__
