"""The journal's tables, for SQLite and PostgreSQL. Every row belongs to one robot."""

from __future__ import annotations

from typing import Any

from sqlalchemy import BigInteger, Column, Double, Index, MetaData, Table, Text
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement

METADATA = MetaData()


def _table(name: str, key: str, *columns: Column[Any]) -> Table:
    """A table whose rows have a robot and a key that is unique for this robot."""
    robot, own = Column("robot", Text, primary_key=True), Column(key, Text, primary_key=True)
    return Table(name, METADATA, robot, own, *columns)


#: Values by name. Those of the database as a whole have the robot `ALL`.
META = _table("meta", "key", Column("value", Text, nullable=False))
#: Posts that the robot's agent claimed. `number` is their order.
CLAIM = _table(
    "claim", "post",
    Column("number", BigInteger, nullable=False),
    Column("topic", Text, nullable=False),
    Column("command", Text, nullable=False),
    Column("boot", Text, nullable=False),
    Column("accepted_s", Double, nullable=False),
    Column("status_post", Text),
    Column("final", Text),
    Column("plan", Text),
    Column("at", Double, nullable=False),
    Column("ended", Text),
)  # fmt: skip
Index("claim_number", CLAIM.c.robot, CLAIM.c.number)
Index("claim_topic", CLAIM.c.robot, CLAIM.c.topic)
#: Motions that began or never may. `fence` is the number of the worker that wrote the row, on PostgreSQL.
MOTION = _table(
    "motion", "post",
    Column("state", Text, nullable=False),
    Column("result", Text),
    Column("at", Double, nullable=False),
    Column("fence", BigInteger),
)  # fmt: skip
APPROVAL = _table(
    "approval", "post",
    Column("asked_at", Text, nullable=False),
    Column("until_at", Text, nullable=False),
    Column("said", Text),
    Column("said_by", Text),
)  # fmt: skip
ASSESSMENT = _table("assessment", "post", Column("result", Text, nullable=False))
#: Previews of commands that wait for an approval. `shown_at`: since when it is beside the question, by the forum's
#: clock, none until that is known; `pictures`: how many the status post has by it.
PREVIEW = _table(
    "preview", "post",
    Column("data", Text, nullable=False),
    Column("shown_at", Text),
    Column("pictures", BigInteger, nullable=False),
)  # fmt: skip
#: Commands for later times. `next_at` is the next run, if there is one; `told`: the end was reported, or need not be.
SCHEDULE = _table(
    "schedule", "post",
    Column("data", Text, nullable=False),
    Column("next_at", Text),
    Column("runs_left", BigInteger, nullable=False),
    Column("ended", Text),
    Column("told", BigInteger, nullable=False),
)  # fmt: skip
#: Parts of posts to several robots. `waits_since`: since when a part has waited for others, and `released_at` when that
#: ended. `summary`: what the robot that is named first has to sum up once all parts have ended; `told`: it has.
JOINT = _table(
    "joint", "post",
    Column("waits_since", Text),
    Column("released_at", Text),
    Column("summary", Text),
    Column("told", BigInteger, nullable=False),
)  # fmt: skip
#: On PostgreSQL, the fencing number of each robot's newest holder, and the mark of the last transaction it committed.
HOLDER = Table(
    "holder", METADATA,
    Column("robot", Text, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("written", Text),
)  # fmt: skip
ALL = ""


class now_s(FunctionElement[float]):  # noqa: N801 (a SQL function)
    """The time in Unix seconds, by the database's clock, which all workers share."""

    type = Double()
    inherit_cache = True


@compiles(now_s, "sqlite")
def _now_sqlite(*_: Any, **__: Any) -> str:
    return "((julianday('now') - 2440587.5) * 86400.0)"


@compiles(now_s, "postgresql")
def _now_postgresql(*_: Any, **__: Any) -> str:
    return "extract(epoch FROM clock_timestamp())::float8"
