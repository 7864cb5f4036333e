"""Without a configured model no model library is imported."""

from __future__ import annotations

import subprocess
import sys

LIBRARIES = ("pydantic_ai", "openai", "anthropic", "tiktoken")


def imported_by(code: str) -> set[str]:
    """Run code in a new process; return the model libraries that it imported."""
    told = f"{code}\nimport sys; print('LIBS', *sorted(m for m in {LIBRARIES!r} if m in sys.modules))"
    run = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, timeout=100, check=True)
    return set(run.stdout.split("LIBS", 1)[1].split())


def test_the_rules_import_no_model_library() -> None:
    code = """
import agentrob.cli.main
from agentrob.wiring import app, plan
from agentrob.config.load import parse
print(plan.plan_text("walk forward 1 m", "go2"))
app.make_mind("rules", parse({"minds": {"mm": {"provider": "openai", "model": "x"}}}))
import agentrob.agent.agent
"""
    assert imported_by(code) == set()


def test_a_model_mind_imports_libraries_only_when_called() -> None:
    code = """
from agentrob.wiring import app
from agentrob.config.load import parse
app.make_mind("mm", parse({"minds": {"mm": {"provider": "openai", "model": "x"}}}))
"""
    assert imported_by(code) == set()
    assert imported_by("import agentrob.minds.llm.provider") - {"tiktoken"} == {"pydantic_ai", "openai", "anthropic"}
