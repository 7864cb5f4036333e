"""The `[images]` table: where pictures of replies are kept.

[images]                      # default: in the post
store = "s3"
bucket = "robot-pictures"
region = "eu-central-1"
endpoint = "https://minio.example.org"
"""

from __future__ import annotations

from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, field_validator, model_validator

from agentrob.config.section import Section


class ImagesConfig(Section):
    """Where the pictures of replies are kept. `inline`: on the forum, in the post. `s3`, `tos`: in a bucket, and the
    post has links that expire after `link_s` seconds (whoever has such a link can look until then).

    `s3` is any S3-compatible store; without an `endpoint` it is Amazon's. `tos` is Volcengine TOS through its
    S3-compatible endpoint, which is known from the `region`. The keys are in the environment, in the variables that
    `key_env` and `secret_env` name, else in the usual ones (`AWS_ACCESS_KEY_ID` …, `TOS_ACCESS_KEY` …).
    """

    store: Literal["inline", "s3", "tos"] = "inline"
    bucket: Annotated[str, Field(pattern=r"^([a-z0-9][a-z0-9.-]{1,61}[a-z0-9])?$")] = ""
    endpoint: str = ""
    region: Annotated[str, Field(pattern=r"^[a-z0-9-]*$")] = ""
    prefix: Annotated[str, Field(pattern=r"^([A-Za-z0-9_.-]+/)*$")] = "agentrob/"
    link_s: Annotated[int, Field(ge=60, le=7 * 86400)] = 86400
    path_style: bool | None = None
    key_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""
    secret_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""

    @property
    def key_variable(self) -> str:
        return self.key_env or ("TOS_ACCESS_KEY" if self.store == "tos" else "AWS_ACCESS_KEY_ID")

    @property
    def secret_variable(self) -> str:
        return self.secret_env or ("TOS_SECRET_KEY" if self.store == "tos" else "AWS_SECRET_ACCESS_KEY")

    @property
    def session_variable(self) -> str:
        """A token beside keys that are themselves short-lived."""
        return "TOS_SECURITY_TOKEN" if self.store == "tos" else "AWS_SESSION_TOKEN"

    @property
    def address(self) -> str:
        """The store's address, without the bucket."""
        if self.endpoint:
            return self.endpoint
        return f"https://tos-s3-{self.region}.volces.com" if self.store == "tos" else _amazon(self.region)

    @property
    def virtual_hosted(self) -> bool:
        """Whether the bucket is part of the host name: TOS and Amazon want that, most others take a path."""
        if self.path_style is not None:
            return not self.path_style
        return self.store == "tos" or not self.endpoint

    @property
    def bucket_address(self) -> str:
        """The address, with the bucket in it where that is wanted."""
        scheme, _, host = self.address.partition("://")
        return f"{scheme}://{self.bucket}.{host}" if self.virtual_hosted else self.address

    @field_validator("endpoint")
    @classmethod
    def _is_plain_address(cls, url: str) -> str:
        if url and not plain_address(url):
            raise ValueError("must be http(s)://host[:port] without a user, key or query")
        return url.rstrip("/")

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.store != "inline":
            needs = [name for name in ("bucket", "region") if not getattr(self, name)]
            if needs:
                raise ValueError(f'store "{self.store}" needs {" and ".join(needs)}')
        if self.store == "tos" and self.path_style:
            raise ValueError("TOS takes the bucket in the host name only; leave path_style out")
        return self


def _amazon(region: str) -> str:
    return f"https://s3.{region}.amazonaws.com"


def plain_address(url: str) -> bool:
    """Whether it is http(s)://host[:port][/path], without anything that may be a secret."""
    try:
        parts = urlsplit(url)
        _ = parts.port
        return bool(parts.scheme in ("http", "https") and parts.hostname and not (parts.username or parts.query))
    except ValueError:
        return False
