"""Apply corrections in speech: afterthoughts, false starts, "no wait, right"."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.parser.drafts import Draft
from agentrob.language.parser.lexicon import Token, TokenKind
from agentrob.language.routines import Routine
from agentrob.model import PHOTO, Direction

_ACTING = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)
_AHEAD = (Direction.FORWARD, Direction.BACKWARD)


def settled(drafts: Sequence[Draft]) -> list[Draft]:
    """Join afterthoughts with what they complete, and drop false starts."""
    joined: list[Draft] = []
    for draft in drafts:
        late = draft.verb is None and not (
            draft.unknown or draft.stop_word
        )  # "… and wait five seconds" completes nothing
        if draft.fixes is None and late and _completes(joined, draft):
            continue
        while joined and (draft.joined or draft.hesitant) and _is_false_start(joined[-1], draft):
            joined.pop()
        if len(joined) > 1 and _begins_anew(joined[-2], joined[-1], draft):
            del joined[-2:]
        if draft.op and joined and joined[-1].op is draft.op and joined[-1].again:  # "wave again wave"
            draft.unknown.append((joined[-1].start, draft.end))
        elif draft.op and draft.joined and joined and joined[-1].op is draft.op and not joined[-1].counted:
            joined[-1].times, joined[-1].counted = draft.times, draft.counted  # 挥手打招呼: one gesture in two words
            joined[-1].each = joined[-1].each or draft.each
            continue
        if joined and _leaves_out_the_verb(joined[-1], draft):
            draft.verb = TokenKind.TURN
        if joined and draft.after_and and _may_share_its_angle(joined[-1], draft):
            joined[-1].vague = True
        joined.append(draft)
    return joined


def _may_share_its_angle(last: Draft, draft: Draft) -> bool:
    """ "Turn left and right 45 degrees": 45 for one of them, or for both."""
    turns = last.verb is TokenKind.TURN and last.direction is not None and last.amount is None
    return turns and draft.verb is None and draft.direction is not None and _may_be_of_turn(last, draft)


def _may_be_of_turn(last: Draft, draft: Draft) -> bool:
    """Return whether a side with an amount may say how far the turn before it is to go: not "forward 1 m"."""
    if draft.amount is None or draft.direction in _AHEAD:
        return False
    return draft.amount.kind is not TokenKind.LENGTH or draft.direction is last.direction


def _leaves_out_the_verb(last: Draft, draft: Draft) -> bool:
    """ "Turn 45 left and 45 right": a side and a number again, as of the turn before."""
    alike = last.verb is TokenKind.TURN and draft.verb is None and bool(draft.direction) and not draft.unknown
    return alike and all(d.amount is not None and d.amount.kind is TokenKind.NUMBER for d in (last, draft))


def _completes(drafts: Sequence[Draft], extra: Draft) -> bool:
    """Apply a late amount or side to the last motion: "turn right and take a photo, ninety degrees"."""
    last = next((d for d in reversed(drafts) if d.takes_manner), None)
    if last is None or (last.verb is None and last.fixes is None) or last.unknown or not extra.is_motion:
        return False
    if last.ahead:  # "three times: forward 1 m": that is what is repeated
        return False
    if isinstance(last.op, Routine) and (extra.direction is not None or not last.lacks_size):
        if extra.joined:  # "patrol forward 1 m": its size, or a walk after it
            last.unknown.append((extra.start, extra.end))
        return extra.joined  # "dance, forward 1 m" are two; "walk a square, 1 m" is its size
    if extra.direction and extra.amount and not extra.hesitant:  # "turn left, left 90 degrees": one turn or two
        bare = last.verb is TokenKind.TURN and last.direction is not None and last.amount is None
        bare = bare and _may_be_of_turn(last, extra)
        if last is not drafts[-1] and extra.joined and extra.amount.start == extra.start:
            bare = False  # "turn right and take a picture ninety degrees to the right"
        last.vague = last.vague or bare
        if bare or extra.after_and:
            return False
    if (
        extra.hesitant
        and extra.direction is None
        and last.amount
        and last.amount.kind is TokenKind.NUMBER
        and last.verb
    ):
        last.amount = None  # "walk two, er, three metres"
    if extra.direction is not None and last.direction not in (None, extra.direction):
        return False
    if extra.hesitant and extra.direction is None and _same(extra.amount, last.amount):
        return True  # "five feet uh five feet"
    if extra.amount is not None and (last.amount is not None or not _belongs(last, extra)):
        return False
    if extra.amount is None and (last.direction is not None or extra.after_and):
        return False  # "walk 1 m and then back"
    last.amount = last.amount or extra.amount
    last.direction = last.direction or extra.direction
    last.end = max(last.end, extra.end)
    last.vague, last.faster = last.vague or extra.vague, last.faster or extra.faster
    last.slow, last.slower = last.slow or extra.slow, last.slower or extra.slower
    last.speed_mps = extra.speed_mps if last.speed_mps is None else last.speed_mps
    return True


def _same(amount: Token | None, other: Token | None) -> bool:
    return amount is not None and other is not None and (amount.kind, amount.value) == (other.kind, other.value)


def _belongs(last: Draft, extra: Draft) -> bool:
    if last.verb is TokenKind.AGAIN:
        return True
    is_angle = extra.amount is not None and extra.amount.kind in (TokenKind.ANGLE, TokenKind.NUMBER)
    return is_angle if last.verb is TokenKind.TURN else not is_angle or last.direction not in _AHEAD


def _is_false_start(start: Draft, again: Draft) -> bool:
    """Return whether a motion was begun twice: "move forward uh move three feet".

    There is no pause between, or a hesitation, and the first has no amount.
    """
    if not start.is_motion or start.amount is not None or start.unknown or start.verb is None or not again.is_motion:
        return False
    if start.verb is TokenKind.TURN and again.amount is not None and not _is_angle(again.amount):
        return False  # "turn ten inches": nobody can tell whether it is to turn or to step aside
    if start.direction is None:
        return start.verb is again.verb or again.verb is None
    same = start.direction is again.direction or (again.direction is None and start.verb is again.verb)
    if same and again.direction is None:
        again.direction = start.direction
    return same and (again.amount is not None)


def _begins_anew(start: Draft, picture: Draft, again: Draft) -> bool:
    """ "Turn left and take a picture turn left sixty degrees …", without a pause: the same, now with its angle."""
    same = start.verb is TokenKind.TURN is again.verb and start.direction is again.direction is not None
    ours = picture.op is PHOTO and start.amount is None and again.amount is not None
    return same and ours and again.joined and not start.unknown and not again.fixes


# ------------------------------------------------------------------ corrections
def corrected(drafts: Sequence[Draft]) -> tuple[list[Draft], Token | None]:
    """Replace what corrections correct; also return the first correction whose meaning is unclear."""
    done: list[Draft] = []
    unclear: Token | None = None
    for draft in drafts:
        if draft.fixes is None or not done:
            done.append(draft)
        elif draft.fixes.kind is TokenKind.CANCEL and not draft.unknown and draft.verb is not TokenKind.AGAIN:
            done = [draft]  # "turn left, never mind, just wave"
        elif not _correct(done, draft):
            unclear = unclear or draft.fixes
    return done, unclear


def _correct(done: list[Draft], fix: Draft) -> bool:
    """Apply a correction ("turn left, no wait, right"); return whether it is clear what it corrects."""
    last = done[-1]
    if last.beyond and last.beyond != "path" and fix.verb in _ACTING and not fix.unknown:  # "dance, no, sit"
        done[-1] = fix
        return True
    if fix.unknown or last.unknown or fix.verb is TokenKind.AGAIN or fix.bare_picture:
        return False
    if fix.is_motion and last.is_motion:
        if fix.verb is None or fix.verb is last.verb:
            return _overlay(last, fix)
        if len(done) > 1:
            return False
    elif (fix.verb is TokenKind.OP) is not (last.verb is TokenKind.OP):
        return False
    done[-1] = fix
    return True


def _overlay(last: Draft, fix: Draft) -> bool:
    """Overwrite the last draft with what was said again; return whether the two are compatible."""
    if fix.direction is None and fix.amount is None:
        return False
    if last.verb is TokenKind.TURN and (fix.direction in _AHEAD or (fix.amount and not _is_angle(fix.amount))):
        return False
    if fix.amount is not None and last.amount is not None and not _alike(fix.amount, last.amount):
        return False
    last.end = max(last.end, fix.end)
    last.direction = fix.direction or last.direction
    same_unit = fix.fixes is not None and fix.fixes.value == "amount"
    last.amount = (_in_same_unit(fix.amount, last.amount) if same_unit else fix.amount) or last.amount
    last.vague = fix.vague if fix.amount is None and fix.vague else last.vague and fix.amount is None
    last.slow, last.speed_mps = last.slow or fix.slow, last.speed_mps if fix.speed_mps is None else fix.speed_mps
    return True


def _in_same_unit(amount: Token | None, before: Token | None) -> Token | None:
    """Return the amount that counts: "3 feet, no, make it 5" means feet."""
    if amount is None or before is None or amount.kind is not TokenKind.NUMBER or not before.unit:
        return amount or before
    value = amount.value * before.unit if isinstance(amount.value, float) else amount.value
    return amount._replace(kind=before.kind, value=value, unit=before.unit)


def _alike(amount: Token, other: Token) -> bool:
    """Return whether one amount may replace the other: "two, no, three metres"."""
    return TokenKind.NUMBER in (amount.kind, other.kind) or _is_angle(amount) is _is_angle(other)


def _is_angle(amount: Token) -> bool:
    return amount.kind in (TokenKind.ANGLE, TokenKind.NUMBER)
