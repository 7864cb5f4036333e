"""Alembic runs the migrations on the connection that `database.migrate` gives it."""

from __future__ import annotations

from alembic import context

from agentrob.board.db.schema import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    render_as_batch=True,  # SQLite changes tables by copying them
)
# `database.migrate` holds the transaction, with the write lock from its beginning.
context.run_migrations()
