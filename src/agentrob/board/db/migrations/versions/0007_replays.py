"""Replays of commands, and the viewers of robots' maps."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007_replays"
down_revision = "0006_tags"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "replays",
        sa.Column("post_id", ID, nullable=False),
        sa.Column("robot_id", ID, nullable=False),
        sa.Column("at_us", sa.BigInteger(), nullable=False),
        sa.Column("replay", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["post_id"], ["posts.id"], name=op.f("fk_replays_post_id")),
        sa.ForeignKeyConstraint(["robot_id"], ["accounts.id"], name=op.f("fk_replays_robot_id")),
        sa.PrimaryKeyConstraint("post_id", "robot_id", name=op.f("pk_replays")),
    )
    op.create_index(op.f("ix_replays_at_us"), "replays", ["at_us"], unique=False)
    op.add_column("stage_viewers", sa.Column("poses", sa.Integer(), nullable=False, server_default="0"))


def downgrade() -> None:
    op.drop_column("stage_viewers", "poses")
    op.drop_table("replays")
