"""Chinese phrases of several words that mean less or more than their words one by one.

Each function takes the tokens of a post and returns them rewritten: 左右各转30度 becomes two turns, 向老人挥手 a
gesture, 拍一张院子的照片 a picture. Positions stay, so that questions and notes quote the post.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from agentrob.language.locales.zh_characters import TWINS
from agentrob.language.locales.zh_doubts import (
    denied_until_request,
    of_relative_clauses,
    only_one_of_two,
    praised,
    reported_pictures,
    rests_after,
    shared_later,
    sits_or_does,
)
from agentrob.language.operations.spoken import FOR_SOMEBODY
from agentrob.language.parser.lexicon import Soft, Token, TokenKind
from agentrob.language.remarks.chinese import TRIAL
from agentrob.model import PHOTO, Direction

_PERSON = (
    "(?:大家|大伙儿?|他们?|她们?|我们?|咱们?|你们|各位|诸位|老人家?|老爷爷|老奶奶|[爷奶爸妈哥姐弟妹叔姨舅婶]{1,2}|姥姥|姥爷|外婆"
    "|外公|阿姨|叔叔|大爷|大妈|客人|来宾|嘉宾|贵宾|宾客|观众|听众|游客|访客|顾客|评委|老师|老板|领导|同学|同事|朋友|网友|粉丝"
    "|家人|孩子|小孩|小孩子|小朋友|宝宝|宝贝|女士|先生|小姐|姑娘|小伙子|男生|女生|学生|主持人|摄影师|镜头|摄像头|相机|人|人家)们?"
)
#: For whom a gesture is: perhaps described, with a known head or a short name.
_RECIPIENT = re.compile(
    rf"(?![给向对跟和朝冲往为把])(?:[^，。]{{0,12}}的)?(?:[那这各每全]?[一两几]?[位个些群名](?:[^，。]{{0,8}}的)?)?"
    rf"(?:(?!{_PERSON})[^的，。]{{0,3}}?|[我你他她咱]们?)?{_PERSON}(?:[和跟与、]?{_PERSON})?|(?:[那这][位个])?(?!{_PERSON}|[给向对跟和朝冲往为])[^的，。]{{1,3}}"
)
_PREPOSITIONS = frozenset(
    ["给", "向", "对", "跟", "和", "与", "朝", "冲", "往", "同", "为", "对着", "冲着", "朝着", "向着"]
)
#: The most tokens of the words for a person or thing; unknown words have one for each character.
_LONGEST_NOUN = 20
_SOFT_PERSON = re.compile(
    "大家|大伙|同学|朋友|先生|各位|你们?|您|每个人|师傅|老[弟兄哥]|哥们儿?|小可爱|小家伙|家人们|老铁们|同志"
)
_ROBOT = re.compile(
    "机器人|机器狗|小机器人|底盘|小车|车子|机器小车|小狗|狗狗|大家|朋友|先生|同学|伙计|你们|你们俩"
    "|车子|同志|师傅|老[弟兄哥]|哥们儿?|小可爱|小家伙|小东西|狗[哥弟]|狗崽子?|老?伙计|小伙计|小?铁狗|大狗|机器大狗|家人们|老铁们"
)
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.TIMES)
_VERBS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)
_BREAKS = (TokenKind.COMMA, TokenKind.AND, TokenKind.END)
_MANNERS = (TokenKind.SLOW, TokenKind.FASTER, TokenKind.SPEED, TokenKind.VAGUE)
_BESIDE = re.compile("(?:你|的|那|这|在|到)*(?:左|右|后|背)[面边侧方手后]")
_TRIAL = re.compile(TRIAL)
_SIDES = (Direction.LEFT, Direction.RIGHT, Direction.BACKWARD)
#: What somebody, or the robot, does before something else.
_DONE_FIRST = re.compile(
    "(?<![给向对跟和朝冲把让叫])(?:我们?|[他她它]们?|[客别家]?人们?|大家|老师|孩子们?|同学们?|门|灯)[^，,。；;！!？?]{1,6}?"
    "了(?:之?后|以后|的时候|时|你?就|你?再)"
    "|(?:你|先)?[走转退进]了[^，,。；;！!？?]{1,8}?(?:之?后|以后|你?再)"
)
#: What begins a further picture, and what begins one that may be the one before.
_ONCE_MORE = ("再", "多", "补", "重")
_SENDS = ("发", "传", "送", "给")


def with_phrases(tokens: Sequence[Token], text: str) -> list[Token]:
    """Rewrite the tokens of a Chinese post; `text` is the post."""
    said = text.translate(TWINS)
    found, characters = list(tokens), set(said)
    for rewrite, needed in _REWRITES:
        if not needed.isdisjoint(characters):
            found = rewrite(found, said)
    return found


def _text(token: Token, said: str) -> str:
    return said[token.start : token.end]


def _before(tokens: Sequence[Token], at: int) -> Token | None:
    """Return the token before this position, passing over words without meaning."""
    return next((t for t in reversed(tokens[:at]) if t.kind is not TokenKind.SOFT), None)


def _next(tokens: Sequence[Token], at: int) -> Token | None:
    return next((t for t in tokens[at + 1 :] if t.kind is not TokenKind.SOFT), None)


def _timed(tokens: list[Token], said: str) -> list[Token]:
    """走三秒后拍照: for three seconds, and then; 三秒后拍照 stays a delay."""
    found: list[Token] = []
    for token in tokens:
        number = found[-1] if found else None
        later = token.kind is TokenKind.CONDITION and token.value == "later" and _text(token, said)[0] in "秒分"
        motion = _before(found, len(found) - 1) if later else None
        moves = motion is not None and motion.kind in (TokenKind.MOVE, TokenKind.DIR)
        if moves and number is not None and number.kind in (TokenKind.NUMBER, TokenKind.HALF):
            value = number.value if isinstance(number.value, float) else 0.5
            unit = 1.0 if _text(token, said)[0] == "秒" else 60.0
            found[-1] = Token(TokenKind.DURATION, value * unit, number.start, token.end - 1)
            found.append(Token(TokenKind.AND, None, token.end - 1, token.end))
        else:
            found.append(token)
    return found


def _stated(tokens: list[Token], said: str) -> list[Token]:
    """前面半米就是楼梯口: tells where something is; that is no walk."""
    found = list(tokens)
    for at, token in enumerate(tokens[:-1]):
        if token.kind is not TokenKind.DIR:
            continue
        following = _next(tokens, at + 1)
        there = following is not None and (following.kind is TokenKind.IS or _text(following, said) == "有")
        place = tokens[at + 1].kind is TokenKind.LENGTH or _text(token, said)[-1:] in ("面", "方", "边", "头")
        if place and tokens[at + 1].kind in _AMOUNTS and there:
            found[at] = token._replace(kind=TokenKind.WORD, value=None)
    return found


def _once_done(tokens: list[Token], said: str) -> list[Token]:
    """他走了以后走一米, 我来了就挥手: what somebody does first is a condition."""
    starts = {found.start(): found.end() for found in _DONE_FIRST.finditer(said)}
    found: list[Token] = []
    for token in tokens:
        if token.start in starts:
            found.append(Token(TokenKind.CONDITION, None, token.start, starts[token.start]))
        found.append(token)
    return found


def _reported(tokens: list[Token], said: str) -> list[Token]:
    """大家鼓掌了: others did it."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        if at and token.kind in _VERBS and _text(tokens[at - 1], said) in ("大家", "同学", "朋友", "先生"):
            following = tokens[at + 1 : at + 3]
            ended = [_text(t, said) for t in following[:1]] == ["了"] and all(t.kind in _BREAKS for t in following[1:])
            if ended and tokens[at - 1].kind is TokenKind.SOFT:
                found.append(Token(TokenKind.REPORT, None, token.start, token.start))
        found.append(token)
    return found


