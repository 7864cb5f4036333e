"""The version of the journal's tables.

A worker refuses tables of a newer version. It changes tables of an older version only while no worker of such a version
uses them: on SQLite the robot's file lock says so, on PostgreSQL a shared session lock for the version, which each
worker takes before it looks at the tables. `META` stays readable for all versions.
"""

from __future__ import annotations

from sqlalchemy import Connection, inspect, text

from agentrob.agent.store.queries import VALUE, put
from agentrob.agent.store.schema import ALL, META
from agentrob.errors import JournalError

#: 1: a SQLite file for each robot, without a robot in its rows. 2: the tables of `schema`. 3: with schedules. 4: with
#: parts of posts to several robots. 5: with previews.
VERSION = 5
#: The first number of PostgreSQL's advisory locks for versions; the second one is the version.
VERSION_LOCK = 4_107_006
_KEY = "schema"
#: Written before the version was.
_UNMARKED = 2
_OLDEST_IN_USE = """
SELECT min(objid::bigint) FROM pg_locks
WHERE locktype = 'advisory' AND objsubid = 2 AND classid::bigint = :lock
AND database = (SELECT oid FROM pg_database WHERE datname = current_database())
"""


def stored_version(db: Connection) -> int | None:
    """The version of the tables that are there; None if there are none. Raises `JournalError` if it is too new."""
    tables = inspect(db)
    if not tables.has_table(META.name):
        return None
    if "robot" not in {column["name"] for column in tables.get_columns(META.name)}:
        return 1
    version = int(_written(db) or _UNMARKED)
    if version > VERSION:
        raise JournalError(
            f"the journal's database has version {version}, and this AgentRob reads up to {VERSION}; upgrade it here"
        )
    return version


def refuse_while_older_serve(db: Connection) -> None:
    """On PostgreSQL: raise `JournalError` while a worker of an older version uses the tables."""
    oldest = db.execute(text(_OLDEST_IN_USE), {"lock": VERSION_LOCK}).scalar()
    if oldest is not None and oldest < VERSION:
        raise JournalError(
            f"the journal must be changed from version {oldest} to {VERSION}, and a worker of the older version still "
            "uses it; end every older worker first, on its machine: agentrob agent drain"
        )


def write_version(db: Connection) -> None:
    """Note that the tables are of this version, unless it is noted."""
    if _written(db) != str(VERSION):
        put(db, ALL, **{_KEY: str(VERSION)})


def _written(db: Connection) -> str | None:
    found: str | None = db.execute(VALUE, {"this_robot": ALL, "this_key": _KEY}).scalar()
    return found
