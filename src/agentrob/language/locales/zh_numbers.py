"""Read Chinese numerals: 两百, 零点八, 一百八, 四分之三."""

from __future__ import annotations

import re
from collections.abc import Sequence

from agentrob.language.locales import en_numbers
from agentrob.language.parser.lexicon import Piece

NUMERALS = frozenset("零〇一二两三四五六七八九十百千万点")
_DIGIT = "[一二两三四五六七八九]"
_BELOW = f"(?:{_DIGIT}千)?(?:零?{_DIGIT}百)?(?:零?{_DIGIT}?十)?(?:零?{_DIGIT})?"
_SMALL = re.compile(
    f"""(?:({_DIGIT})百(?=$|零|点|{_DIGIT}十)零?)?(?:({_DIGIT}?)(十))?({_DIGIT}|零(?=点
        |$))?(?:点([零〇一二两三四五六七八九]+))?"""
)
_NUMERAL = re.compile(f"(?:(?:{_BELOW}万)?{_BELOW}|零)(?:点[零〇一二两三四五六七八九]+)?|〇")
_DIGITS = {c: i for i, c in enumerate("零一二三四五六七八九")} | {"两": 2, "〇": 0}


def number(pieces: Sequence[Piece], at: int) -> tuple[float, int] | None:
    """ "2", "1.5", "两百", "零点八", "一百二十", also the spoken 一百八 (180), and 四分之三. English numerals too."""
    if pieces[at].text not in NUMERALS:
        return en_numbers.number(pieces, at)
    if (found := _whole(pieces, at)) is None:
        return None
    value, length = found
    of = at + length
    if [piece.text for piece in pieces[of : of + 2]] == ["分", "之"] and of + 2 < len(pieces):
        above = _whole(pieces, of + 2)
        return (above[0] / value, length + 2 + above[1]) if above and value else None
    return value, length


def _whole(pieces: Sequence[Piece], at: int) -> tuple[float, int] | None:
    run = ""
    for piece in pieces[at : at + 12]:
        if piece.text not in NUMERALS:
            break
        run += piece.text
    run = run.rstrip("点")  # 一点 without digits after it means "a bit"
    if not run or run[0] == "点" or not _NUMERAL.fullmatch(run):  # 两三米 is two or three
        return None
    value = _value(run)
    return None if value is None else (value, len(run))


def _value(numeral: str) -> float | None:
    """The value of a whole numeral; plain ones below 1000 without the library, which takes 0.15 s to import."""
    if small := _SMALL.fullmatch(numeral):
        hundreds, tens, ten, ones, decimals = (group or "" for group in small.groups())
        whole = 100 * _DIGITS.get(hundreds, 0) + 10 * _DIGITS.get(tens, 1) * bool(ten) + _DIGITS.get(ones, 0)
        return float(f"{whole}." + "".join(str(_DIGITS[d]) for d in decimals))
    import cn2an

    try:
        return float(cn2an.cn2an(numeral.replace("〇", "零"), "smart"))
    except (ValueError, KeyError, IndexError):  # some numerals that are none trip the library itself (十十一)
        return None
