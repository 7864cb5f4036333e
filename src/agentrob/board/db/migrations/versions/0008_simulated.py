"""Accounts and invites that may command simulated robots only."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008_simulated"
down_revision = "0007_replays"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for table in ("accounts", "invites"):
        op.add_column(table, sa.Column("commands_simulated", sa.Boolean(), nullable=False, server_default=sa.false()))


def downgrade() -> None:
    for table in ("invites", "accounts"):
        op.drop_column(table, "commands_simulated")
