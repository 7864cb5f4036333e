"""Find hazards that the post itself describes in the robot's way: "There is a child in front of you. Walk 2 m."

The grammar ignores statements. Here they are searched for people, drops and things with a position, and compared with
the path of the plan. The guard detects the obstacles that are really there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

from agentrob.language.messages.catalog import quote, say
from agentrob.language.parser.amounts import with_amounts
from agentrob.language.parser.lexicon import Token, TokenKind, tokens_of
from agentrob.language.registry import locale
from agentrob.model import ActionClass, Decision, Direction, Language, Plan, Verdict
from agentrob.screening.text.harm import CHINESE, ENGLISH, plain_words
from agentrob.screening.text.patterns import Phrases
from agentrob.screening.text.words import en as words_en
from agentrob.screening.text.words import zh as words_zh

#: Half of the robot's length plus 10 cm, in metres.
REACH_M = 0.35
#: Half width of the path, in metres.
BESIDE_M = 0.8
#: The rule for something in unknown words.
UNKNOWN = "way.something"
#: Assumed distance of something "right in front", in metres.
CLOSE_M = 0.5
_SAMPLE_M = 0.05


@dataclass(frozen=True, slots=True)
class Hazard:
    """A hazard that a clause describes. `direction` is seen from the robot, None if the robot stands on it or under it.

    `later`: said after a motion was commanded, so the robot may be elsewhere by then.
    """

    rule: str
    direction: Direction | None
    distance_m: float | None
    words: str
    later: bool = False


@dataclass(frozen=True, slots=True)
class Clause:
    """A part of a text between two punctuation marks or conjunctions, with its position."""

    said: str
    start: int
    end: int


def hazard_in_path(text: str, plan: Plan, language: Language) -> Verdict | None:
    """Refuse a plan that leads to a described hazard; ask back if it is unclear what it is."""
    if (hazard := first_hazard_met(text, plan, language)) is None:
        return None
    decision = Decision.ASK_BACK if hazard.rule == UNKNOWN else Decision.REFUSE
    return Verdict(decision, hazard.rule, say(hazard.rule, language, words=quote(hazard.words)))


def first_hazard_met(text: str, plan: Plan, language: Language) -> Hazard | None:
    """Return the first described hazard that the plan leads to; `UNKNOWN` ones come last."""
    hazards = sorted(hazards_in(text, language) if plan.moves else (), key=lambda hazard: hazard.rule == UNKNOWN)
    for hazard in hazards:
        rests = range(len(plan.steps) if hazard.later else 1)
        if any(_reached(hazard, Plan(plan.steps[at:])) for at in rests):
            return replace(hazard, rule=UNKNOWN) if _taken_for_motion(hazard, plan) else hazard
    return None


def _taken_for_motion(hazard: Hazard, plan: Plan) -> bool:
    """Return whether the grammar may have parsed the statement as a command: 前面五米是墙 as five metres ahead."""
    said = (hazard.direction, hazard.distance_m)
    return hazard.distance_m is not None and any(said == (step.direction, step.distance_m) for step in plan.steps)


def hazards_in(text: str, language: Language) -> Iterator[Hazard]:
    """Yield everything that the text places around the robot."""
    plain = without_safe_edges(plain_words(text))
    lengths = _lengths(plain, language)
    before, moved = "", False
    for clause in clauses(plain):
        said = clause.said
        if _NONE_THERE.search(said) or commanded(said):
            moved |= commanded(said)
            continue
        later = any(token.start >= clause.end for token in lengths)
        if only_looks(said) and not later:
            continue
        within = [t for t in lengths if clause.start <= t.start < clause.end and not _SIZE.match(plain, t.end)]
        distance_m = float(within[0].value) if within and isinstance(within[0].value, float) else None
        found = list(_placed(said, distance_m))
        if before and not _names_hazard(said):  # "There is a child. It is right in front of you."
            found = list(_placed(f"{before}, {said}", distance_m)) or found
        before = said if not found and _names_hazard(said) else ""
        yield from (replace(hazard, later=moved) for hazard in found)


def clauses(plain: str) -> Iterator[Clause]:
    """Yield the clauses of a text that went through `plain_words`."""
    start = 0
    for between in [*_BETWEEN.finditer(plain), None]:
        end = between.start() if between else len(plain)
        bounds = [start, *sorted(_meetings(plain, start, end)), end]
        for begins, ends in pairwise(bounds):
            if plain[begins:ends].strip():
                yield Clause(plain[begins:ends].strip(), begins, ends)
        start = between.end() if between else end


def _meetings(plain: str, start: int, end: int) -> set[int]:
    """Return where a command and a statement meet without a pause: "walk 1 m you are on a table"."""
    if not commanded(plain[start:end]) and not _ACTED.match(plain, start, end):
        return set()
    begins = start + len(plain[start:end]) - len(plain[start:end].lstrip())
    first = _STATEMENT.match(plain, begins, end)
    after = first.end() if first else begins + 1
    orders = _ORDER.finditer(plain, after, end) if first else ()
    return {found.start() for found in (*_STATEMENT.finditer(plain, after, end), *orders)}


def commanded(said: str) -> bool:
    """Return whether a clause commands a motion: it says where to go, not what is there."""
    return _COMMANDED.search(said) is not None


def only_looks(said: str) -> bool:
    """Return whether a clause asks for a picture or a greeting and names its subject."""
    return _ONLY_LOOKS.search(said) is not None


def placed(said: str) -> bool:
    """Return whether a clause says clearly where somebody or something is, so that the path can be checked."""
    return any(hazard.direction is not None and hazard.rule != UNKNOWN for hazard in _placed(said, None))


def without_safe_edges(plain: str) -> str:
    """Mask the edges of carpets and the like, from which nothing can fall."""
    return _SAFE_EDGE.sub(lambda match: "side".ljust(len(match[0])), plain)


def _lengths(plain: str, language: Language) -> list[Token]:
    tokens, _ = tokens_of(plain, locale(language).words)
    return [token for token in with_amounts(tokens, plain) if token.kind is TokenKind.LENGTH]


def _placed(said: str, distance_m: float | None) -> Iterator[Hazard]:
    patterns = _patterns()
    if patterns["beneath"].search(said) and patterns["somebody"].search(said):
        yield Hazard("way.somebody", None, None, said)
    if patterns["on_drop"].search(said):
        yield Hazard("way.drop", None, distance_m, said)
        return
    rule = next((f"way.{kind}" for kind in ("drop", "somebody", "thing") if patterns[kind].search(said)), None)
    direction = next((d for d, name in _PLACES.items() if patterns[name].search(said)), None)
    if direction is None and rule is not None and distance_m is not None and patterns["away"].search(said):
        direction = Direction.FORWARD
    if direction is None:
        return
    if rule is None:
        if _IS_THERE.search(said):
            yield Hazard(UNKNOWN, direction, distance_m, said)
        return
    if distance_m is None and patterns["close"].search(said):
        distance_m = CLOSE_M
    if rule != "way.thing" or distance_m is not None:
        yield Hazard(rule, direction, distance_m, said)


def _names_hazard(said: str) -> bool:
    return any(_patterns()[kind].search(said) for kind in ("drop", "somebody", "thing"))


# ---------------------------------------------------------------------- the path
def _reached(hazard: Hazard, plan: Plan) -> bool:
    own_m = max((step.travel_m for step in plan.steps if not step.walks), default=0.0)
    if own_m and (hazard.distance_m is None or hazard.distance_m - REACH_M <= own_m):
        return True  # an operation of the robot's own leaves its place, and nobody knows which way
    if hazard.direction is None:
        most_m = hazard.distance_m - REACH_M if hazard.distance_m is not None else 0.0
        risky = any(step.operation.action_class is ActionClass.RISKY for step in plan.steps)
        if hazard.rule == "way.somebody":
            return True
        return any(math.hypot(x, y) > most_m for x, y in _path(plan)) or risky
    ux, uy = hazard.direction.unit_vector
    near_m = 0.2 if hazard.distance_m is None else max(hazard.distance_m - REACH_M, 0.0)
    for x, y in _path(plan):
        along_m, beside_m = x * ux + y * uy, abs(x * uy - y * ux)
        if along_m > near_m and beside_m < BESIDE_M:
            return True
    return False


def _path(plan: Plan) -> Iterator[tuple[float, float]]:
    """Yield points of the path in metres from the robot's start, x ahead and y to its left."""
    x = y = heading = 0.0
    for step in plan.steps:
        if step.rotates and step.degrees:
            heading += math.radians(step.degrees) * (1 if step.direction is Direction.LEFT else -1)
        elif step.translates and step.distance_m and step.direction and math.isfinite(step.distance_m):
            ux, uy = step.direction.unit_vector
            dx, dy = ux * math.cos(heading) - uy * math.sin(heading), ux * math.sin(heading) + uy * math.cos(heading)
            samples = min(math.ceil(step.distance_m / _SAMPLE_M), 4_000)
            for at in range(1, samples + 1):
                yield x + dx * step.distance_m * at / samples, y + dy * step.distance_m * at / samples
            x, y = x + dx * step.distance_m, y + dy * step.distance_m


