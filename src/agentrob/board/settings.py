"""The settings of the embedded forum, made from `[board]` of the configuration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from agentrob.config.board import BoardConfig, BoardLimitsConfig, BoardRetentionConfig
from agentrob.config.service import HookOutConfig
from agentrob.errors import ConfigError
from agentrob.process.listen import base_url as url_of
from agentrob.process.listen import is_loopback
from agentrob.semantic.encoder import Encoder, TextEncoder

NO_LIMITS = BoardLimitsConfig(posts=0, commands=0, uploads=0, sign_ups=0)


@dataclass(frozen=True, slots=True)
class BoardSettings:
    """`database` is a SQLAlchemy URL, `base_url` what browsers see (without a final slash; https makes cookies Secure).

    `sign_up`: anybody may create an account (as `member`). `public_read`: reading needs no sign-in. `trusted_proxies`
    may set the client's address. `encoder` creates the text encoder of semantic search.
    `metrics` is the address of the Prometheus metrics, if there is one.
    """

    database: str
    host: str
    port: int
    base_url: str
    images_dir: Path
    title: str = "AgentRob"
    sign_up: bool = False
    public_read: bool = False
    limits: BoardLimitsConfig = NO_LIMITS
    trusted_proxies: tuple[str, ...] = ()
    busy_timeout_s: float = 2.0
    hooks: Mapping[str, HookOutConfig] = field(default_factory=dict)
    retention: BoardRetentionConfig = field(default_factory=BoardRetentionConfig)
    encoder: Callable[[], TextEncoder] | None = None
    metrics: str = ""

    @classmethod
    def from_config(cls, board: BoardConfig, data_dir: Path) -> BoardSettings:
        """Settings from `[board]`; defaults are in `data_dir`. Raises `ConfigError`."""
        host, port = board.address
        base_url = (board.base_url or url_of(host, port)).rstrip("/")
        parts = urlsplit(base_url)
        if parts.scheme not in ("http", "https") or not parts.netloc or parts.path or parts.query:
            raise ConfigError(f"board.base_url: {base_url!r} is not an address; valid: https://forum.example.org")
        # A forum on loopback with another base URL is behind a reverse proxy, so others can reach it.
        local = is_loopback(host) and is_loopback(parts.hostname or "")
        sign_up = local if board.sign_up is None else board.sign_up
        database = board.database or f"sqlite:///{data_dir / 'board' / 'board.sqlite3'}"
        if "://" not in database:
            database = f"sqlite:///{Path(database).expanduser()}"
        limits = board.limits or (NO_LIMITS if local else BoardLimitsConfig())
        proxies = board.trusted_proxies
        if proxies is None:
            proxies = ("127.0.0.1", "::1") if base_url.startswith("https://") else ()
        images = data_dir / "board" / "images"
        return cls(
            database, host, port, base_url, images, board.title, sign_up, board.public_read, limits, proxies,
            hooks=board.hooks, retention=board.retention, encoder=Encoder if board.semantic else None,
            metrics=board.metrics,
        )  # fmt: skip

    @property
    def secure(self) -> bool:
        return self.base_url.startswith("https://")

    @property
    def database_path(self) -> Path | None:
        """The SQLite file, or None for another database."""
        return Path(self.database.removeprefix("sqlite:///")) if self.database.startswith("sqlite:///") else None

    @property
    def shared(self) -> bool:
        """Whether several processes may serve the database, which they coordinate through PostgreSQL."""
        return self.database.startswith("postgresql")

    @property
    def database_shown(self) -> str:
        """The database without its password, for people and logs."""
        from sqlalchemy import make_url

        return make_url(self.database).render_as_string(hide_password=True)

    @property
    def cookie(self) -> str:
        """The name of the session cookie. It contains the port that browsers see, since they share cookies between the
        ports of a host, and is the same on all processes of a forum. With https it is bound to the host."""
        parts = urlsplit(self.base_url)
        name = f"agentrob_{parts.port or (443 if self.secure else 80)}"
        return f"__Host-{name}" if self.secure else name
