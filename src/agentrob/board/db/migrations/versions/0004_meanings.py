"""An index of words for PostgreSQL too, and a table for what posts mean, as numbers."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from agentrob.board.db.fulltext import create_index, drop_index

revision = "0004_meanings"
down_revision = "0003_pages"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_ERASED = "post_meanings_erased"


def upgrade() -> None:
    op.create_table(
        "post_meanings",
        sa.Column("post_id", ID, autoincrement=False, nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(length=20), nullable=False),
        sa.Column("vector", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("post_id", name=op.f("pk_post_meanings")),
    )
    # Whoever erases a post erases its meaning, without having to know of this table.
    forget = "DELETE FROM post_meanings WHERE post_id = NEW.id"
    if op.get_bind().dialect.name == "sqlite":
        when = "AFTER UPDATE OF raw ON posts WHEN NEW.raw = ''"
        op.execute(f"CREATE TRIGGER {_ERASED} {when} BEGIN {forget}; END")
    elif op.get_bind().dialect.name == "postgresql":
        create_index(op.get_bind())
        body = f"BEGIN {forget}; RETURN NULL; END"
        op.execute(f"CREATE FUNCTION {_ERASED}() RETURNS trigger LANGUAGE plpgsql AS $$ {body} $$")
        when = "AFTER UPDATE OF raw ON posts FOR EACH ROW WHEN (NEW.raw = '')"
        op.execute(f"CREATE TRIGGER {_ERASED} {when} EXECUTE FUNCTION {_ERASED}()")


def downgrade() -> None:
    if op.get_bind().dialect.name == "sqlite":
        op.execute(f"DROP TRIGGER {_ERASED}")
    elif op.get_bind().dialect.name == "postgresql":
        drop_index(op.get_bind())
        op.execute(f"DROP TRIGGER {_ERASED} ON posts")
        op.execute(f"DROP FUNCTION {_ERASED}()")
    op.drop_table("post_meanings")
