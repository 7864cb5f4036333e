"""Find words of harm in a post, by named rules.

Words are the weakest protection: somebody who wants to do harm can phrase it differently. Limits, the mandate and the
guard hold whatever the words are. These rules catch the plain cases, so that the answer can name the reason. The words
are in `words.en` and `words.zh`; every text is checked against all languages, and so is a sentence that mixes them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

from agentrob.language.locales.zh_loan_words import in_chinese
from agentrob.language.messages.catalog import quote, say
from agentrob.model import Decision, Language, Verdict
from agentrob.screening.text.patterns import Phrases, Vocabulary
from agentrob.screening.text.words import en as words_en
from agentrob.screening.text.words import zh as words_zh

#: Prefixes of phrases: none for actions that are harmful wherever they are done; one for phrases that may be harmless,
#: so that the robot asks back; one for places to go to, which count only if the post became a plan that would go there.
PREFIXES = ACTION, DOUBT, WAY = "", "?", ">"
#: Rules in the order in which they are checked. True: a negation takes the harm away ("don't hit it").
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
ENGLISH = Vocabulary(words_en.GROUPS, words=True)
CHINESE = Vocabulary(words_zh.GROUPS, words=False, letters="[\u3400-\u9fff]")
#: A clause that asks how, why or what: it wants to know something, not to do it. "How about" proposes.
_QUESTION = re.compile(
    r"(?:^|(?<=[.!?;\n,]))\s*(?:hi |hey |and |so |but )*"
    r"(?:how (?:do|does|can|could|should|would|did|to|is|are|much|many)"
    r"|why (?:do|does|did|is|are|was|were|would)\b(?! not)(?!n't)"
    r"|what (?:is|are|does|happens|if|should|do)\b)[^.!?;\n]*"
    r"|(?:如何|怎么样?才?能?|怎样|为什么|为何|什么是|是否|有没有办法)[^，。！？；,.!?;\n]*"
    r"|(?<![^，。！？；,.!?;\n])[^，。！？；,.!?;\n]*(?:是什么|什么意思|怎么办|怎么回事)(?=[，。！？；,.!?;\n]|$)"
)
#: A handle, with a verb or preposition before it that does something to the account. Chinese may follow it at once.
_MENTION = re.compile(
    r"(?:\b(?P<en>at|into|onto|over|behind|after|of|follow|chase|hit|kick|push|ram|scare|block|watch|track|attack|bite"
    r"|against)\s*|(?P<zh>撞|跟着|跟踪|踢|推|追|堵|挡|拍|吓|咬|打)\s*)?@[a-z][a-z0-9_-]*"
)


def harm_of(text: str, language: Language) -> Verdict | None:
    """Return a refusal with the rule and the words that broke it, or None. `text` is the visible text of a post."""
    for rule, words in _broken(plain_words(text), ACTION, WAY):
        return Verdict(Decision.REFUSE, rule, say(rule, language, words=quote(words)))
    return None


def clear_harm_of(text: str, language: Language) -> Verdict | None:
    """Return a refusal of a post without a plan: only for actions that are harmful wherever they are done.

    A place that the robot cannot walk to anyway ("go down the stairs") accuses nobody of anything, nor does a question
    about harm ("how do I prevent collisions").
    """
    for rule, words in _broken(_QUESTION.sub(" ", plain_words(text)), ACTION):
        return Verdict(Decision.REFUSE, rule, say(rule, language, words=quote(words)))
    return None


def doubt_of(text: str, language: Language) -> Verdict | None:
    """Return a question to ask before anything moves, because the words may mean harm, or None."""
    for rule, words in _broken(plain_words(text), DOUBT):
        key = rule if rule == "people.picture" else "beside.said"
        return Verdict(Decision.ASK_BACK, rule, say(key, language, words=quote(words)))
    return None


def _broken(plain: str, *prefixes: str) -> Iterator[tuple[str, str]]:
    """Yield (rule, words) of everything that is not negated, in the order of the rules."""
    chinese = in_chinese(plain)
    for rule, deniable in RULES.items():
        for prefix in prefixes:
            for found, denied in _found(rule, prefix, plain, chinese):
                if not (deniable and denied):
                    yield rule, found


def plain_words(text: str) -> str:
    """Return the text with lower case, straight quotes, simplified characters and single spaces; line ends stay.

    A mention is a name, whatever it spells ("@cat, sit"): it becomes "somebody" or 别人 if something is done to the
    account, otherwise a space.
    """
    straight = text.casefold().translate(words_zh.TWINS).replace("’", "'").replace("‘", "'")
    return re.sub(r"[^\S\n]+", " ", _MENTION.sub(_without_handle, straight))


def _without_handle(mention: re.Match[str]) -> str:
    if mention["zh"]:
        return f"{mention['zh']}别人"
    return f"{mention['en']} somebody" if mention["en"] else " "


def prepare() -> None:
    """Compile all patterns (about 0.4 s), so that stops do not wait for compilation while a process serves."""
    for rule in RULES:
        for prefix in PREFIXES:
            for _, phrases, _ in phrases_of(rule, prefix):
                phrases.prepare()


def _found(rule: str, prefix: str, plain: str, chinese: str) -> Iterator[tuple[str, bool]]:
    """Yield the words that break a rule, and whether a negation precedes them."""
    for vocabulary, phrases, denial in phrases_of(rule, prefix):
        text = chinese if vocabulary is CHINESE else plain
        for match in phrases.finditer(text):
            before = text[max(0, match.start() - 60) : match.start()]
            yield match[0], denial.search(before) is not None


@cache
def phrases_of(rule: str, prefix: str) -> tuple[tuple[Vocabulary, Phrases, re.Pattern[str]], ...]:
    """Return a rule's phrases with this prefix, and what denies them, per language."""
    made = []
    for vocabulary, locale in ((ENGLISH, words_en), (CHINESE, words_zh)):
        kinds = {phrase: phrase[0] if phrase[0] in (DOUBT, WAY) else ACTION for phrase in locale.RULES[rule]}
        if phrases := [phrase.removeprefix(prefix) for phrase, kind in kinds.items() if kind == prefix]:
            made.append((vocabulary, Phrases(vocabulary, phrases), re.compile(locale.DENIED)))
    return tuple(made)
