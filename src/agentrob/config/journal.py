"""Where agents keep what they claimed and moved.

[journal]
database = "postgresql+psycopg://agentrob@db.example/agentrob"   # default: a SQLite file for each robot
"""

from __future__ import annotations

from pydantic import field_validator

from agentrob.config.section import Section


class JournalConfig(Section):
    """`database` is a SQLAlchemy URL of a PostgreSQL database, which many workers may share; empty: a SQLite file for
    each robot in the data folder, for one machine."""

    database: str = ""

    @field_validator("database")
    @classmethod
    def _check_database(cls, value: str) -> str:
        if value and not value.startswith("postgresql+psycopg://"):
            raise ValueError("must begin with postgresql+psycopg:// or be empty for SQLite files in the data folder")
        return value
