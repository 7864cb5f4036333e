"""The wide stop rule (law 13) while a robot moves or a command waits: a stop word or warning anywhere stops it.

`stop_intent` is the narrow rule, which always holds. When in doubt the answer is a stop: a false stop costs a repeat, a
missed stop may cost a leg. A word does not count if it is plainly denied ("don't stop"), asked about ("why did it
stop?"), in the past, or part of another word ("bus stop"); nor in a post that is a whole command with a stop in it
("walk 1 m and stop"). Takes linear time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache

from agentrob.language.addressing import only_joint
from agentrob.language.locales.zh_loan_words import in_chinese
from agentrob.language.registry import known
from agentrob.language.stop import words_en as en
from agentrob.language.stop import words_other as other
from agentrob.language.stop import words_zh as zh
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.stop.in_command import is_bound_in_command
from agentrob.language.visible_text import OMITTED, mention_spans, without_mentions
from agentrob.model import Intent

_CLAUSE_END = re.compile(r"([,;.!?…\n，。！？；、：:—()\"“”]+|\s-+\s|\bbut\b)")
_WORD = re.compile(r"[a-z0-9]+(?:['-][a-z0-9]+)*")
_HAN_RUN = re.compile(r"[\u3400-\u9fff]+")
_EMOJI = re.compile("[🛑✋⛔🚫⚠🆘🚨🤚🙅]")
_SPELT = re.compile(r"\b[a-z](?:[ .*_-]{1,2}[a-z]){3,10}\b")
_LEET = str.maketrans("01345@$", "oleasas")
_AGAIN = re.compile("(stop|wait|halt|no)\\1+")
_LONG_RUN = re.compile(r"([a-z])\1{2,}")
#: Context around a word in characters, and the length at which a clause is split into pieces.
_NEAR = 80
_LONGEST_CLAUSE = 400


def stop_while_moving(visible: str, names: Sequence[str] = (), robots: Sequence[str] = ()) -> Intent | None:
    """Return `Intent.STOP` or `HALT` if a post stops the moving robot called `names`, otherwise None.

    `visible` comes from `visible_text`; `robots` are the other handles in it that may be robots: text after such a
    mention is for them.
    """
    if narrow := stop_intent(visible):
        return narrow
    text = _plain(_for_me(visible, {n.lower() for n in names}, {r.lower() for r in robots}))
    clauses = list(_clauses(text))
    # An emergency stop that is a clause of its own locks, wherever it stands (law 17).
    if any(stop_intent(clause) is Intent.HALT for clause, _ in clauses):
        return Intent.HALT
    if not any(_stops(clause, end) for clause, end in clauses) and not _EMOJI.search(text):
        return None
    return None if is_bound_in_command(text, visible, names, robots, _stopping_clauses) else Intent.STOP


def _for_me(visible: str, mine: set[str], robots: set[str]) -> str:
    """Return the text without what follows another robot's mention, up to the next mention of this one."""
    spans = [(name in mine, start, end) for name, start, end in mention_spans(visible) if name in mine | robots]
    kept, at, other = [], 0, False
    for i, (is_mine, start, end) in enumerate(spans):
        kept += [] if other else [visible[at:start]]
        after = visible[end : spans[i + 1][1]] if i + 1 < len(spans) else ""
        joint = i + 1 < len(spans) and only_joint(after)
        # "@a and @b stop" is for both
        other = (
            not is_mine and not (i and spans[i - 1][0] and only_joint(visible[spans[i - 1][2] : start])) and not joint
        )
        at = end
    return without_mentions(" ".join([*kept, "" if other else visible[at:]]))


def _clauses(text: str) -> Iterator[tuple[str, str]]:
    """Yield the clauses of a plain text, with letter-by-letter spellings joined, and the mark that ends each."""
    text = _SPELT.sub(lambda m: word if (word := re.sub("[^a-z]", "", m[0])) in _vocabulary() else m[0], text)
    pieces = _CLAUSE_END.split(text)
    for at in range(0, len(pieces), 2):
        end = pieces[at + 1] if at + 1 < len(pieces) else ""
        for cut in range(0, max(1, len(pieces[at])), _LONGEST_CLAUSE):
            yield pieces[at][cut : cut + _LONGEST_CLAUSE + _NEAR].strip(), end


def _stopping_clauses(text: str) -> list[str]:
    return [clause for clause, end in _clauses(text) if _stops(clause, end)]


def _plain(text: str) -> str:
    """Return the text in lower case, with simplified characters and straight apostrophes, as the patterns expect."""
    return text.casefold().replace("’", "'").replace("‘", "'").replace(OMITTED, " ").translate(zh.SIMPLIFIED)


def _stops(clause: str, end: str) -> bool:
    words = _WORD.findall(clause)
    shouted = any(mark in end for mark in "!！")
    if other.STOP.search(clause):
        return True
    return bool(words and _stops_en(words, clause, shouted)) or any(
        _stops_zh(run, shouted) for said in {clause, in_chinese(clause)} for run in _HAN_RUN.findall(said)
    )