_RESTS = ("不动", "别动", "停")


def _waits(tokens: list[Token], said: str) -> list[Token]:
    """不动三秒, 停两秒再走: waiting, which the robots do not do."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        rests = token.kind in (TokenKind.NOT, TokenKind.MORE_STOP) and said.startswith(_RESTS, token.start)
        following = [t.kind for t in tokens[at + 1 : at + 3] if _text(t, said) != "动"] if rests else []
        timed = following[:1] == [TokenKind.DURATION]
        found.append(token._replace(kind=TokenKind.BEYOND, value="wait") if timed else token)
    return found


def _put_first(tokens: list[Token], said: str) -> list[Token]:
    """坐下之前先转一圈: the other way round, where nothing else is said in the sentence."""
    at = next((n for n, t in enumerate(tokens) if t.kind is TokenKind.CONDITION and _text(t, said) == "之前"), 0)
    end = next((n for n, t in enumerate(tokens) if n > at and t.kind is TokenKind.END), len(tokens))
    later, sooner = tokens[:at], tokens[at + 1 : end]
    plain = all(t.kind in (TokenKind.OP, TokenKind.SOFT) for t in later) and not any(t.kind in _BREAKS for t in sooner)
    if not at or not plain or not sooner or _text(sooner[0], said) != "先":
        return tokens
    both = Token(TokenKind.AND, None, tokens[at].start, tokens[at].end)
    return [*sooner, both, *later, *tokens[end:]]


def _after(tokens: list[Token], said: str) -> list[Token]:
    """前进一米后左转, 挥手完坐下: no direction, but what joins what is done and what comes next."""
    found = list(tokens)
    for at, token in enumerate(tokens):
        if token.kind not in (TokenKind.DIR, TokenKind.SOFT):
            continue
        words = _text(token, said)
        if not (token.kind is TokenKind.DIR and words == "后") and not (token.kind is TokenKind.SOFT and words == "完"):
            continue
        before, following = _before(tokens, at), _next(tokens, at)
        done = before is not None and before.kind in (*_AMOUNTS, TokenKind.OP, TokenKind.TURN)
        goes_on = following is not None and following.kind not in (*_AMOUNTS, TokenKind.NUMBER, TokenKind.WORD)
        first = (
            words == "后"
            and at
            and tokens[at - 1].kind is TokenKind.COMMA
            and re.search("先[^。；！]*[，,]$", said[: token.start])
        )
        if first and following is not None and following.kind in (TokenKind.OP, TokenKind.SHOW):
            found[at] = token._replace(kind=TokenKind.AND, value=None)
        if done and goes_on:
            found[at] = token._replace(kind=TokenKind.AND, value=None)
    return found


def _gone(tokens: list[Token], said: str) -> list[Token]:
    """往前走出去两米, 往前走过去两米, 退回来一米: a complement of the verb, where direction and amount are said."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        if token.kind not in (TokenKind.BEYOND, TokenKind.AGAIN):
            found.append(token)
            continue
        following = _next(tokens, at)
        measured = following is not None and following.kind in (TokenKind.LENGTH, TokenKind.DURATION)
        words = _text(token, said)
        before = _before(found, len(found))
        towards = before is not None and before.kind in (TokenKind.DIR, TokenKind.MOVE)
        directed = towards and any(t.kind is TokenKind.DIR for t in found[-3:])
        if token.kind is TokenKind.BEYOND and measured and directed and re.fullmatch("走?(?:过|出)[来去]", words):
            found.append(token._replace(kind=TokenKind.MOVE if words[0] == "走" else TokenKind.SOFT, value=None))
        elif token.kind is TokenKind.AGAIN and token.value == "back" and measured and words[0] == "退":
            found += [
                token._replace(kind=TokenKind.MOVE, value=None),
                token._replace(kind=TokenKind.DIR, value="backward"),
            ]
        else:
            found.append(token)
    return found


