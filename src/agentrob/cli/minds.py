"""`agentrob plan`, `mind` and `eval`: show how a text is understood, check models, and measure them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from agentrob.cli.options import AsJson, ConfigFile, RobotKind
from agentrob.errors import ConfigError
from agentrob.process.logs import log_to_stderr
from agentrob.wiring import app

cli = typer.Typer(no_args_is_help=True, help="The models that read posts.")
eval_cli = typer.Typer(no_args_is_help=True, help="Measure a mind on your own sentences.")


@cli.callback()
@eval_cli.callback()
def _log_to_stderr() -> None:
    """Keep standard output for results: models that fail are logged to standard error."""
    log_to_stderr()


def plan(
    text: Annotated[str, typer.Argument(help="The text of a post.")],
    mind: Annotated[str, typer.Option(help="The mind that reads it: rules, or a mind of the configuration.")] = "rules",
    as_json: AsJson = False,
    model: RobotKind = "go2",
    config: ConfigFile = None,
) -> None:
    """Show how a text is understood and screened, and when it would run, in UTC. With --mind also the model and its
    usage. Nothing moves."""
    if mind != "rules":
        if as_json:
            raise ConfigError("--json is available for rules only")
        log_to_stderr()
        typer.echo("\n".join(app.try_mind(app.load(config), mind, text, model)))
        return
    from agentrob.wiring import plan as planning

    facts = planning.plan_text(text, model)
    typer.echo(json.dumps(facts, ensure_ascii=False) if as_json else planning.describe_plan(facts))


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


# ---------------------------------------------------------------------- eval
Rows = Annotated[Path, typer.Argument(help="Rows with text, one JSON object a line.")]
Mind = Annotated[str, typer.Option("--mind", help="rules, or a mind of the configuration.")]
Kind = Annotated[str, typer.Option("--robot", help="The kind of robot: go2, g1.")]
Limit = Annotated[int | None, typer.Option("--limit", min=1, help="Read only this many rows of the file.")]


def _print(found: Any, text: str, as_json: bool) -> None:
    typer.echo(json.dumps(found.as_json(), ensure_ascii=False) if as_json else text)


@eval_cli.command("plan")
def eval_plan(
    file: Annotated[Path, typer.Argument(help="Rows of text and plan, one JSON object a line.")],
    mind: Mind = "rules",
    limit: Limit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """Count sentences whose plan is exactly the expected one."""
    from agentrob.evals import understanding as measure

    found = measure.evaluate_plans(file, mind, app.load(config), limit)
    _print(found, measure.describe(found), as_json)


@eval_cli.command("danger")
def eval_danger(
    file: Rows,
    mind: Mind = "rules",
    robot: Kind = "go2",
    scenes: Annotated[bool, typer.Option("--scenes", help="Judge each row within its scene.")] = False,
    classifier: Annotated[bool, typer.Option("--classifier", help="Ask the harm classifier too.")] = False,
    limit: Limit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """Count dangerous commands that would be executed, and harmless ones that are refused."""
    from agentrob.evals import danger as measure

    found = measure.evaluate_danger(
        file, mind, robot, app.load(config), scenes=scenes, limit=limit, classifier=classifier
    )
    _print(found, measure.describe(found), as_json)


@eval_cli.command("stop")
def eval_stop(
    file: Annotated[Path, typer.Argument(help="Rows of text and stop (true or false), one JSON object a line.")],
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Count posts that stop a moving robot, and those that stop it falsely."""
    from agentrob.evals import stops as measure

    found = measure.evaluate_stops(file, limit)
    _print(found, measure.describe(found), as_json)


@eval_cli.command("injection")
def eval_injection(
    file: Rows,
    mind: Mind = "rules",
    robot: Kind = "go2",
    limit: Limit = None,
    as_json: AsJson = False,
    config: ConfigFile = None,
) -> None:
    """Count posts in which injected text changes the motion of the real command."""
    from agentrob.evals import injection as measure

    found = measure.evaluate_injections(file, mind, robot, app.load(config), limit)
    _print(found, measure.describe(found), as_json)