# ---------------------------------------------------------------------- English
def _stops_en(words: list[str], clause: str, shouted: bool) -> bool:
    said = " ".join(_right(word) for word in words)
    again = en.REPEATED.fullmatch(said[:_NEAR]) if len(said) <= _NEAR else None
    once, shouted = (again[1], True) if again else (said, shouted)
    if len(said) <= _NEAR and (en.WHOLE.fullmatch(once) or (shouted and en.SHOUTED.fullmatch(once))):
        return True
    if en.SCREAM.search(clause):
        return True
    if en.PINYIN.search(said) and not en.PINYIN_DENIED.search(said):
        return True
    if any(re.search(pattern, said) for pattern in _further()):
        return True
    question = None if en.ASKED.search(said) else en.QUESTION.match(said)
    cry = en.CRY.search(said) is not None and not en.SMILE.search(said) and not (question and not question["wh"])
    if en.PAST.search(said) or en.SMILE.search(said):
        return False
    if any(_counts(said, found, question, cry) for found in en.STOP.finditer(said)):
        return True
    if not question and (en.IDIOM.search(said) or en.COME_TO.search(said)):
        return True
    if en.WAIT.search(said) and not question and not en.SELF_WAIT.search(said):
        return True
    if en.CAREFUL.search(said) and not en.PRAISE.search(said) and not question:
        return True
    asked = question is not None and question["be"] is None
    return en.WARNING.search(said) is not None and not asked and not en.NO_WARNING.search(said)


def _counts(said: str, found: re.Match[str], question: re.Match[str] | None, cry: bool) -> bool:
    """Return whether a stop word is a request to stop."""
    before = said[max(0, found.start() - _NEAR) : found.start()]
    near = said[max(0, found.start() - _NEAR) : found.end() + _NEAR]
    come = any(n.start() <= len(before) < n.end() for n in en.COME_TO.finditer(near))
    if question and (before.split()[-1:] or [""])[0] in en.GOVERNS:
        return bool(cry)
    if not come and any(n.start() <= len(before) < n.end() for n in en.NOUN.finditer(near)):
        return False
    if en.HABIT.search(before + found[0]) or en.PRAISE.search(near):
        return False
    return cry or not en.DENIED.search(before)


@cache
def _further() -> tuple[str, ...]:
    """Return the stop words that further language files add, as patterns."""
    lists = "\n".join(t.stop for code, t in known().items() if code not in ("en", "zh"))
    phrases = {p.strip() for p in re.split(r"[|\n]", lists.casefold()) if p.strip()}
    return tuple(rf"\b{re.escape(p)}\b" for p in sorted(phrases))


# ---------------------------------------------------------------------- slips
@cache
def _vocabulary() -> frozenset[str]:
    return frozenset(en.MEANT.split())


@lru_cache(maxsize=4096)
def _right(word: str) -> str:
    """Return the word that was meant: "stpo" is stop, "stooop" is stop, "pls" is please."""
    if word in en.SLANG:
        return en.SLANG[word]
    for candidate in (word, _LONG_RUN.sub(r"\1", word), _LONG_RUN.sub(r"\1\1", word)):
        if candidate in en.SLANG:
            return en.SLANG[candidate]
        if candidate in _vocabulary():
            return candidate
    if again := _AGAIN.fullmatch(word):
        return again[1]
    short = _LONG_RUN.sub(r"\1", word)
    if len(short) > 12:
        return short
    leet = short.translate(_LEET) if not short.isdigit() and any(c.isdigit() for c in short) else short
    if leet in en.OTHERS or en.STOP.fullmatch(leet) or en.WARNING.fullmatch(leet) or en.IDIOM.fullmatch(leet):
        return leet
    return next((meant for meant in en.MEANT.split() if _is_slip(leet, meant)), leet)


def _is_slip(word: str, meant: str) -> bool:
    """Return whether `word` is `meant` with one typing mistake (Damerau-Levenshtein distance 1).

    The first letter must be right, or swapped with the second.
    """
    if word == meant:
        return True
    longer, shorter = (word, meant) if len(word) > len(meant) else (meant, word)
    if len(longer) - len(shorter) == 1:
        return word[0] == meant[0] and len(word) >= 4 and _without_one(longer, shorter)
    if len(word) != len(meant):
        return False
    wrong = [at for at in range(len(word)) if word[at] != meant[at]]
    if len(wrong) == 2 and wrong[1] == wrong[0] + 1:
        return word[wrong[0]] == meant[wrong[1]] and word[wrong[1]] == meant[wrong[0]]
    return len(wrong) == 1 and wrong[0] > 0


def _without_one(longer: str, shorter: str) -> bool:
    return any(longer[:at] + longer[at + 1 :] == shorter for at in range(len(longer)))


# ---------------------------------------------------------------------- Chinese
def _stops_zh(run: str, shouted: bool) -> bool:
    whole = len(run) <= _NEAR and (zh.WHOLE.fullmatch(run) or (shouted and zh.SHOUTED.fullmatch(run)))
    if (
        whole
        or zh.PRESS.search(run)
        or (zh.CRY.search(run) and not zh.LAUGHTER.search(run) and not zh.WEATHER.search(run))
    ):
        return True
    plain = zh.LAUGHTER.sub("·", zh.NO_STOP.sub("·", run))
    wishes = zh.NO_WARNING.sub("·", plain)
    if zh.REQUEST.search(run) and zh.STOP.search(plain):
        return True
    if zh.QUESTION.search(run):
        return False
    if zh.STOP.search(plain) and not zh.PAST.search(run):
        return True
    return (zh.PAUSE.search(wishes) or zh.WARNING.search(wishes)) is not None and not zh.PAST.search(run)
