"""A mark that changes with every change of accounts, sessions, tokens, boards and robots' rights (PostgreSQL)."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009_access_version"
down_revision = "0008_simulated"
branch_labels = None
depends_on = None

TABLES = ("accounts", "sessions", "tokens", "boards", "robots")


def upgrade() -> None:
    op.create_table(
        "access_version",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("mark", sa.String(length=36), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_access_version")),
    )
    if op.get_bind().dialect.name != "postgresql":
        return  # SQLite tells of each commit itself
    # A trigger misses no change, whoever makes it. The mark is never used again, also after a restored backup.
    op.execute(
        "CREATE FUNCTION agentrob_mark_access() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN "
        "INSERT INTO access_version (id, mark) VALUES (1, gen_random_uuid()::text) "
        "ON CONFLICT (id) DO UPDATE SET mark = excluded.mark; RETURN NULL; END $$"
    )
    for table in TABLES:
        op.execute(
            f"CREATE TRIGGER agentrob_mark_access AFTER INSERT OR UPDATE OR DELETE OR TRUNCATE ON {table} "
            "FOR EACH STATEMENT EXECUTE FUNCTION agentrob_mark_access()"
        )
    op.execute("INSERT INTO access_version (id, mark) VALUES (1, gen_random_uuid()::text)")


def downgrade() -> None:
    if op.get_bind().dialect.name == "postgresql":
        for table in TABLES:
            op.execute(f"DROP TRIGGER agentrob_mark_access ON {table}")
        op.execute("DROP FUNCTION agentrob_mark_access()")
    op.drop_table("access_version")