def _measured(tokens: list[Token], said: str) -> list[Token]:
    """倒一米, 行两米, 按0.2m/s: characters of many uses are verbs of motion before a distance, or name a speed."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        words = _text(token, said)
        following = _next(tokens, at) if words in ("倒", "行") else None
        before = found[-1].kind if found else TokenKind.END
        measured = following is not None and following.kind in (TokenKind.LENGTH, TokenKind.DURATION)
        begins = before in (*_BREAKS, TokenKind.SOFT, TokenKind.REQUEST, TokenKind.SLOW, TokenKind.SPEED)
        if words == "倒" and token.kind is TokenKind.WORD and measured and begins:
            found += [
                token._replace(kind=TokenKind.MOVE, value=None),
                token._replace(kind=TokenKind.DIR, value=Direction.BACKWARD.value),
            ]
        elif words == "行" and token.kind is TokenKind.SOFT and tokens[at + 1 : at + 2] == [following] and measured:
            found.append(token._replace(kind=TokenKind.MOVE, value=None))
        elif words == "按" and tokens[at + 1 : at + 2] and tokens[at + 1].kind is TokenKind.SPEED:
            continue
        else:
            found.append(token)
    return found


def _rather(tokens: list[Token], said: str) -> list[Token]:
    """不是往左，是往右平移半米: the first is denied, the second is wanted, where both are only actions."""
    if not (found := _NOT_BUT.match(said)):
        return tokens
    first = [t for t in tokens if found.end("no") <= t.start and t.end <= found.start("but")]
    last = [t for t in tokens if t.start >= found.end("but") and t.kind is not TokenKind.SOFT]
    actions = (*_VERBS, *_AMOUNTS, TokenKind.DIR, TokenKind.SOFT)
    if not first or not last or any(t.kind not in actions for t in first):
        return tokens
    if last[0].kind not in (*_VERBS, TokenKind.DIR):
        return tokens
    rest = [t for t in tokens if t.start >= found.end("but")]
    denial = Token(TokenKind.NOT, None, found.start("no"), found.end("no"))
    pause = Token(TokenKind.COMMA, None, found.start("but"), found.start("but") + 1)
    return [*(t for t in tokens if t.end <= found.start("no")), denial, *first, pause, *rest]


_NOT_BUT = re.compile(
    "\\s*(?P<no>(?:我)?不是(?:让你|叫你|要你|要)?)[^，,。；！]+(?P<but>[，,]\\s*(?:而)?是(?:让你|叫你|要你|要)?)"
)
_LISTED = re.compile("(?:(?:(?<=^)|(?<=[\\s，。；！,.;!]))[（(]?|[（(])([1-9])[）)、.．](?!\\d)")


def _enumerated(tokens: list[Token], said: str) -> list[Token]:
    """1. 坐下 2. 起立: the numbers of a list that begins with 1, and the marks after them."""
    marks = list(_LISTED.finditer(said))
    if len(marks) < 2 or [int(mark[1]) for mark in marks] != list(range(1, len(marks) + 1)):
        return tokens
    found: list[Token] = []
    for token in tokens:
        mark = next((m for m in marks if m.start() <= token.start and token.end <= m.end()), None)
        if mark is None:
            found.append(token)
        elif mark is not marks[0] and token.kind is TokenKind.NUMBER:
            found.append(token._replace(kind=TokenKind.AND, value=None))
    return found


def _repeated(tokens: list[Token], said: str) -> list[Token]:
    """坐下起立做三遍: both may be meant, or the last."""
    found = list(tokens)
    for at, token in enumerate(tokens):
        if _text(token, said) not in ("做", "来", "连做"):
            continue
        following, before = _next(tokens, at), [t for t in tokens[:at] if t.kind is not TokenKind.SOFT][-2:]
        actions = [t.kind for t in before] == [TokenKind.OP, TokenKind.OP]
        counted = following is not None and following.kind is TokenKind.TIMES
        if actions and counted:
            found[at] = token._replace(kind=TokenKind.WORD, value=None)
    return found


def _is_noun(token: Token) -> bool:
    """Return whether a token may be part of the words for a person or thing."""
    plain = token.kind in (TokenKind.WORD, TokenKind.TALK) and token.value in (None, "person")
    return plain or token.kind in (TokenKind.SOFT, TokenKind.DIR)


def _begun(tokens: list[Token], said: str) -> list[Token]:
    """再拍 at the end: a picture; 我想看挥手: that is wanted; 坐下再站起来，做两遍: all of it again."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        words = _text(token, said)
        if words not in ("拍", "看", "做", "来", "连做"):
            found.append(token)
            continue
        following, before = _next(tokens, at), found[-1] if found else None
        ends = following is None or following.kind in _BREAKS
        if token.kind is TokenKind.SHOW and words == "拍" and ends:
            found.append(token._replace(kind=TokenKind.OP, value=PHOTO.value))
        elif token.kind is TokenKind.TURN and words == "看" and before is not None and before.kind is TokenKind.REQUEST:
            wanted = following is not None and following.kind is TokenKind.OP and following.value != PHOTO
            found += [] if wanted else [token]
        elif words in ("做", "来", "连做") and before is not None and before.kind is TokenKind.COMMA:
            after = [t.kind for t in tokens[at + 1 : at + 3] if t.kind is not TokenKind.SOFT]
            again = after[:1] == [TokenKind.TIMES] and (len(after) == 1 or after[1] in _BREAKS)
            found.append(token._replace(kind=TokenKind.AGAIN, value="this") if again else token)
        else:
            found.append(token)
    return found


