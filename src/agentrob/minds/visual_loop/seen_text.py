"""Describe a detector's findings in words: "a red ball, about 20° to the left". Pure."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.eyes.sight import Seen
from agentrob.language.messages.catalog import quote, say
from agentrob.minds.visual_loop.vocabulary import chinese, colours, things
from agentrob.model import Language

#: What is nearer to the middle of the picture is straight ahead.
AHEAD_DEG = 2.5
#: The most things that a sentence names.
MOST_NAMED = 8
_VOWELS = "aeiou"


def thing_text(thing: str, colour: str, language: Language) -> str:
    """Return a thing with its colour: "a red ball", "something blue"."""
    thing, colour = _known(thing), _known(colour)
    if language == "zh":
        text = f"{chinese(colour)}的" if colour else ""
        return text + (chinese(thing) if thing else "东西")
    if not thing:
        return f"something {colour}".strip()
    words = f"{colour} {thing}".strip()
    return f"{'an' if words[:1] in _VOWELS else 'a'} {words}"


def seen_text(one: Seen, language: Language) -> str:
    """Return a thing and where it is: "a red ball, about 20° to the left"."""
    degrees = abs(one.left_deg)
    where = "ahead" if degrees < AHEAD_DEG else "left" if one.left_deg > 0 else "right"
    thing = thing_text(one.thing, one.colour, language)
    return say(f"eyes.where.{where}", language, thing=thing, degrees=f"{degrees:.0f}")


def colours_text(seen: Sequence[Seen], language: Language) -> str:
    """Return the sentence that names all that was seen."""
    if not seen:
        return say("eyes.no_colours", language)
    text = [seen_text(one, language) for one in seen[:MOST_NAMED]]
    return say("eyes.colours", language, things=("；" if language == "zh" else "; ").join(text))


def mark_text(one: Seen) -> str:
    """Return the label of a thing in a picture."""
    return " ".join(word for word in (one.colour, one.thing or "thing") if word)[:40]


def _known(word: str) -> str:
    """Return a word of the vocabulary as it is, and any other, which a detector of the owner's says, as code."""
    return word if not word or word in set(things("en").values()) | set(colours("en").values()) else quote(word)
