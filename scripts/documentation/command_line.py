"""The reference of the command line, made by Typer from the program itself."""

from __future__ import annotations

import html
import re
import subprocess
import sys

INTRODUCTION = """# Command line

Every command and option of `agentrob`, as `agentrob COMMAND --help` prints them. After `make setup`,
`. .venv/bin/activate` in the checkout puts `agentrob` on your path.

"""


def page() -> str:
    """Return the page: a section for each command."""
    made = subprocess.run(
        [sys.executable, "-m", "typer", "agentrob.cli.main", "utils", "docs", "--name", "agentrob"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    sections = made[made.index("\n## ") + 1 :]
    # Typer's lists of commands are cut after some words; the sections have the whole sentences.
    sections = re.sub(r"\*\*Commands\*\*:\n\n(?:\* .*\n)+\n?", "", sections)
    sections = re.sub(r"^\* `--help`: .*\n", "", sections, flags=re.MULTILINE)
    sections = re.sub(r"\*\*Options\*\*:\n\n(?=\n*(?:#|\Z))", "", sections)
    # Typer escapes for HTML what is code in Markdown too.
    sections = re.sub(r"`([^`\n]+)`", lambda m: f"`{html.unescape(m[1])}`", sections)
    return INTRODUCTION + sections
