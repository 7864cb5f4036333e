"""The `[images]` table: where the pictures of replies are stored.

[images]                      # by default the forum stores them
store = "s3"
bucket = "robot-pictures"
region = "eu-central-1"
endpoint = "https://minio.example.org"
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from agentrob.config.section import Address, Section, Variable


class ImagesConfig(Section):
    """Where the pictures of replies are stored. `store` is `inline`: on the forum, in the post; or `s3`, `tos`: in a
    `bucket`, below `prefix`, and the post has links that expire after `link_s` seconds and work for anyone who has
    them until then.

    `s3` is any S3-compatible store, Amazon S3 if there is no `endpoint`. `tos` is Volcengine TOS; its S3-compatible
    endpoint is derived from `region`. `path_style` puts the bucket into the path of an address instead of the host
    name; by default so with an `endpoint`. The environment variables that `key_env` and `secret_env` name hold the
    keys; the defaults are the vendors' names (`AWS_ACCESS_KEY_ID` …, `TOS_ACCESS_KEY` …).
    """

    store: Literal["inline", "s3", "tos"] = "inline"
    bucket: Annotated[str, Field(pattern=r"^([a-z0-9][a-z0-9.-]{1,61}[a-z0-9])?$")] = ""
    endpoint: Address = ""
    region: Annotated[str, Field(pattern=r"^[a-z0-9-]*$")] = ""
    prefix: Annotated[str, Field(pattern=r"^([A-Za-z0-9_.-]+/)*$")] = "agentrob/"
    link_s: Annotated[int, Field(ge=60, le=7 * 86400)] = 86400
    path_style: bool | None = None
    key_env: Variable = ""
    secret_env: Variable = ""

    @property
    def key_variable(self) -> str:
        return self.key_env or ("TOS_ACCESS_KEY" if self.store == "tos" else "AWS_ACCESS_KEY_ID")

    @property
    def secret_variable(self) -> str:
        return self.secret_env or ("TOS_SECRET_KEY" if self.store == "tos" else "AWS_SECRET_ACCESS_KEY")

    @property
    def session_variable(self) -> str:
        """The variable of the session token that accompanies temporary keys."""
        return "TOS_SECURITY_TOKEN" if self.store == "tos" else "AWS_SESSION_TOKEN"

    @property
    def address(self) -> str:
        """The store's address, without the bucket."""
        if self.endpoint:
            return self.endpoint
        return f"https://tos-s3-{self.region}.volces.com" if self.store == "tos" else _amazon(self.region)

    @property
    def virtual_hosted(self) -> bool:
        """Whether the bucket is part of the host name, as TOS and Amazon require; most others expect it in the path."""
        if self.path_style is not None:
            return not self.path_style
        return self.store == "tos" or not self.endpoint

    @property
    def bucket_address(self) -> str:
        """The store's address, with the bucket in the host name if `virtual_hosted`."""
        scheme, _, host = self.address.partition("://")
        return f"{scheme}://{self.bucket}.{host}" if self.virtual_hosted else self.address

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if self.store != "inline":
            needs = [name for name in ("bucket", "region") if not getattr(self, name)]
            if needs:
                raise ValueError(f'store "{self.store}" needs {" and ".join(needs)}')
        if self.store == "tos" and self.path_style:
            raise ValueError("TOS supports the bucket in the host name only; remove path_style")
        return self


def _amazon(region: str) -> str:
    return f"https://s3.{region}.amazonaws.com"
