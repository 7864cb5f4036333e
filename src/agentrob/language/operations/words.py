"""The vocabulary of a language together with the words of the operations that a robot declares."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import product

from agentrob.language.locale import Locale
from agentrob.language.parser.lexicon import Lexicon, TokenKind, lexicon
from agentrob.language.registry import DEFAULT, locale
from agentrob.model import Choice, Language, Number, Operation, Unit

_SLOT = re.compile(r"\{([a-z0-9_]+)\}")
#: The most phrases that the options of one phrase make.
_MOST_COMBINATIONS = 400
_UNITS = {
    Unit.METRES: TokenKind.LENGTH_UNIT, Unit.DEGREES: TokenKind.ANGLE_UNIT, Unit.SECONDS: TokenKind.TIME_UNIT,
    Unit.METRES_PER_SECOND: TokenKind.SPEED_UNIT,
}  # fmt: skip
#: A percentage is a number for the grammar; these words beside it mean nothing else.
_PERCENT = {"en": "%|percent|per cent", "zh": "百分之|%"}


def locale_of(language: Language, declared: tuple[Operation, ...]) -> Locale:
    """Return a language with the words of a robot's own operations. English words belong to every language."""
    return _extended(language, declared) if declared else locale(language)


@lru_cache(maxsize=128)
def own_words(declared: tuple[Operation, ...]) -> frozenset[str]:
    """Return the words of a robot's own operations, in lower case: one that is also its name keeps its meaning."""
    said = (words.lower() for operation in declared for words in operation.words.values())
    return frozenset(word for words in said for word in re.split(r"[\s|{}]+", words) if word)


@lru_cache(maxsize=128)
def _extended(language: Language, declared: tuple[Operation, ...]) -> Locale:
    known = locale(language)
    table: dict[str, list[str]] = {}
    idioms: list[tuple[str, str]] = []
    phrases = list(_phrases_of(declared, language, known.words))
    for meaning, phrase in phrases:
        if not _SLOT.search(phrase):
            table.setdefault(meaning, []).append(phrase)
    for meaning, phrase in phrases:
        if slot := _SLOT.search(phrase):
            plain = table.setdefault(meaning, [_SLOT.sub(" ", phrase)])[0]
            idioms.append(_idiom(phrase, plain, slot, declared, known.words))
    words = _with(known.words, {meaning: "|".join(phrases) for meaning, phrases in table.items()})
    return replace(known, words=words, idioms=(*idioms, *known.idioms))


def _with(words: Lexicon, table: Mapping[str, str]) -> Lexicon:
    return lexicon(
        words.language, table, words.number,
        numerals=words.numerals, twins=words.twins, misread=words.misread, extends=words,
    )  # fmt: skip


def phrases_of(operation: Operation, language: Language) -> tuple[str, ...]:
    """Return every phrase by which a robot's own operation is understood in a language, with the options of its
    choices in it; numbers stay as they are written in the declaration."""
    return tuple(dict.fromkeys(phrase for _, phrase in _of_operation(operation, language)))


def _phrases_of(declared: Sequence[Operation], language: Language, words: Lexicon) -> Iterator[tuple[str, str]]:
    """Yield (meaning in the lexicon's notation, phrase)."""
    for operation in declared:
        for said in dict.fromkeys((language, DEFAULT)):
            if said in operation.words or said == DEFAULT:
                yield from _of_operation(operation, said)
            for argument in operation.arguments:
                if isinstance(argument, Choice):
                    yield from _of_options(argument, said, words)
    if any(isinstance(a, Number) and a.unit is Unit.PERCENT for operation in declared for a in operation.arguments):
        yield "soft", _PERCENT.get(language, _PERCENT[DEFAULT])


def _of_operation(operation: Operation, language: Language) -> Iterator[tuple[str, str]]:
    choices = {a.name: a for a in operation.arguments if isinstance(a, Choice)}
    for phrase in operation.phrases(language):
        slots = [name for name in _SLOT.findall(phrase) if name in choices]
        for meaning, said in _chosen(f"op={operation.name}", phrase, [choices[name] for name in slots], language):
            yield meaning, said
            behind = [choice for name, choice in choices.items() if name not in slots]
            for count in range(1, len(behind) + 1):
                joint = "" if language == "zh" else " "
                longer = said + "".join(f"{joint}{{{choice.name}}}" for choice in behind[:count])
                yield from _chosen(meaning, longer, behind[:count], language)


def _chosen(meaning: str, phrase: str, choices: Sequence[Choice], language: Language) -> Iterator[tuple[str, str]]:
    """Yield a phrase with each combination of the options of its choices."""
    each = [[(choice, name, words) for name, words in _options(choice, language)] for choice in choices]
    for number, combination in enumerate(product(*each)):
        if number == _MOST_COMBINATIONS:
            return
        said, means = phrase, meaning
        for choice, name, words in combination:
            said = said.replace(f"{{{choice.name}}}", words)
            means += f" argument={choice.name}={name}"
        yield means, said


def _options(choice: Choice, language: Language) -> Iterator[tuple[str, str]]:
    for option in choice.options:
        for words in option.words.get(language, option.words.get(DEFAULT, option.name)).split("|"):
            yield option.name, words.strip()


def _of_options(choice: Choice, language: Language, known: Lexicon) -> Iterator[tuple[str, str]]:
    """Yield the options as words of their own, as far as they mean nothing else: "light up in red"."""
    for name, words in _options(choice, language):
        if not set(words.lower().split()) & known.vocabulary:
            yield f"argument={choice.name}={name}", words


def _idiom(
    phrase: str, plain: str, slot: re.Match[str], declared: Sequence[Operation], words: Lexicon
) -> tuple[str, str]:
    """Return how a phrase with a number in it is said with one that has none: 吹3秒泡泡 is 吹泡泡 3 秒."""
    numbers = (a for operation in declared for a in operation.arguments if isinstance(a, Number))
    unit = next((number.unit for number in numbers if number.name == slot[1]), Unit.COUNT)
    kind = _UNITS.get(unit)
    units = {"".join(p) if words.language == "zh" else " ".join(p) for p, m in words.phrases.items() if m[0][0] is kind}
    one_of = "|".join(sorted(map(re.escape, units), key=lambda one: (-len(one), one)))
    numerals = "|".join(sorted(map(re.escape, words.numerals), key=lambda one: (-len(one), one)))
    value = rf"(?:\d[\d./]*|(?:{numerals})(?:[ -]?(?:{numerals}))*|an?)" if numerals else r"\d[\d./]*"
    amount = rf"(?P<amount>{value}\s*{f'(?:{one_of})' if one_of else ''})"
    before, after = phrase[: slot.start()].strip(), phrase[slot.end() :].strip()
    pattern = rf"{re.escape(before)}\s*{amount}\s*(?:of\s+|的)?{re.escape(after)}"
    return pattern, plain + r" \g<amount> "
