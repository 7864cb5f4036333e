"""The tables of the embedded forum, as SQLAlchemy Core.

Times are microseconds since 1970 UTC (`*_us`): exact, portable, quick to read. Secrets are kept only as hashes.
The migrations in `migrations/` build these tables; a test holds the two together.
"""

from __future__ import annotations

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
    text,
)

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
    }
)

#: SQLite assigns ids only to INTEGER columns; other databases should use 64 bits.
Id = BigInteger().with_variant(Integer, "sqlite")


def _id() -> Column[int]:
    return Column("id", Id, primary_key=True)


def _account(name: str = "account_id", *, nullable: bool = False) -> Column[int]:
    return Column(name, Id, ForeignKey("accounts.id"), nullable=nullable)


#: `read_up_to`: all posts up to this one count as read; initially the posts from before the account was created.
accounts = Table(
    "accounts",
    metadata,
    _id(),
    Column("name", String(32), nullable=False, unique=True),
    Column("display_name", String(64), nullable=False, default=""),
    Column("kind", String(20), nullable=False),
    Column("role", String(10), nullable=False),
    Column("suspended", Boolean, nullable=False, default=False),
    Column("commands_simulated", Boolean, nullable=False, default=False, server_default=false()),
    Column("password_hash", String(200)),
    Column("created_us", BigInteger, nullable=False),
    Column(
        "read_up_to", Id, nullable=False, default=text("(SELECT coalesce(max(id), 0) FROM posts)"), server_default="0"
    ),
    sqlite_autoincrement=True,
)

#: Bearer tokens of programs.
tokens = Table(
    "tokens",
    metadata,
    Column("hash", String(64), primary_key=True),
    _account(),
    Column("label", String(64), nullable=False, default=""),
    Column("scopes", String(40), nullable=False, default="read write", server_default="read write"),
    Column("created_us", BigInteger, nullable=False),
    Column("revoked_us", BigInteger),
)

#: Sessions of browsers.
sessions = Table(
    "sessions",
    metadata,
    Column("hash", String(64), primary_key=True),
    _account(),
    Column("created_us", BigInteger, nullable=False),
    Column("expires_us", BigInteger, nullable=False),
)

#: One-time links: `enter` signs in, `password` sets a new password.
links = Table(
    "links",
    metadata,
    Column("hash", String(64), primary_key=True),
    _account(),
    Column("purpose", String(10), nullable=False, default="enter", server_default="enter"),
    Column("expires_us", BigInteger, nullable=False),
    Column("used_us", BigInteger),
)

