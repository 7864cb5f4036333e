"""Let a model review a command that the rules allow: it can only add a refusal, never lift one (law 7).

The model gets the post as data, the plan in our words and what was done before in the thread. It has no tools and
answers in a closed schema: fine or refuse, which kind of harm, which words. People read our own sentence for that kind.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

from agentrob.config.robots import SCENE_CHARS
from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.plan_text import sentence
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.errors import ModelError, one_line
from agentrob.minds.llm.prompt import HISTORY_PLANS, clean, post_as_data, prompts
from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Decision, Language, Plan, Verdict

#: Kinds of harm (law 7). `other`: refused without a kind.
Harm = Literal["people", "animals", "property", "bounds", "safety", "deception", "surveillance", "abilities", "other"]


#: Longest quotation and reason that are kept from an answer.
TOLD_CHARS = 300
#: What models write if there is no harm.
_NO_HARM = frozenset(["", "none", "null", "no", "na", "nothing", "false", "fine", "unknown"])
_FINE = re.compile(r"fine\W*\Z", re.IGNORECASE)
_REFUSE = re.compile(r"\W*(?:refus|den[iy]|reject|block|forbid|prohibit|declin|unsafe|no\b|not\b)", re.IGNORECASE)


def _decision(given: Any) -> Any:
    """Return fine or refuse; return anything else as it is, for the schema to reject."""
    text = str(given).strip()
    return "refuse" if _REFUSE.match(text) else "fine" if _FINE.match(text) else given


class Judgement(BaseModel):
    """A model's answer about a command."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _normalise(cls, data: Any) -> Any:
        """Accept refusals in other spellings: another case, an unknown kind of harm, texts that are too long."""
        if not isinstance(data, dict):
            return data
        data = {str(key).lower().strip(): value for key, value in data.items()}
        data.setdefault("why", data.pop("reason", None) or "")
        data["decision"] = _decision(data.get("decision"))
        harm = re.sub(r"\W", "", str(data.get("harm") or "").lower())
        data["harm"] = None if harm in _NO_HARM else harm if harm in get_args(Harm) else "other"
        for name in ("words", "why"):
            data[name] = str(data.get(name) or "")[:TOLD_CHARS]
        return data

    @classmethod
    def from_broken(cls, text: str) -> Self | None:
        """Return a refusal found in an answer that is not complete JSON; None without one."""
        found = re.findall(r"[\"']decision[\"']\s*:\s*[\"']([^\"'\n]{1,40})", text, re.IGNORECASE)
        refused = found and _decision(found[-1]) == "refuse"
        return cls(decision="refuse", why="the answer broke off") if refused else None

    @property
    def refuses(self) -> bool:
        """Whether it refuses; naming a harm is a refusal too."""
        return self.decision == "refuse" or self.harm is not None

    decision: Literal["fine", "refuse"]
    harm: Harm | None = Field(default=None, description="the kind of harm; null when it is fine")
    words: Annotated[str, Field(max_length=TOLD_CHARS)] = Field(
        default="", description="the words of the post that are the reason, copied letter by letter"
    )
    why: Annotated[str, Field(max_length=TOLD_CHARS)] = Field(
        default="", description="one short sentence, for the record"
    )


@dataclass(frozen=True, slots=True)
class SafetyReview:
    """The result of a model's review.

    `refusal` is None if the model does not object, and if it did not answer; then `failed` says why (an `ErrorKind`).
    `why` is the model's own sentence, untrusted, for records only. `usage` is what the review cost.
    """

    mind: str
    refusal: Verdict | None = None
    failed: str = ""
    why: str = ""
    usage: tuple[Usage, ...] = ()


async def review_command(
    model: ChatModel,
    text: str,
    plan: Plan,
    capabilities: Capabilities,
    language: Language,
    history: Sequence[Plan] = (),
    scene: str = "",
    spent: Sequence[Usage] = (),
    limit_s: float | None = None,
    goal: str = "",
) -> SafetyReview:
    """Ask a model about a command; never raises if the model fails.

    `text` is the part of the post for this robot, `scene` what is known about its surroundings, `goal` in our words
    what to look for, including the plan's steps. `limit_s` defaults to the model's own limit.
    """
    part = clean(text)
    system_prompt, begins = prompts(capabilities, "screen", model.shares_prompt)
    message = begins + _message(part, goal or sentence(plan, "en"), capabilities, history, scene)
    limit_s = model.limit_s if limit_s is None else limit_s
    try:
        async with asyncio.timeout(limit_s):
            answer = await model.answer(system_prompt, message, Judgement, spent=spent)
    except ModelError as e:
        return SafetyReview(model.name, failed=e.kind, usage=e.usage)
    except TimeoutError:
        lost = Usage(model.name, "", latency_ms=limit_s * 1e3, failed="timeout")
        return SafetyReview(model.name, failed="timeout", usage=(lost,))
    refusal = refusal_of(answer.value, part, language)
    return SafetyReview(answer.mind, refusal, why=one_line(answer.value.why, limit=300), usage=answer.usage)


def refusal_of(judgement: Judgement, text: str, language: Language) -> Verdict | None:
    """Return the refusal in our words; None if the model does not object. Pure."""
    if not judgement.refuses:
        return None
    harm = judgement.harm or "other"
    words = _quoted(judgement.words, text)
    key = "minds.screen.words" if words else "minds.screen.reason"
    reason = say(key, language, reason=say(f"minds.screen.{harm}", language), words=words)
    return Verdict(Decision.REFUSE, f"model.{harm}", reason)


def apply_review(
    by_rules: Verdict, screened: SafetyReview | None, language: Language, required: bool = False
) -> Verdict:
    """Return the rules' verdict, or the review's refusal. Pure.

    A review never changes what the rules do not allow; what needs an approval can still be refused. `required`: the
    owner wants every command reviewed before it moves; without a review the robot asks back.
    """
    if by_rules.decision not in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        return by_rules
    if screened is not None and screened.refusal is not None and screened.refusal.decision is not Decision.ALLOW:
        return screened.refusal
    if required and (screened is None or screened.failed):
        return Verdict(Decision.ASK_BACK, "screen.required", say("minds.screen.required", language))
    return by_rules


def harms() -> tuple[str, ...]:
    """Return every kind of harm that a model may name."""
    return get_args(Harm)


def _message(part: str, understood: str, capabilities: Capabilities, history: Sequence[Plan], scene: str) -> str:
    limits = capabilities.limits
    facts: dict[str, Any] = {
        "robot": capabilities.model,
        "it understood": understood,
        "done before in this thread, oldest first": [sentence(p, "en") for p in history[-HISTORY_PLANS:]],
        "its speed is at most": f"{limits.speed_mps:g} m/s",
    }
    if scene:
        facts["around it"] = " ".join(clean(scene)[:SCENE_CHARS].split())
    return f"{json.dumps(facts, ensure_ascii=False)}\n{post_as_data(part)}"


def _quoted(words: str, text: str) -> str:
    """Return the words as code if they are in the post, otherwise an empty string: only the post's own words are
    shown.
    """
    parts = clean(words).split()
    match = re.search(r"\s+".join(map(re.escape, parts)), text, re.IGNORECASE) if parts else None
    return quote(match[0]) if match else ""