# ---------------------------------------------------------------------- the words
_BETWEEN = re.compile(
    r"[!?;:\n。！？；：、…—–|•()（）\[\]【】{}\"“”「」『』<>→&+\u2600-\u27bf\U0001f300-\U0001faff]+|[.,，](?!\d)|/(?!\d)"
    r"|(?<=\s)[-~*_]+(?=\s)|\band\b(?! (?:a|one|three) (?:half|quarter))"
    r"|\b(?:then|but|so|because|although|though|since|whereas)\b|然后|接着|但|再|因为|由于|虽然|尽管|反正"
)
#: Where a statement begins that may follow a command without a pause.
_STATEMENT = re.compile(
    r"\b(?<!what )(?<!where )(?<!when )(?<!if )(?<!until )(?<!once )(?<!while )(?<!as )(?<!who )"
    r"(?:(?:you|we|they|there|these|those) are|(?:you|we|they)'re|(?:there|it|he|she|this|that|here) is"
    r"|(?:there|it|he|she|that|here)'s|i am|i'm"
    r"|(?:the|a|an|my|our|your|his|her|some|two|three) (?:\w+ ){1,3}?(?:is|are|lies?|sits?|stands?|sleeps?)\b)"
    r"|你(?:现在|正|就|还|已经)*(?:在|站|坐|趴|躺|被|插|拴|背|拿)|(?<![没所拥])有"
    r"|[前后左右旁下]面?(?:边)?(?:就|正)?(?:是|有)|地上"
    r"|我(?:们|的)?(?:正|就)?(?:在|站|坐|躺|脚|手)"
)
#: Where a clause begins that asks for a picture or a gesture.
_ACTED = re.compile(
    r"\s*(?:(?:please|now|just|can you|could you) )*"
    r"(?:take|send|snap|photograph|wave|sit|stand|stretch|dance|shake|clap)\b"
    r"|\s*(?:请|再|先|麻烦你?)*(?:拍|照|挥|招|坐|站|伸|跳舞|握手|鼓掌|比心)"
)
#: Where a command begins that may follow a statement without a pause.
_ORDER = re.compile(
    r"(?<!\bto )(?<!can )(?<!will )(?<!may )(?<!could )(?<!would )(?<!should )(?<!must )(?<!who )(?<!that )(?<!not )"
    r"(?<!the )(?<!your )(?<!my )(?<!'ll )(?<!\bi )(?<!we )(?<!they )(?<!people )"
    r"\b(?:(?:please|now) )?(?:walk|go|move|turn|step|rotate|back up|drive|strafe|spin|advance)\b"
    r"|(?:请|先)?(?:[往向朝][前后左右]|前进|后退|左转|右转|走)"
)
_SAFE_EDGE = re.compile(
    r"\b(?:edge|end|middle) of (?:the |a |your )?(?:\w+ )?(?:carpet|rug|mat|tape|line|tile|paper|grass|field|room"
    r"|hall|photo|picture|frame|lawn)\b|地毯(?:的)?边缘?"
)
#: Words after a length that make it a size, not a distance.
_SIZE = re.compile(r" ?(?:deep|high|tall|wide|long|thick|drop|fall|hole|pit|gap|cliff|wall|深|高|宽|长|厚)")
_NONE_THERE = re.compile(
    r"\b(?:no|not|isn't|aren't|nobody|no one|nothing|gone|was|were|used to|don't|if|nor|never|free|clear|safe"
    r"|left already|moved)\b"
    r"|没有|没|冇|不在|无人|走了|离开|已经走|空的|如果|别|不要|安全|走开"
)
_IS_THERE = re.compile(
    r"\b(?:is|are|'s|'re|stands?|sits?|lies|lie|sleeps?|rests?|waits?|find|hangs?|starts?|begins?)\b|\w'(?:s|re)\b"
    r"|[是有站坐躺趴睡在放]"
)
_ONLY_LOOKS = re.compile(
    r"\b(?:photo|picture|image|pic|wave|waving|greet|hello|hi|look|show|heart|see)|拍|照|挥手|招呼|比心|看|问好"
)
_COMMANDED = re.compile(
    r"(?<!\ba )(?<!\bthe )(?<!\byour )(?<!\bmy )\b(?:walk|go|move|run|step|turn|rotate|back up|backup|drive|proceed"
    r"|head|come|strafe|spin|travel|advance|pivot)\b"
    r"|\b(?:forwards?|backwards?|left|right) (?:\d|a |an |one |two |three |four |five |half )"
    r"|[向往朝](?:前|后|左|右)[^，。]{0,3}(?:走|移|退|转|跑)|前进|后退|左转|右转|走[^，。,]{1,4}[米步]|^\s*(?:再"
    r"|先)?(?:走|退|跑)"
)
_PLACES = {
    Direction.BACKWARD: "behind",
    Direction.LEFT: "left",
    Direction.RIGHT: "right",
    Direction.FORWARD: "ahead",
}


class _Said:
    """The patterns of both languages."""

    def __init__(self, name: str) -> None:
        self._phrases = Phrases(ENGLISH, words_en.PLACES[name]), Phrases(CHINESE, words_zh.PLACES[name])

    def search(self, said: str) -> bool:
        return any(phrases.search(said) for phrases in self._phrases)

    def prepare(self) -> None:
        for phrases in self._phrases:
            phrases.prepare()


@cache
def _patterns() -> Mapping[str, _Said]:
    return {name: _Said(name) for name in words_en.PLACES}


def prepare() -> None:
    """Compile all patterns in advance."""
    for said in _patterns().values():
        said.prepare()
