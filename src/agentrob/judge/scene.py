"""What is harmless elsewhere and dangerous here: words of a post against a description of the place."""

from __future__ import annotations

from agentrob.model import Language, Plan, Verdict


def harm_in_scene(text: str, scene: str, plan: Plan | None, language: Language) -> Verdict | None:
    return None
