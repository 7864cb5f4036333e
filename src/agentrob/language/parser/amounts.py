"""Combine tokens that belong together: numbers with their units, "take" with "a picture"."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.parser.lexicon import Soft, Token, TokenKind
from agentrob.model import PHOTO

_AMOUNT_OF = {
    TokenKind.LENGTH_UNIT: TokenKind.LENGTH,
    TokenKind.ANGLE_UNIT: TokenKind.ANGLE,
    TokenKind.SPEED_UNIT: TokenKind.SPEED,
    TokenKind.STEP_UNIT: TokenKind.STEPS,
    TokenKind.TIME_UNIT: TokenKind.DURATION,
    TokenKind.TIMES_UNIT: TokenKind.TIMES,
    TokenKind.MORE_TIMES_UNIT: TokenKind.MORE_TIMES,
}


_MEASURES = (*_AMOUNT_OF.values(), TokenKind.NUMBER)
#: What may begin an amount.
_QUANTITIES = (TokenKind.NUMBER, TokenKind.HALF, TokenKind.SOFT)
#: What depends on the next word.
_UNSETTLED = (TokenKind.AFTER, TokenKind.SHOW, TokenKind.CONDITION, TokenKind.GO_AHEAD)
_LONGEST_PICTURE = 6
_SEPARATING = (TokenKind.AND, TokenKind.COMMA, TokenKind.END)
#: What may end an action that something is to follow.
_ENDING = (TokenKind.OP, TokenKind.TURN, TokenKind.PICTURE, TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.TIMES)
#: What may follow "another" that stands alone: "another, please".
_AFTER_ANOTHER = (*_SEPARATING, TokenKind.THANKS, TokenKind.REQUEST)
_ACTIONS = (TokenKind.OP, TokenKind.MOVE, TokenKind.TURN)
_INCH_M = 0.0254


def with_amounts(tokens: Sequence[Token], text: str) -> list[Token]:
    """Replace adjacent numbers and units by one amount; single numbers and units stay."""
    found: list[Token] = []
    at, unit_m = 0, 0.0  # how long one unit of the last length is
    while at < len(tokens):
        amount, used = _amount(tokens, at, text) if tokens[at].kind in _QUANTITIES else (None, 0)
        if amount is None:
            # "Second, turn left" is no time.
            found.append(
                tokens[at] if tokens[at].kind is not TokenKind.TIME_UNIT else tokens[at]._replace(kind=TokenKind.SOFT)
            )
            at += 1
            continue
        _append(found, amount, unit_m)
        at += used
        unit = tokens[at - 1]
        unit_m = _float(unit) if unit.kind is TokenKind.LENGTH_UNIT else 0.0
    return found


def with_pictures(tokens: Sequence[Token]) -> list[Token]:
    """Replace "take … picture" by one operation, "take three pictures" by the operation and a count, and "another" by a
    further picture or a repetition.
    """
    found: list[Token] = []
    at = 0
    while at < len(tokens):
        further, used = _another(tokens, at, found)
        if further is not None:
            found.append(further)
            at += used
            continue
        if tokens[at].kind not in _UNSETTLED:
            found.append(tokens[at])
            at += 1
            continue
        end = at + 1
        count: Token | None = None
        while tokens[at].kind is TokenKind.SHOW and end < len(tokens) and end - at <= _LONGEST_PICTURE:
            token = tokens[end]
            if token.kind is TokenKind.NUMBER and count is None:
                count = token
            elif token.kind not in (TokenKind.SHOW, TokenKind.SOFT):
                break
            end += 1
        if tokens[at].kind is TokenKind.SHOW and end < len(tokens) and tokens[end].kind is TokenKind.PICTURE:
            start, stop = tokens[at].start, tokens[end].end
            found.append(Token(TokenKind.OP, PHOTO.value, start, stop, more=_says_more(tokens[at:end])))
            if count is not None:
                found.append(Token(TokenKind.TIMES, count.value, start, stop))
            at = end + 1
        else:
            found.append(_settled(tokens, at))
            if tokens[at].kind is TokenKind.SHOW and _are_steps(tokens, _skip_soft(tokens, at + 1)):
                found[-1] = tokens[at]._replace(kind=TokenKind.MOVE)
            at += 1
    return found


def _another(tokens: Sequence[Token], at: int, found: Sequence[Token]) -> tuple[Token | None, int]:
    """Return what "another" stands for and its number of tokens, or (None, 0).

    "One more photo", and "take another" or "another of the door" after a photo: a further picture; "wave, then
    another": once more. The grammar asks which of several actions that is.
    """
    shows = tokens[at].kind is TokenKind.SHOW
    end = at + shows
    while shows and end < len(tokens) and tokens[end].kind is TokenKind.SOFT and tokens[end].value != Soft.ONE_MORE:
        end += 1
    if end >= len(tokens) or tokens[end].value != Soft.ONE_MORE:
        return None, 0
    end += 1
    if end < len(tokens) and tokens[end].kind is TokenKind.NUMBER and tokens[end].value == 1.0:  # "another one"
        end += 1
    following = tokens[end].kind if end < len(tokens) else TokenKind.END
    before = [token for token in found if token.kind is not TokenKind.SOFT]
    begins = not before or before[-1].kind in _SEPARATING
    actions = [token.value for token in before if token.kind in _ACTIONS]
    after_photo = PHOTO in (actions if shows else actions[-1:])  # "take a photo, wave, then another": of which?
    start, stop = tokens[at].start, tokens[end - 1].end
    if following is TokenKind.PICTURE:
        return Token(TokenKind.OP, PHOTO.value, start, tokens[end].end, more=True), end + 1 - at
    if after_photo and (shows or begins) and following in (*_AFTER_ANOTHER, TokenKind.OF):
        return Token(TokenKind.OP, PHOTO.value, start, stop, more=True), end - at
    if begins and not shows and following in _AFTER_ANOTHER:
        return Token(TokenKind.AGAIN, None, start, stop), end - at
    return None, 0


def _says_more(tokens: Sequence[Token]) -> bool:
    return any(token.value in (Soft.MORE, Soft.ONE_MORE) for token in tokens)


def _after(tokens: Sequence[Token], at: int) -> Token:
    """Resolve 后 and 前: after an action they put things in order (走两米后挥手, 坐下前挥手), elsewhere they are
    directions (往后走).
    """
    token, before = tokens[at], tokens[at - 1] if at else None
    following = tokens[at + 1].kind if at + 1 < len(tokens) else TokenKind.END
    if token.value == "condition":
        ends = before is not None and before.kind is TokenKind.OP and before.end == token.start
        return token._replace(kind=TokenKind.CONDITION if ends else TokenKind.DIR, value=None if ends else "forward")
    counts = following in (*_AMOUNT_OF.values(), TokenKind.NUMBER, TokenKind.HALF)  # 后两米
    if before is None or before.kind in _SEPARATING or (counts and before.kind not in _ENDING):
        return token._replace(kind=TokenKind.DIR, value="backward")
    return token._replace(kind=TokenKind.AND, value=None)


def _are_steps(tokens: Sequence[Token], at: int) -> bool:
    """ "Take two steps", "take a few steps"."""
    kinds = [t.kind for t in tokens[at : at + 2]]
    return kinds[:1] == [TokenKind.STEPS] or kinds == [TokenKind.VAGUE, TokenKind.STEP_UNIT]


def _settled(tokens: Sequence[Token], at: int) -> Token:
    """Resolve a token that depends on the next word: "go ahead" is a direction before a length, otherwise
    encouragement.
    """
    token = tokens[at]
    if token.kind is TokenKind.AFTER:
        return _after(tokens, at)
    if token.kind is TokenKind.SHOW and token.value == "picture":
        return token._replace(kind=TokenKind.OP, value=PHOTO.value)
    if token.kind is TokenKind.SHOW and token.value == "talk":  # "I want to see", and no picture
        return token._replace(kind=TokenKind.TALK)
    following = tokens[_skip_soft(tokens, at + 1) :][:1]
    if (
        token.kind is TokenKind.CONDITION
        and token.value == "wait"
        and following
        and following[0].kind is TokenKind.DURATION
    ):
        return token._replace(kind=TokenKind.BEYOND)  # 等五秒再挥手
    if token.kind is TokenKind.CONDITION and token.value == "hedge" and following and following[0].kind in _MEASURES:
        return token._replace(kind=TokenKind.SOFT, value=None)  # "maybe two feet"
    if token.kind is TokenKind.CONDITION and token.value == "after" and _joins_actions(tokens, at):
        return token._replace(kind=TokenKind.AND, value=None)
    if token.kind is not TokenKind.GO_AHEAD:
        return token
    goes = bool(following) and following[0].kind is TokenKind.LENGTH
    return Token(TokenKind.DIR if goes else TokenKind.SOFT, "forward" if goes else Soft.ASSENT, token.start, token.end)


def _joins_actions(tokens: Sequence[Token], at: int) -> bool:
    """ "Wave and after clap": nothing but a gesture, or its end, follows."""
    kinds = [t.kind for t in tokens[at + 1 : at + 3]]
    return at > 0 and tokens[at - 1].kind is TokenKind.AND and kinds[:1] == [TokenKind.OP] and len(kinds) == 1


def _append(found: list[Token], amount: Token, unit_m: float) -> None:
    before = found[-1] if found else None
    if before and before.kind is TokenKind.PER_SECOND and amount.kind is TokenKind.LENGTH:  # 每秒0.3米
        found[-1] = Token(TokenKind.SPEED, amount.value, before.start, amount.end)
    elif before and before.kind is TokenKind.LENGTH is amount.kind and _float(amount) < unit_m:  # 5 ft 6 in
        found[-1] = Token(TokenKind.LENGTH, _float(before) + _float(amount), before.start, amount.end)
    elif (
        before and before.kind is TokenKind.ANGLE is amount.kind and len(found) > 1 and found[-2].start == before.start
    ):
        found[-1] = amount  # "turn around 90 degrees": the explicit angle counts
    else:
        found.append(amount)


def _amount(tokens: Sequence[Token], at: int, text: str) -> tuple[Token | None, int]:
    """Return the amount that begins at this position and its number of tokens, or (None, 0)."""
    value, here = _quantity(tokens, at, text)
    if value is None:
        return None, 0
    unit_at = here if _are_inches(tokens, here) else _skip_soft(tokens, here)
    unit = tokens[unit_at] if unit_at < len(tokens) else None
    if unit is None or (unit.kind not in _AMOUNT_OF and not _are_inches(tokens, unit_at)):
        return None, 0
    if unit.kind is TokenKind.SOFT:
        unit = unit._replace(kind=TokenKind.LENGTH_UNIT, value=_INCH_M)
    end = unit_at + 1
    if end < len(tokens) and tokens[end].kind is TokenKind.AND_PART and not _has_unit(tokens, end + 1):
        # "a metre and a half"; "1 m and half a metre" are two amounts
        value += _float(tokens[end])
        end += 1
    elif unit.kind is TokenKind.LENGTH_UNIT and (fraction := _spoken_fraction(tokens, end, text)) is not None:
        value += fraction
        end += 1
    elif unit.kind is TokenKind.ANGLE_UNIT and end < len(tokens) and _half_follows(tokens, end):
        value += 0.5
        end += 1
    one = float(unit.value) if isinstance(unit.value, float) else 1.0
    more = _says_more(tokens[max(at - 1, 0) : end])
    kind = _AMOUNT_OF[unit.kind]
    return Token(kind, value * one, tokens[at].start, tokens[end - 1].end, one, more), end - at


def _has_unit(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a unit stands here, after at most two words without meaning."""
    at = _skip_soft(tokens, at)
    return at < len(tokens) and tokens[at].kind in _AMOUNT_OF


