"""Tables for pages: words of posts to search for, notices to people, records of commands."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from agentrob.board.db.fulltext import create_index, drop_index

revision = "0003_pages"
down_revision = "0002_rights"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "notices",
        sa.Column("account_id", ID, nullable=False),
        sa.Column("post_id", ID, nullable=False),
        sa.Column("reason", sa.String(length=10), nullable=False),
        sa.ForeignKeyConstraint(["account_id"], ["accounts.id"], name=op.f("fk_notices_account_id")),
        sa.ForeignKeyConstraint(["post_id"], ["posts.id"], name=op.f("fk_notices_post_id")),
        sa.PrimaryKeyConstraint("account_id", "post_id", name=op.f("pk_notices")),
    )
    op.create_table(
        "notices_seen",
        sa.Column("account_id", ID, nullable=False),
        sa.Column("post_id", ID, nullable=False),
        sa.ForeignKeyConstraint(["account_id"], ["accounts.id"], name=op.f("fk_notices_seen_account_id")),
        sa.PrimaryKeyConstraint("account_id", name=op.f("pk_notices_seen")),
    )
    op.create_table(
        "commands",
        sa.Column("post_id", ID, nullable=False),
        sa.Column("robot_id", ID, nullable=False),
        sa.Column("reply_id", ID, nullable=True),
        sa.Column("at_us", sa.BigInteger(), nullable=False),
        sa.Column("record", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(["post_id"], ["posts.id"], name=op.f("fk_commands_post_id")),
        sa.ForeignKeyConstraint(["reply_id"], ["posts.id"], name=op.f("fk_commands_reply_id")),
        sa.ForeignKeyConstraint(["robot_id"], ["accounts.id"], name=op.f("fk_commands_robot_id")),
        sa.PrimaryKeyConstraint("post_id", "robot_id", name=op.f("pk_commands")),
    )
    if op.get_bind().dialect.name == "sqlite":  # PostgreSQL got its index later
        create_index(op.get_bind())


def downgrade() -> None:
    if op.get_bind().dialect.name == "sqlite":
        drop_index(op.get_bind())
    for table in ("commands", "notices_seen", "notices"):
        op.drop_table(table)
