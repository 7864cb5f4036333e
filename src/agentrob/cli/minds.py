"""`agentrob plan` and `agentrob mind`: what is understood, and whether the configured models can be used."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from agentrob.cli.options import AsJson, ConfigFile, RobotKind
from agentrob.errors import ConfigError
from agentrob.process.logs import log_to_stderr
from agentrob.wiring import app

cli = typer.Typer(no_args_is_help=True, help="The models that read posts.")


@cli.callback()
def _log_to_stderr() -> None:
    """Keep standard output for results: models that fail are logged to standard error."""
    log_to_stderr()


def plan(
    text: Annotated[str, typer.Argument(help="What somebody would write in a post.")],
    mind: Annotated[str, typer.Option(help="The mind that reads it: rules, or a mind of the configuration.")] = "rules",
    as_json: AsJson = False,
    model: RobotKind = "go2",
    config: ConfigFile = None,
) -> None:
    """Show how a text is understood and judged. With --mind also which model read it, and its usage. Nothing moves."""
    if mind != "rules":
        if as_json:
            raise ConfigError("--json is available for rules only")
        log_to_stderr()
        typer.echo("\n".join(app.try_mind(app.load(config), mind, text, model)))
        return
    facts = app.plan_text(text, model)
    typer.echo(json.dumps(facts, ensure_ascii=False) if as_json else app.describe_plan(facts))


@cli.command("check")
def mind_check(
    mind: Annotated[str | None, typer.Argument(help="Its name in the configuration. [default: all]")] = None,
    config: ConfigFile = None,
    as_json: AsJson = False,
) -> None:
    """Ask each configured model whether it can be used; takes a few tokens. Exit code 1 if one cannot."""
    found = app.check_minds(app.load(config), mind)
    if as_json:
        typer.echo(json.dumps([one.as_data() for one in found], ensure_ascii=False))
    else:
        typer.echo("\n".join([*(one.line() for one in found), "rules: always available, without a model"]))
    raise typer.Exit(0 if all(one.ok for one in found) else 1)
