"""Tags of topics, and what each account has read."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006_tags"
down_revision = "0005_processes"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "topic_tags",
        sa.Column("topic_id", ID, nullable=False),
        sa.Column("tag", sa.String(length=24), nullable=False),
        sa.ForeignKeyConstraint(["topic_id"], ["topics.id"], name=op.f("fk_topic_tags_topic_id")),
        sa.PrimaryKeyConstraint("topic_id", "tag", name=op.f("pk_topic_tags")),
    )
    op.create_index(op.f("ix_topic_tags_tag_topic_id"), "topic_tags", ["tag", "topic_id"], unique=False)
    op.create_table(
        "topic_reads",
        sa.Column("account_id", ID, nullable=False),
        sa.Column("topic_id", ID, nullable=False),
        sa.Column("post_id", ID, nullable=False),
        sa.ForeignKeyConstraint(["account_id"], ["accounts.id"], name=op.f("fk_topic_reads_account_id")),
        sa.ForeignKeyConstraint(["topic_id"], ["topics.id"], name=op.f("fk_topic_reads_topic_id")),
        sa.PrimaryKeyConstraint("account_id", "topic_id", name=op.f("pk_topic_reads")),
    )
    op.add_column("accounts", sa.Column("read_up_to", ID, nullable=False, server_default="0"))
    # Earlier posts count as read, so that nobody finds years of them new.
    op.execute("UPDATE accounts SET read_up_to = (SELECT coalesce(max(id), 0) FROM posts)")


def downgrade() -> None:
    op.drop_column("accounts", "read_up_to")
    op.drop_table("topic_reads")
    op.drop_index(op.f("ix_topic_tags_tag_topic_id"), "topic_tags")
    op.drop_table("topic_tags")