def _further(tokens: list[Token], said: str) -> list[Token]:
    """拍张照，再拍一张: a further picture; 再发张照片 may send the same."""
    found: list[Token] = []
    for token in tokens:
        words, before = _text(token, said), _text(found[-1], said) if found else ""
        takes = token.value == PHOTO and not words.startswith(_SENDS)
        again = words.startswith(_ONCE_MORE) or before.endswith(_ONCE_MORE)
        found.append(token._replace(more=True) if takes and again else token)
    return found


def _looked(tokens: list[Token], said: str) -> list[Token]:
    """看一眼拍个照: one picture in two words.

    前进半米看看 may only ask to try, 想看看后面，转180度拍一张 may only say why, and 拍照拍照 may only insist: such a
    word becomes unknown, so that the robot asks.
    """
    found: list[Token] = []
    for at, token in enumerate(tokens):
        pair = [t for t in tokens[at + 1 : at + 4] if t.kind is not TokenKind.SOFT]
        photo = token.value == PHOTO
        looks = photo and [t.value for t in pair[:1]] == ["look"]
        if looks and [t.value for t in pair[1:2]] == [PHOTO]:
            continue
        if token.value == "look" and found[-1:] != [tokens[at - 1]] and tokens[at - 1].kind is TokenKind.OP:
            continue
        doubtful = _tries(tokens, at) or _wishes(tokens, at, said) if looks else photo and _insists(tokens, at, said)
        doubtful = doubtful or (photo and _judges(token, said))
        found.append(token._replace(kind=TokenKind.WORD, value=None) if doubtful else token)
    return found


