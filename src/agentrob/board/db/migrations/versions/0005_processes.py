"""Tables that several processes on one database share: attempts to sign in, robots' cards and pictures, viewers."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005_processes"
down_revision = "0004_meanings"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "attempts",
        sa.Column("id", ID, nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("at_us", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_attempts")),
    )
    op.create_index(op.f("ix_attempts_at_us"), "attempts", ["at_us"], unique=False)
    op.create_index(op.f("ix_attempts_key_at_us"), "attempts", ["key", "at_us"], unique=False)
    # Live pictures are renewed each second: they need not outlive a crash, so they are not written twice.
    unlogged = ["UNLOGGED"] if op.get_bind().dialect.name == "postgresql" else []
    op.create_table(
        "stage",
        sa.Column("robot", sa.String(length=32), nullable=False),
        sa.Column("card", sa.JSON(), nullable=False),
        sa.Column("seen_us", sa.BigInteger(), nullable=False),
        sa.Column("frame", sa.LargeBinary(), nullable=True),
        sa.Column("shown_us", sa.BigInteger(), nullable=True),
        sa.PrimaryKeyConstraint("robot", name=op.f("pk_stage")),
        prefixes=unlogged,
    )
    op.create_table(
        "stage_viewers",
        sa.Column("process", sa.String(length=16), nullable=False),
        sa.Column("robot", sa.String(length=32), nullable=False),
        sa.Column("viewers", sa.Integer(), nullable=False),
        sa.Column("until_us", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("process", "robot", name=op.f("pk_stage_viewers")),
        prefixes=unlogged,
    )


def downgrade() -> None:
    for table in ("stage_viewers", "stage", "attempts"):
        op.drop_table(table)
