"""A model's second look at a command that the rules let pass: it can only add a refusal, never lift one (law 7).

It gets the post as data, the plan in our words and what was done before in the thread; it holds no tools and answers in
a closed schema: fine or refuse, which kind of harm, which words. What people read is our own sentence for that kind.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

from agentrob.config.load import SCENE_CHARS
from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.plan_text import sentence
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.errors import ModelError, one_line
from agentrob.minds.llm.prompt import HISTORY_PLANS, clean, post_as_data, prompts
from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Decision, Language, Plan, Verdict

#: The kinds of harm, as law 7's screening names them. `other`: refused without saying which.
Harm = Literal["people", "animals", "property", "bounds", "safety", "deception", "surveillance", "abilities", "other"]


#: The longest words and reasons that are kept of an answer.
TOLD_CHARS = 300
#: What models write where there is no harm.
_NO_HARM = frozenset(["", "none", "null", "no", "na", "nothing", "false", "fine", "unknown"])
_FINE = re.compile(r"fine\W*\Z", re.IGNORECASE)
_REFUSE = re.compile(r"\W*(?:refus|den[iy]|reject|block|forbid|prohibit|declin|unsafe|no\b|not\b)", re.IGNORECASE)


def _decision(given: Any) -> Any:
    """fine or refuse; whatever else was said, for the schema to refuse."""
    text = str(given).strip()
    return "refuse" if _REFUSE.match(text) else "fine" if _FINE.match(text) else given


class Judgement(BaseModel):
    """What a model says of a command."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _read_as_it_was_meant(cls, data: Any) -> Any:
        """A refusal counts however it is spelt: another case, a kind of harm of the model's own, too many words."""
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
        """A refusal that can be read in an answer which is no whole JSON object; None without one."""
        found = re.findall(r"[\"']decision[\"']\s*:\s*[\"']([^\"'\n]{1,40})", text, re.IGNORECASE)
        refused = found and _decision(found[-1]) == "refuse"
        return cls(decision="refuse", why="the answer broke off") if refused else None

    @property
    def refuses(self) -> bool:
        """Who names a harm refuses."""
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
    """What a model had against a command.

    `refusal` is None when it had nothing against it, and when it did not answer; then `failed` says why (a word of
    `ErrorKind`). `why` is its own sentence, untrusted, for records only. `usage` is what it took.
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
    """Ask a model about a command. `text` is the part of the post for this robot, `scene` what is known to be around,
    `goal` in our words what is to be looked for, with the plan's steps in it. `limit_s`: the model's own unless given.

    Never raises for a model that fails.
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
    """The refusal in our words; None when the model has nothing against it. Pure."""
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
    """The rules' verdict, or a refusal more. Pure: whatever a model says, what the rules do not allow stays so (what
    needs an approval may still have one, so there it counts too).

    `required`: the owner wants no motion without a model's look; then it is asked back where none could be had.
    """
    if by_rules.decision not in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        return by_rules
    if screened is not None and screened.refusal is not None and screened.refusal.decision is not Decision.ALLOW:
        return screened.refusal
    if required and (screened is None or screened.failed):
        return Verdict(Decision.ASK_BACK, "screen.required", say("minds.screen.required", language))
    return by_rules


def harms() -> tuple[str, ...]:
    """Every kind of harm that a model may name."""
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
    """The words as code when they do stand in the post; nothing otherwise: what is shown is the post's own."""
    parts = clean(words).split()
    match = re.search(r"\s+".join(map(re.escape, parts)), text, re.IGNORECASE) if parts else None
    return quote(match[0]) if match else ""