def _judges(token: Token, said: str) -> bool:
    """Return whether 看看 is followed by what is tried, 让我看看效果如何, or by what is not ahead, 看一下左边."""
    if said[token.end - 1] not in "看瞧瞅下眼":
        return False
    if _BESIDE.match(said, token.end):
        return True
    begun = max(said.rfind(mark, 0, token.start) for mark in "，。；！？,;!? ") + 1
    return any(found.start() <= token.start < found.end() for found in _TRIAL.finditer(said, begun, token.end + 20))


def _tries(tokens: Sequence[Token], at: int) -> bool:
    """Return whether 看看 ends a clause right after an action other than a photo."""
    before, following = _before(tokens, at), _next(tokens, at + 1)
    action = before is not None and (before.kind in _VERBS or before.kind in _AMOUNTS)
    begun = next((i for i in range(at - 1, -1, -1) if tokens[i].kind in _BREAKS), -1)
    photo = any(token.value == PHOTO for token in tokens[begun + 1 : at])
    return action and not photo and (following is None or following.kind in _BREAKS)


def _wishes(tokens: Sequence[Token], at: int, said: str) -> bool:
    """Return whether 想看看 begins what a photo is for that is asked for later."""
    wish = _text(tokens[at], said).lstrip("我")[:1] in ("想", "要")
    return wish and any(t.value == PHOTO for t in tokens[at + 1 :])


