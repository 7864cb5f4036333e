"""Rights: of boards and robots, scopes of tokens, invites, locked topics, the audit log."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from alembic.util import CommandError

revision = "0002_rights"
down_revision = "0001"
branch_labels = None
depends_on = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_BOARD_ROLES = {"read_role": "guest", "post_role": "member", "command_role": "operator"}


def upgrade() -> None:
    op.add_column("tokens", _word("scopes", 40, "read write"))
    op.add_column("links", _word("purpose", 10, "enter"))
    for name, role in _BOARD_ROLES.items():
        op.add_column("boards", _word(name, 10, role))
    op.add_column("topics", sa.Column("locked", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.add_column("images", sa.Column("gone_us", sa.BigInteger(), nullable=True))
    op.create_index(op.f("ix_images_account_id_id"), "images", ["account_id", "id"], unique=False)
    _robots()
    _invites()
    _audit()


def downgrade() -> None:
    boards = sa.text("SELECT count(*) FROM boards WHERE read_role NOT IN ('guest', 'member')")
    if op.get_bind().execute(boards).scalar_one():
        raise CommandError("the version before cannot keep a board to operators: open or empty such boards first")
    for table in ("audit", "invites", "robots"):
        op.drop_table(table)
    # A role that the version before does not know becomes the one below it: nobody gains a right by going back.
    op.execute("UPDATE accounts SET role = 'member' WHERE role = 'guest'")
    op.execute("UPDATE accounts SET role = 'operator' WHERE role = 'moderator'")
    op.execute("DELETE FROM links WHERE purpose <> 'enter'")
    # Void or hide everything that the older version cannot keep closed or narrow.
    op.execute("UPDATE tokens SET revoked_us = created_us WHERE scopes NOT LIKE '%write%' AND revoked_us IS NULL")
    op.drop_index(op.f("ix_images_account_id_id"), "images")
    for table, columns in {
        "images": ["gone_us"],
        "topics": ["locked"],
        "boards": list(_BOARD_ROLES),
        "links": ["purpose"],
        "tokens": ["scopes"],
    }.items():
        for column in columns:
            op.drop_column(table, column)


def _word(name: str, length: int, default: str) -> sa.Column[str]:
    return sa.Column(name, sa.String(length=length), nullable=False, server_default=default)


def _robots() -> None:
    op.create_table(
        "robots",
        sa.Column("account_id", ID, nullable=False),
        sa.Column("owner_id", ID, nullable=True),
        sa.Column("rights", sa.JSON(), nullable=False),
        sa.Column("camera_role", sa.String(length=10), nullable=False),
        sa.Column("camera_days", sa.Integer(), nullable=False),
        sa.Column("closed", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(["account_id"], ["accounts.id"], name=op.f("fk_robots_account_id")),
        sa.ForeignKeyConstraint(["owner_id"], ["accounts.id"], name=op.f("fk_robots_owner_id")),
        sa.PrimaryKeyConstraint("account_id", name=op.f("pk_robots")),
    )


def _invites() -> None:
    op.create_table(
        "invites",
        sa.Column("hash", sa.String(length=64), nullable=False),
        sa.Column("by_id", ID, nullable=True),
        sa.Column("role", sa.String(length=10), nullable=False),
        sa.Column("left", sa.Integer(), nullable=False),
        sa.Column("created_us", sa.BigInteger(), nullable=False),
        sa.Column("expires_us", sa.BigInteger(), nullable=False),
        sa.ForeignKeyConstraint(["by_id"], ["accounts.id"], name=op.f("fk_invites_by_id")),
        sa.PrimaryKeyConstraint("hash", name=op.f("pk_invites")),
    )


def _audit() -> None:
    op.create_table(
        "audit",
        sa.Column("id", ID, nullable=False),
        sa.Column("at_us", sa.BigInteger(), nullable=False),
        sa.Column("actor", sa.String(length=40), nullable=False),
        sa.Column("action", sa.String(length=40), nullable=False),
        sa.Column("target", sa.String(length=80), nullable=False),
        sa.Column("detail", sa.JSON(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit")),
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_audit_target_id"), "audit", ["target", "id"], unique=False)
