"""Lists and tables are shown on the site as code hosts show them."""

from __future__ import annotations

import pytest

from scripts.documentation.commonmark import rewrite


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("Robots:\n- a\n- b", "Robots:\n\n- a\n- b"),
        ("- a\n  goes on\n- b", "- a\n    goes on\n- b"),
        ("- a\n  - b\n  - c\n- d", "- a\n    - b\n    - c\n- d"),
        ("1. a\n\n   ```sh\n   x  y\n   ```\n2. b", "1. a\n\n    ```sh\n    x  y\n    ```\n2. b"),
        ("5. a:\n   | x |\n   |---|", "5. a:\n\n    | x |\n    |---|"),
        ("- a\n\nA paragraph.", "- a\n\nA paragraph."),
        ("- a\n\n    Already so.", "- a\n\n    Already so."),
        ("3. a\n\n    ```sh\n    x\n      y\n    ```", "3. a\n\n    ```sh\n    x\n      y\n    ```"),
        ("```text\nRobots:\n- a\n```", "```text\nRobots:\n- a\n```"),
        ("# Title\n- a", "# Title\n- a"),
        ("Text\n| a |\n|---|\n| b |", "Text\n\n| a |\n|---|\n| b |"),
    ],
)
def test_a_document_is_rewritten(written: str, read: str) -> None:
    assert rewrite(written) == read
