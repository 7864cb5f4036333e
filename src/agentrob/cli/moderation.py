"""`agentrob board moderate`: hide, show, lock, move."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from agentrob.cli import forum_database
from agentrob.cli.options import ConfigFile
from agentrob.model import Role

cli = typer.Typer(no_args_is_help=True, help="Hide and show posts, lock and move topics.")

PostId = Annotated[str, typer.Argument(help="The number of the post.")]
TopicId = Annotated[str, typer.Argument(help="The number of the topic.")]
Reason = Annotated[str, typer.Option(help="Why, for the audit log.")]


def _moderate(config: Path | None, action: str, *args: Any) -> None:
    """Run a moderator's action as the shell, an account that exists only in the audit log."""
    from agentrob.board.admin import moderation
    from agentrob.board.content import writes
    from agentrob.board.db.audit import SHELL
    from agentrob.model import Account

    shell = Account("0", SHELL, role=Role.ADMIN)
    run = writes.remove if action == "hide" else getattr(moderation, action)
    forum_database.write(forum_database.writable(config), lambda t: run(t, shell, *args))


@cli.command("read")
def read(post: PostId, config: ConfigFile = None) -> None:
    """Print a post, hidden or not, and its earlier versions."""
    from agentrob.board.admin import moderation

    found, versions, hidden_by = forum_database.read(config, lambda reader: moderation.hidden(reader, post))
    typer.echo(f"{found.author.name}{f', hidden by {hidden_by}' if hidden_by else ''}: {found.raw}")
    for version in versions:
        typer.echo(f"until {version.until:%Y-%m-%d %H:%M:%S} UTC: {version.raw}")


@cli.command("hide")
def hide(post: PostId, reason: Reason = "", config: ConfigFile = None) -> None:
    """Hide a post; its text is kept."""
    _moderate(config, "hide", post, reason)


@cli.command("show")
def show(post: PostId, reason: Reason = "", config: ConfigFile = None) -> None:
    """Show a hidden post again."""
    _moderate(config, "show", post, reason)


@cli.command("lock")
def lock(
    topic: TopicId,
    locked: Annotated[bool, typer.Option("--lock/--unlock", help="Lock it, or open it again.")] = True,
    reason: Reason = "",
    config: ConfigFile = None,
) -> None:
    """Lock a topic, or open it again."""
    _moderate(config, "lock", topic, locked, reason)


@cli.command("move")
def move(
    topic: TopicId,
    board: Annotated[str, typer.Argument(help="The id of the other board.")],
    reason: Reason = "",
    config: ConfigFile = None,
) -> None:
    """Move a topic to another board."""
    _moderate(config, "move", topic, board, reason)