def _are_inches(tokens: Sequence[Token], at: int) -> bool:
    """ "2 ft 6 in", where the clause ends or a direction follows; not "in the room"."""
    if at >= len(tokens) or tokens[at].value != Soft.IN:
        return False
    following = tokens[at + 1].kind if at + 1 < len(tokens) else TokenKind.END
    return following in (TokenKind.END, TokenKind.COMMA, TokenKind.AND, TokenKind.DIR)


def _half_follows(tokens: Sequence[Token], at: int) -> bool:
    """转两圈半: two and a half, where nothing is halved after it."""
    touches = tokens[at].kind is TokenKind.HALF and tokens[at].start == tokens[at - 1].end
    return touches and not (at + 1 < len(tokens) and tokens[at + 1].kind in _AMOUNT_OF)


def _quantity(tokens: Sequence[Token], at: int, text: str) -> tuple[float | None, int]:
    """Read a number before its unit as people say it: 2 · two and a half · half a · 1/2 · 1 1/2 · a · 两个半."""
    first = tokens[at]
    if first.kind is TokenKind.HALF:
        return 0.5, at + 1
    if first.kind is TokenKind.SOFT and first.value in (1, Soft.ONE_MORE):
        following = tokens[at + 1].kind if at + 1 < len(tokens) else None
        return (
            (1.0, at + 1)
            if following in (TokenKind.LENGTH_UNIT, TokenKind.STEP_UNIT, TokenKind.TIME_UNIT)
            else (None, at)
        )
    if first.kind is not TokenKind.NUMBER:
        return None, at
    value, here = _float(first), at + 1
    if here < len(tokens) and tokens[here].kind is TokenKind.AND_PART:
        return value + _float(tokens[here]), here + 1
    if here < len(tokens) and tokens[here].kind is TokenKind.HALF and value == int(value):  # 一个半米, one half metre
        return (value + 0.5 if here + 1 < len(tokens) else None), here + 1
    if here < len(tokens) and tokens[here].kind is TokenKind.NUMBER and _is_fraction(tokens[here], text) and value >= 1:
        return value + _float(tokens[here]), here + 1
    return value, here


