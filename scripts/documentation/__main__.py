"""Build the documentation site into build/site, or into another folder.

    .venv/bin/python -m scripts.documentation [FOLDER]

FOLDER gets `docs/` (the pages of the repository, and the generated reference), `zensical.toml` and `site/`. Generated
pages are not committed: they follow from the code, and a committed copy would be stale or in conflict in each change
of a key or an option. A broken link, a missing page or a page that the navigation does not list ends the build with an
error.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from scripts.documentation.pages import ROOT, unlisted, write_pages


def build(folder: Path) -> int:
    """Write the pages into `folder` and build the site there. Return the exit code."""
    write_pages(folder / "docs")
    if pages := unlisted(folder / "docs"):
        sys.stderr.write(f"documentation: not in the navigation of zensical.toml: {', '.join(pages)}\n")
        return 1
    shutil.rmtree(folder / "site", ignore_errors=True)
    shutil.copy(ROOT / "zensical.toml", folder)
    command = [str(Path(sys.executable).with_name("zensical")), "build", "--strict", "--clean"]
    code = subprocess.run([*command, "-f", folder / "zensical.toml"], cwd=ROOT, check=False).returncode
    if code == 0:
        sys.stdout.write(f"documentation: to read it, run python3 -m http.server --directory {folder / 'site'}\n")
    return code


if __name__ == "__main__":
    sys.exit(build(Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build").resolve()))
