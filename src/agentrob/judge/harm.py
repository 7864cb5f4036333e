"""Words of harm, as named rules over the text of a post.

Words are the weakest of the protections: whoever wants to do harm can say it otherwise. The limits, the mandate and the
guard hold whatever the words are; these rules are for the plain cases, so that the answer names the reason. The words
stand by language in `words_en` and `words_zh`; all languages are looked for in every text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache

from agentrob.judge import words_en, words_zh
from agentrob.judge.patterns import compiled
from agentrob.judge.sentences import say
from agentrob.language.phrases import quote
from agentrob.model import Decision, Language, Verdict

#: In the order in which they are asked: the first that objects names the refusal. True: "don't hit it" is no harm.
RULES = {
    "safety.disable": False,
    "who.claim": True,
    "harm.attack": True,
    "harm.fall": True,
    "harm.destroy": True,
    "harm.collide": True,
    "harm.hazard": True,
    "people.watch": False,
    "people.follow": False,
    "people.block": False,
    "people.trick": True,
    "safety.secret": False,
    "bounds.leave": True,
    "way.unaware": False,
    "people.picture": True,
}
#: These only ask back: the words may well be harmless.
ASKING = frozenset(["people.picture"])


def harm_of(text: str, language: Language) -> Verdict | None:
    """A refusal with the rule and the words that broke it, or None. `text` is the visible text of a post."""
    return _verdict(text, language, [rule for rule in RULES if rule not in ASKING], Decision.REFUSE)


def doubt_of(text: str, language: Language) -> Verdict | None:
    """What must be asked back before anything moves, since the words may mean harm, or None."""
    return _verdict(text, language, [rule for rule in RULES if rule in ASKING], Decision.ASK_BACK)


def _verdict(text: str, language: Language, rules: Sequence[str], decision: Decision) -> Verdict | None:
    plain = plain_words(text)
    for rule in rules:
        for found, denied in _found(rule, plain):
            if not (RULES[rule] and denied):
                return Verdict(decision, rule, say(rule, language, quote(found)))
    return None


def plain_words(text: str) -> str:
    """Small letters, straight quotes, simplified characters, single spaces; lines stay apart."""
    straight = text.casefold().translate(words_zh.TWINS).replace("’", "'").replace("‘", "'")
    return re.sub(r"[^\S\n]+", " ", straight)


def _found(rule: str, plain: str) -> Iterator[tuple[str, bool]]:
    """The words that break a rule, and whether a "not" stands before them."""
    for pattern, denial in _patterns(rule):
        for match in pattern.finditer(plain):
            before = plain[max(0, match.start() - 60) : match.start()]
            yield match[0], denial.search(before) is not None


@cache
def _patterns(rule: str) -> tuple[tuple[re.Pattern[str], re.Pattern[str]], ...]:
    """Compiled when first needed: they are many."""
    made = []
    for tongue, words in ((words_en, True), (words_zh, False)):
        if phrases := tongue.RULES.get(rule):
            made.append((compiled(tongue.GROUPS, phrases, words=words), re.compile(tongue.DENIED)))
    return tuple(made)