def _insists(tokens: Sequence[Token], at: int, said: str) -> bool:
    """Return whether the same word stands right before this one: 拍照拍照."""
    before = _before(tokens, at)
    return before is not None and _text(before, said) == _text(tokens[at], said)


def _with_recipients(tokens: list[Token], said: str) -> list[Token]:
    """Drop for whom a gesture is, 向老人挥手; towards somebody, 朝大家走一米, is a place."""
    found: list[Token] = []
    at = 0
    while at < len(tokens):
        token = tokens[at]
        begun = _begin_of_recipient(token, said)
        if begun and (end := _end_of_recipient(tokens, at, begun, said)):
            found.append(tokens[end]._replace(start=token.start))
            at = end + 1
            continue
        found.append(token)
        at += 1
        after = tokens[at] if at < len(tokens) else token
        if token.value == Soft.TOWARDS and after.kind is TokenKind.SOFT and _ROBOT.fullmatch(_text(after, said)):
            found.append(after._replace(kind=TokenKind.WORD, value="place"))
            at += 1
    return found


def _begin_of_recipient(token: Token, said: str) -> int:
    """Return where the words for somebody begin after a preposition, 0 if this is none: 给|奶奶, 给|我妈."""
    words = _text(token, said)
    if words in _PREPOSITIONS:
        return token.end
    described = token.kind is TokenKind.DIR and said[token.end : token.end + 1] == "的"
    mine = words in ("给我", "给咱", "给我们", "给咱们")
    return token.start + 1 if mine or (described and words[:1] in ("向", "朝", "往", "冲")) else 0


def _end_of_recipient(tokens: Sequence[Token], at: int, begun: int, said: str) -> int:
    """Return the position of the gesture that is for somebody, 0 if there is none; a picture may be taken for them."""
    end = _end_of_noun(tokens, at + 1)
    between = tokens[at + 1 : end]
    op = str(tokens[end].value).split("/")[0] if end < len(tokens) and tokens[end].kind is TokenKind.OP else ""
    shown = (
        end < len(tokens) and tokens[end].kind in (TokenKind.MOVE, TokenKind.TURN) and said[tokens[at].start] in "给为"
    )
    if op not in FOR_SOMEBODY and not (op == PHOTO and said[tokens[at].start] in "给为替帮") and not shown:
        return 0
    noun = said[begun : tokens[end].start].strip()
    named = any(t.kind is not TokenKind.SOFT or _SOFT_PERSON.fullmatch(_text(t, said)) for t in between)
    sided = any(t.kind is TokenKind.DIR for t in between)
    known = named and _RECIPIENT.fullmatch(noun) and (not sided or re.search(f"的|那|{_PERSON}$", noun))
    return end if known else 0


def _end_of_noun(tokens: Sequence[Token], at: int) -> int:
    end = at
    while end < len(tokens) and end - at < _LONGEST_NOUN and _is_noun(tokens[end]):
        end += 1
    return end