#: Links with which people create their own accounts; `role` and `commands_simulated` are the rights they get, `left`
#: the remaining uses.
invites = Table(
    "invites",
    metadata,
    Column("hash", String(64), primary_key=True),
    _account("by_id", nullable=True),
    Column("role", String(10), nullable=False),
    Column("commands_simulated", Boolean, nullable=False, default=False, server_default=false()),
    Column("left", Integer, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    Column("expires_us", BigInteger, nullable=False),
)

#: The lowest roles that may read, post and command; a board that guests may read is public only if the forum is.
boards = Table(
    "boards",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("name", String(64), nullable=False),
    Column("description", String(200), nullable=False, default=""),
    Column("position", Integer, nullable=False, default=0),
    Column("read_role", String(10), nullable=False, default="guest", server_default="guest"),
    Column("post_role", String(10), nullable=False, default="member", server_default="member"),
    Column("command_role", String(10), nullable=False, default="operator", server_default="operator"),
)

#: Settings of a robot; a robot without a row has the defaults of `rights`.
robots = Table(
    "robots",
    metadata,
    _account(),
    _account("owner_id", nullable=True),
    Column("rights", JSON, nullable=False),
    Column("camera_role", String(10), nullable=False),
    Column("camera_days", Integer, nullable=False),
    Column("closed", JSON, nullable=False),
    PrimaryKeyConstraint("account_id"),
)

#: Who changed what: never changed, never deleted. `actor` is a handle, or `shell` for the command line.
audit = Table(
    "audit",
    metadata,
    _id(),
    Column("at_us", BigInteger, nullable=False),
    Column("actor", String(40), nullable=False),
    Column("action", String(40), nullable=False),
    Column("target", String(80), nullable=False),
    Column("detail", JSON, nullable=False),
    Index(None, "target", "id"),
    sqlite_autoincrement=True,
)

#: `last_post_id` orders topics by activity; `posts` counts those that are not removed. Both are kept by `writes`.
topics = Table(
    "topics",
    metadata,
    _id(),
    Column("board_id", String(32), ForeignKey("boards.id"), nullable=False),
    Column("title", String(200), nullable=False),
    _account("author_id"),
    Column("created_us", BigInteger, nullable=False),
    Column("last_post_id", Id, nullable=False, default=0),
    Column("last_post_us", BigInteger, nullable=False),
    Column("posts", Integer, nullable=False, default=0),
    Column("locked", Boolean, nullable=False, default=False, server_default=false()),
    Index(None, "board_id", "last_post_id"),
    Index(None, "last_post_id"),
    sqlite_autoincrement=True,
)

#: Tags of topics (`tags`).
topic_tags = Table(
    "topic_tags",
    metadata,
    Column("topic_id", Id, ForeignKey("topics.id"), nullable=False),
    Column("tag", String(24), nullable=False),
    PrimaryKeyConstraint("topic_id", "tag"),
    Index(None, "tag", "topic_id"),
)

#: The last post of each topic that an account has read (`unread`); the post may no longer exist.
topic_reads = Table(
    "topic_reads",
    metadata,
    _account(),
    Column("topic_id", Id, ForeignKey("topics.id"), nullable=False),
    Column("post_id", Id, nullable=False),
    PrimaryKeyConstraint("account_id", "topic_id"),
)

posts = Table(
    "posts",
    metadata,
    _id(),
    Column("topic_id", Id, ForeignKey("topics.id"), nullable=False),
    _account("author_id"),
    Column("raw", Text, nullable=False),
    Column("html", Text, nullable=False),
    Column("version", Integer, nullable=False, default=1),
    Column("created_us", BigInteger, nullable=False),
    Column("edited_us", BigInteger),
    Column("removed", Boolean, nullable=False, default=False),
    _account("removed_by", nullable=True),
    Column("mentions", JSON, nullable=False),
    Column("reply_to", Id, ForeignKey("posts.id")),
    Column("key", String(200)),
    Column("card", JSON(none_as_null=True)),
    Index(None, "topic_id", "id"),
    Index(None, "author_id", "id"),
    UniqueConstraint("author_id", "key"),
    sqlite_autoincrement=True,
)

#: The text of a post before each edit.
post_versions = Table(
    "post_versions",
    metadata,
    Column("post_id", Id, ForeignKey("posts.id"), primary_key=True),
    Column("version", Integer, primary_key=True),
    Column("raw", Text, nullable=False),
    Column("until_us", BigInteger, nullable=False),
)

#: Pictures; their files are in the images folder, named by `sha256`, until `gone_us`.
images = Table(
    "images",
    metadata,
    _id(),
    _account(),
    Column("sha256", String(64), nullable=False),
    Column("media_type", String(20), nullable=False),
    Column("width", Integer, nullable=False),
    Column("height", Integer, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    Column("gone_us", BigInteger),
    Index(None, "account_id", "id"),
    sqlite_autoincrement=True,
)

post_images = Table(
    "post_images",
    metadata,
    Column("post_id", Id, ForeignKey("posts.id"), primary_key=True),
    Column("position", Integer, primary_key=True),
    Column("image_id", Id, ForeignKey("images.id"), nullable=False, index=True),
)

#: Events in order; ids are never reused, so that a stream can resume after any of them.
events = Table(
    "events",
    metadata,
    _id(),
    Column("kind", String(20), nullable=False),
    Column("at_us", BigInteger, nullable=False),
    Column("topic_id", Id),
    Column("post_id", Id, ForeignKey("posts.id")),
    Column("robot", String(32)),
    _account(nullable=True),
    Index(None, "topic_id", "id"),
    sqlite_autoincrement=True,
)

#: Idempotency keys of writes other than new posts, which carry their own. `ref` is the result of the first write.
used_keys = Table(
    "used_keys",
    metadata,
    Column("account_id", Id, ForeignKey("accounts.id"), primary_key=True),
    Column("scope", String(40), primary_key=True),
    Column("key", String(200), primary_key=True),
    Column("ref", Id, nullable=False),
)

#: Notifications: account, post and reason. `notices_seen` is the last post whose notification an account has seen.
notices = Table(
    "notices",
    metadata,
    _account(),
    Column("post_id", Id, ForeignKey("posts.id"), nullable=False),
    Column("reason", String(10), nullable=False),
    PrimaryKeyConstraint("account_id", "post_id"),
)

notices_seen = Table(
    "notices_seen",
    metadata,
    _account(),
    Column("post_id", Id, nullable=False),
    PrimaryKeyConstraint("account_id"),
)

#: Records of commands by robots' agents. Besides these tables, SQLite has `post_words` (`fulltext`).
commands = Table(
    "commands",
    metadata,
    Column("post_id", Id, ForeignKey("posts.id"), nullable=False),
    _account("robot_id"),
    Column("reply_id", Id, ForeignKey("posts.id")),
    Column("at_us", BigInteger, nullable=False),
    Column("record", JSON, nullable=False),
    PrimaryKeyConstraint("post_id", "robot_id"),
)

#: Replays of commands by robots' agents: gzipped JSON as base64, deleted after a while (`retention`).
replays = Table(
    "replays",
    metadata,
    Column("post_id", Id, ForeignKey("posts.id"), nullable=False),
    _account("robot_id"),
    Column("at_us", BigInteger, nullable=False, index=True),
    Column("replay", Text, nullable=False),
    PrimaryKeyConstraint("post_id", "robot_id"),
)

# -------------------------------------------------------------------- short-lived, not in backups
FLEETING = {"fleeting": True}

#: Attempts to sign in and to create accounts, by a hash of the name or the address; deleted after an hour.
attempts = Table(
    "attempts",
    metadata,
    _id(),
    Column("key", String(64), nullable=False),
    Column("at_us", BigInteger, nullable=False, index=True),
    Index(None, "key", "at_us"),
    info=FLEETING,
)

#: The state of robots that serving processes share (`cluster_messages`); unlogged on PostgreSQL.
stage = Table(
    "stage",
    metadata,
    Column("robot", String(32), primary_key=True),
    Column("card", JSON, nullable=False),
    Column("seen_us", BigInteger, nullable=False),
    Column("frame", LargeBinary),
    Column("shown_us", BigInteger),
    info=FLEETING,
)

#: The number of viewers of a robot's camera, and of its map (`poses`), on one process; void after `until_us`, in case
#: the process has ended.
stage_viewers = Table(
    "stage_viewers",
    metadata,
    Column("process", String(16), primary_key=True),
    Column("robot", String(32), primary_key=True),
    Column("viewers", Integer, nullable=False),
    Column("poses", Integer, nullable=False, default=0, server_default="0"),
    Column("until_us", BigInteger, nullable=False),
    info=FLEETING,
)

#: On PostgreSQL, a mark that triggers change with every change of accounts, sessions, tokens, boards and robots' rights
#: (`read_cache`).
access_version = Table(
    "access_version",
    metadata,
    Column("id", Integer, primary_key=True, autoincrement=False),
    Column("mark", String(36), nullable=False),
    info=FLEETING,
)