def _is_fraction(token: Token, text: str) -> bool:
    return (
        0 < _float(token) < 1
        and not text[token.start : token.end].isdigit()
        and "." not in text[token.start : token.end]
    )


def _skip_soft(tokens: Sequence[Token], at: int) -> int:
    """Skip at most two words without meaning: "two more feet", "five uh feet"."""
    for _ in range(2):
        if at < len(tokens) and tokens[at].kind is TokenKind.SOFT:
            at += 1
    return at


def _spoken_fraction(tokens: Sequence[Token], at: int, text: str) -> float | None:
    """Read the fraction after a unit: 一米五 is 1.5 m, 一米零五 1.05 m, 1米20 1.2 m, 一米半 1.5 m.

    A digit with a unit of its own does not count.
    """
    if at >= len(tokens) or tokens[at].start != tokens[at - 1].end:
        return None
    if text[tokens[at].start - 1].isascii():  # 1m50
        tail = text[tokens[at].start : tokens[at].end]
        metres = tokens[at - 1].value == 1.0 and tokens[at].kind is TokenKind.NUMBER
        return float(tail) / 100 if metres and len(tail) == 2 and tail.isdigit() else None
    if at + 1 < len(tokens) and tokens[at + 1].kind in (*_AMOUNT_OF, TokenKind.NUMBER, TokenKind.HALF, TokenKind.WORD):
        return None
    if tokens[at].kind is TokenKind.HALF:
        return 0.5
    said = text[tokens[at].start : tokens[at].end]
    if tokens[at].kind is not TokenKind.NUMBER or len(said) > 2 or (len(said) == 2 and said[0] not in "0零〇123456789"):
        return None
    return _float(tokens[at]) / (10.0 if len(said) == 1 else 100.0)


def _float(token: Token) -> float:
    return token.value if isinstance(token.value, float) else 0.0