def _of_subjects(tokens: list[Token], said: str) -> list[Token]:
    """拍一张院子的照片, 把眼前的东西拍下来: what the picture shows; what is beside or behind is asked about."""
    found: list[Token] = []
    at = 0
    while at < len(tokens):
        token = tokens[at]
        takes = token.kind is TokenKind.SHOW or token.value == PHOTO
        if not takes and token.value != Soft.OBJECT:
            found.append(token)
            at += 1
            continue
        end = at + 1
        count = next((t for t in tokens[end : end + 1] if t.kind in (TokenKind.TIMES, TokenKind.NUMBER)), None)
        end += count is not None
        end = _end_of_noun(tokens, end)
        goal = tokens[end] if end < len(tokens) else token
        between = tokens[at + 1 : end]
        ahead = not any(t.kind is TokenKind.DIR and t.value in _SIDES for t in between)
        if takes and ahead and goal.kind is TokenKind.PICTURE and between and _text(between[-1], said) == "的":
            found.append(Token(TokenKind.OP, PHOTO.value, token.start, goal.end))
            found += [] if count is None else [count._replace(kind=TokenKind.TIMES)]
            at = end + 1
        elif token.value == Soft.OBJECT and ahead and goal.value == PHOTO and between:
            found.append(goal._replace(start=token.start))
            at = end + 1
            if at < len(tokens) and tokens[at].kind is TokenKind.OF and tokens[at].value is None:
                at += 1
        else:
            found.append(token)
            at += 1
    return found


def _counted_ahead(tokens: list[Token], said: str) -> list[Token]:
    """做三次挥手, 来两个后空翻: the count is of what follows; 挥手做三次坐下 may mean either."""
    found = list(tokens)
    for at, token in enumerate(tokens):
        if token.kind not in (TokenKind.NUMBER, TokenKind.TIMES):
            continue
        following = tokens[at + 1 : at + 3]
        measured = token.kind is TokenKind.NUMBER and [_text(t, said) for t in following[:1]] == ["个"]
        of = following[1:] if measured or [_text(t, said) for t in following[:1]] == ["的"] else following
        if not (measured or token.kind is TokenKind.TIMES) or not of or of[0].kind is not TokenKind.OP:
            continue
        begun, before = _text(tokens[at - 1], said) if at else "", _before(tokens, at)
        if before is not None and before.kind not in _BREAKS:
            if token.kind is TokenKind.TIMES and begun in ("做", "来", "上"):
                found[at] = token._replace(kind=TokenKind.WORD, value=None)
        elif begun in ("做", "来", "上", "表演") or token.kind is TokenKind.TIMES:
            place = found.index(of[0])
            found[at] = of[0]._replace(start=token.start)
            found[place] = token._replace(kind=TokenKind.TIMES)
    return found


def _shared(tokens: list[Token], said: str) -> list[Token]:
    """左右各转30度, 挥手和比心各两次: what is said once is meant for each of several."""
    for at, token in enumerate(tokens):
        if token.value != "each" or token.kind is not TokenKind.WORD:
            continue
        begun = _begin_of_items(tokens, at, said)
        items, end = _items(tokens[begun:at]), at + 1
        most = min(len(tokens), end + _LONGEST_NOUN)
        while end < most and tokens[end].kind not in (*_BREAKS, *_AMOUNTS):
            end += 1
        verbs = [t for t in tokens[at + 1 : end] if t.kind is not TokenKind.SOFT]
        amount = tokens[end] if end < len(tokens) else token
        before = tokens[begun - 1].kind if begun else TokenKind.END
        if len(items) < 2 and not any(items) and verbs and re.search("[俩位]|你们", said[: token.start]):
            return [*tokens[:at], *_shared(list(tokens[at + 1 :]), said)]  # 你们俩各走一米
        if len(items) < 2 or amount.kind not in _AMOUNTS or before in _MANNERS or not _fits(items, verbs, amount):
            continue
        spread: list[Token] = []
        for item in items:
            spread += [*item, *verbs, amount, Token(TokenKind.AND, None, amount.end, amount.end)]
        return [*tokens[:begun], *spread[:-1], *_shared(list(tokens[end + 1 :]), said)]
    return tokens


