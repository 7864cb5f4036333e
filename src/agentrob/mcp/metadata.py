"""The tag at the start of each post that an agent writes: kind of agent, account, status, trace id.

    > [agent_type=commanding agent_id=planner status=asking trace=3f…]

It is a quotation, which robots never read as a command, and is built from the authenticated account, never from
arguments. Text of the caller that looks like a tag is disarmed. A tag is valid only at the very start of a post by the
account that it names; anywhere else it is text.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from agentrob.model import Account, AccountKind

#: `assistant` is a program that writes for the person whose account it uses.
AGENT_TYPES = {
    AccountKind.HUMAN: "assistant",
    AccountKind.COMMANDING_AGENT: "commanding",
    AccountKind.ROBOT_AGENT: "robot",
    AccountKind.MONITORING_AGENT: "monitoring",
}
_TAG = re.compile(
    r"> \[agent_type=(?P<type>[a-z]+) agent_id=(?P<id>[A-Za-z0-9_.-]{1,64}) status=(?P<status>[a-z][a-z0-9_]{0,31})"
    r"(?: trace=(?P<trace>[0-9a-f]{8,64}))?\]\s*(?:\n|$)\s*"
)
_NAME_CHARS = re.compile(r"[^A-Za-z0-9_.-]")
#: An opening bracket after folding, then a word of the tag, with up to three separators inside.
_LOOKS_LIKE = re.compile(r"[\[【〔⟦](?=[\W_]{0,3}agent[\W_]{0,3}(?:type|id|status|kind|name))", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Tag:
    """The fields of a valid tag."""

    type: str
    status: str
    trace_id: str = ""


def with_tag(body: str, author: Account, status: str, trace_id: str) -> str:
    """The text to post: the account's tag, then the caller's text with disarmed tags."""
    name = _NAME_CHARS.sub("-", author.name)[:64] or "-"
    kind = AGENT_TYPES[author.kind]
    trace = f" trace={trace_id}" if trace_id else ""
    return f"> [agent_type={kind} agent_id={name} status={status}{trace}]\n\n{disarm_tags(body)}"


def split_tag(raw: str, author: Account) -> tuple[str, Tag | None]:
    """A post's text without its tag, and the tag if it is valid: it names the author and the author's kind."""
    found = _TAG.match(raw)
    name = _NAME_CHARS.sub("-", author.name)[:64]
    if not found or found["id"] != name or found["type"] != AGENT_TYPES[author.kind]:
        return raw, None
    return raw[found.end() :], Tag(found["type"], found["status"], found["trace"] or "")


def disarm_tags(text: str) -> str:
    """Replace brackets that would open a tag, also where letters are full-width or separated by invisible
    characters."""
    folded, places = _folded(text)
    marks = [places[m.start()] for m in _LOOKS_LIKE.finditer(folded)]
    if not marks:
        return text
    letters = list(text)
    for at in marks:
        letters[at] = "(not a tag: "
    return "".join(letters)


def _folded(text: str) -> tuple[str, list[int]]:
    """The text in NFKC without invisible characters, and for each character its index in the original."""
    out: list[str] = []
    places: list[int] = []
    for at, char in enumerate(text):
        if char.isascii():
            out.append(char)
            places.append(at)
        elif unicodedata.category(char) not in ("Cf", "Mn", "Me", "Cc"):
            for folded in unicodedata.normalize("NFKC", char):
                out.append(folded)
                places.append(at)
    return "".join(out), places
