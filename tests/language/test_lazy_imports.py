"""`agentrob plan` answers at once: of what is heavy, it imports nothing."""

from __future__ import annotations

import subprocess
import sys

HEAVY = (
    "cn2an", "proces", "numpy", "PIL", "matplotlib", "mujoco", "onnxruntime", "cyclonedds", "unitree_sdk2py", "fastapi",
    "uvicorn", "sqlalchemy", "alembic", "jinja2", "httpx2", "rich", "structlog", "prometheus_client", "openai",
    "anthropic", "pydantic_ai", "linkify_it",
)  # fmt: skip


def test_reading_a_sentence_from_the_shell_imports_nothing_heavy() -> None:
    code = f"""
import sys
sys.argv = ["agentrob", "plan", "walk one and a half metres, turn left 90 degrees, 然后前进一百二十厘米"]
from agentrob.cli.main import cli
cli(standalone_mode=False)
print("HEAVY", *[name for name in {HEAVY!r} if name in sys.modules])
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=True)
    answer, heavy = run.stdout.split("HEAVY")
    assert answer.startswith("command")
    assert heavy.split() == []