def _begin_of_items(tokens: Sequence[Token], at: int, said: str) -> int:
    """Return where the list before 各 begins."""
    while at:
        token = tokens[at - 1]
        listed = token.kind in (*_VERBS, TokenKind.DIR, TokenKind.SOFT)
        joint = token.kind in (TokenKind.AND, TokenKind.COMMA) and _text(token, said) in "和与跟及以及还有、"
        if not (listed or joint):
            break
        at -= 1
    return at


def _items(tokens: Sequence[Token]) -> list[list[Token]]:
    """Split a list of directions and verbs: 左右, 左转和右转, 前进后退."""
    items: list[list[Token]] = [[]]
    for token in tokens:
        if token.kind is TokenKind.SOFT:
            continue
        last = items[-1]
        split = token.kind in _BREAKS
        whole = bool(last) and token.start == last[-1].start and token.kind is not last[-1].kind  # 前进
        alike = [t for t in last if (t.kind in _VERBS) is (token.kind in _VERBS)]
        if split or (not whole and (alike or (token.kind is TokenKind.DIR and any(t.kind in _VERBS for t in last)))):
            items.append([])
        if not split:
            items[-1].append(token)
    return [item for item in items if item]


def _fits(items: Sequence[Sequence[Token]], verbs: Sequence[Token], amount: Token) -> bool:
    """Return whether the verb and amount after 各 make a whole step of each item."""
    for item in items:
        found = [t for t in (*item, *verbs) if t.kind in _VERBS]
        if len(found) != 1 or len(item) + len(verbs) > 3 or any(t.kind not in (*_VERBS, TokenKind.DIR) for t in verbs):
            return False
        kind = found[0].kind
        directed = any(t.kind is TokenKind.DIR for t in item)
        sided = kind is TokenKind.OP or directed
        wanted = {TokenKind.TURN: (TokenKind.ANGLE,), TokenKind.OP: (TokenKind.TIMES,)}
        if not sided or amount.kind not in wanted.get(kind, (TokenKind.LENGTH, TokenKind.STEPS, TokenKind.DURATION)):
            return False
    return True


#: Each rewriting, in this order, and characters of which it needs one: most posts need none.
_REWRITES = (
    (praised, frozenset("的得真好太很非超特挺相这那有不棒")),
    (reported_pictures, frozenset("谢收看存拍照很真太不好挺糊模清漂美歪反倒黑亮没呢")),
    (rests_after, frozenset("动")),
    (shared_later, frozenset("都均全")),
    (sits_or_does, frozenset("做")),
    (_enumerated, frozenset("1")),
    (_rather, frozenset("是")),
    (_measured, frozenset("倒行按")),
    (_repeated, frozenset("做来")),
    (_stated, frozenset("是有")),
    (_once_done, frozenset("了")),
    (_reported, frozenset("了")),
    (_timed, frozenset("后")),
    (_waits, frozenset("停不别")),
    (_after, frozenset("后完")),
    (_put_first, frozenset("前")),
    (_gone, frozenset("过出退")),
    (_begun, frozenset("拍看做来")),
    (_further, frozenset("再多补重")),
    (_looked, frozenset("看瞧瞅拍")),
    (_with_recipients, frozenset("给向对跟和与朝冲往同为到着")),
    (of_relative_clauses, frozenset("的")),
    (only_one_of_two, frozenset("只")),
    (denied_until_request, frozenset("没不别勿")),
    (_of_subjects, frozenset("的把将")),
    (_counted_ahead, frozenset("次遍回个下")),
    (_shared, frozenset("各别")),
)
