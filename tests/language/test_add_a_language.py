"""A language is one file: the one in the documentation is put beside the others, and robots speak it."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from agentrob.agent.understanding.extract import Assessment
from agentrob.language import addressing, locales
from agentrob.language.messages.catalog import say
from agentrob.language.messages.help import help_text
from agentrob.language.messages.plan_text import sentence
from agentrob.language.registry import known
from agentrob.language.stop import at_rest
from agentrob.language.stop.at_rest import stop_intent
from agentrob.model import Capabilities, Direction, Intent, Op, Primitive
from tests.language.saying import read, short, turn, walk

PAGE = Path(__file__).parents[2] / "docs/inside/languages.md"
SPANISH = "es"


def _forget() -> None:
    for cached in (known, at_rest.stop_words, addressing.together):
        cached.cache_clear()
    sys.modules.pop(f"{locales.__name__}.{SPANISH}", None)


@pytest.fixture
def spanish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / f"{SPANISH}.py").write_text(code, encoding="utf-8")
    monkeypatch.setattr(locales, "__path__", [*locales.__path__, str(tmp_path)])
    _forget()
    yield
    monkeypatch.undo()
    _forget()


@pytest.mark.usefixtures("spanish")
@pytest.mark.parametrize(
    ("text", "plan"),
    [
        ("camina 2 metros hacia adelante, luego gira a la izquierda noventa grados", "F2 l90"),
        ("@quadruped por favor retrocede medio metro y saluda", "B0.5 hello"),
        ("da media vuelta y toma una foto", "l180 photo"),
        ("gira a la izquierda 30 grados, digo a la derecha", "r30"),
        ("camina 1 m, no gira", "F1"),
        ("camina un poco", None),
        ("no gira a la izquierda", ""),
        ("camina 1 m si puedes ver un gato", None),
        ("ayer camina 2 m", ""),
        ("vuela a la izquierda 2 m", None),
    ],
)
def test_a_language_of_one_file_is_understood(text: str, plan: str | None) -> None:
    understood = read(text)
    assert understood.language == SPANISH
    assert understood.intent is {None: Intent.ASK_BACK, "": Intent.NOTHING}.get(plan, Intent.COMMAND)
    assert short(understood.plan) == (plan or "")


@pytest.mark.usefixtures("spanish")
def test_robots_answer_in_it_and_in_english_where_it_has_no_sentence() -> None:
    assert read("camina").question == (
        "¿Cuánto? `camina` no dice la distancia, y no adivino. No me moví. Por ejemplo: `camina 1 m hacia adelante`"
    )
    assert "What I can do" in help_text(Capabilities("go2", frozenset(Op)), "quadruped", SPANISH)


@pytest.mark.usefixtures("spanish")
def test_reports_are_in_it_too_and_journals_keep_it() -> None:
    assert say("agent.done", SPANISH) == "**Hecho.**"
    assert say("agent.failed", SPANISH, step=2) == say("agent.failed", "en", step=2)
    thought = Assessment(read("gira a la izquierda 30 grados"), "rules")
    kept = TypeAdapter(Assessment)
    assert kept.validate_json(kept.dump_json(thought)) == thought


@pytest.mark.usefixtures("spanish")
def test_its_steps_are_read_as_what_they_say() -> None:
    steps = (walk(Direction.BACKWARD, 0.5), turn(Direction.RIGHT, 45.0), Primitive(Op.HELLO))
    assert read(sentence(steps, SPANISH)).plan.steps == steps


@pytest.mark.usefixtures("spanish")
@pytest.mark.parametrize(
    "text", ["stop", "@quadruped 停!", "please stop now", "para", "¡Alto, por favor!", "no te muevas"]
)
def test_law_13_a_further_language_adds_stops_and_takes_none_away(text: str) -> None:
    assert stop_intent(text) is Intent.STOP


@pytest.mark.usefixtures("spanish")
def test_the_others_are_as_they_were() -> None:
    assert short(read("walk forward 1 m, then turn left 30 degrees").plan) == "F1 l30"
    assert short(read("向前走一米").plan) == "F1"
    assert stop_intent("camina, para") is None


def test_there_are_english_and_chinese() -> None:
    assert list(known()) == ["en", "zh"]
