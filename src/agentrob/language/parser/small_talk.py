"""Classify posts without a command: "never mind", a question, a report of the past, a greeting."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from agentrob.language.parser.drafts import RemarkKind, Sentence


class SmallTalk(StrEnum):
    """Posts other than commands, stops, help and status. None of them moves anything."""

    CANCEL = "cancel"  # what its author posted before is not wanted any more
    QUESTION = "question"  # or a request for a report: "let me know when …"
    PAST = "past"  # tells what was
    GREETING = "greeting"
    ASSENT = "assent"  # "yes", "go ahead", "please": a command is missing
    THANKS = "thanks"  # or other manners alone


def small_talk_in(sentences: Sequence[Sentence]) -> SmallTalk | None:
    """Return the first that applies: cancel, question, past, greeting, assent, thanks."""
    if any(s.cancelled for s in sentences):
        return SmallTalk.CANCEL
    if any(s.question or s.asked or any(r.kind is RemarkKind.WISH for r in s.remarks) for s in sentences):
        return SmallTalk.QUESTION
    if any(s.report for s in sentences):
        return SmallTalk.PAST
    if not all(s.says_nothing for s in sentences):
        return None
    if any(s.greeted for s in sentences):
        return SmallTalk.GREETING
    assents = any(s.assents for s in sentences) and not any(s.thanked for s in sentences)
    return SmallTalk.ASSENT if assents else SmallTalk.THANKS
