"""Chinese phrases that are asked about, or only reported: 前进一米，别动, 都是四十五度, 照片收到了.

Each function takes the tokens of a post and returns them rewritten, as those in `zh_phrases`.
"""

from __future__ import annotations

import re

from agentrob.language.locales.en_phrases import as_judgement
from agentrob.language.parser.lexicon import Token, TokenKind

_PICTURES = "照片|相片|图片|图像|截图|合影|合照|特写|美照|快照|画面|视图|图|照"
_PICTURE_REPORTED = re.compile(
    rf"(?:谢谢|感谢|多谢|谢)(?:你们?|您|大家)?(?:的|发的|拍的|这张|那张)*(?P<picture>{_PICTURES})"
    rf"|(?<![拍照发传来张个])(?P<reported>{_PICTURES})(?:我|我们|大家|都|也|已经?|全|刚|有点|好像)*"
    "(?:收到|看到|看见|看了|存|保存|拍得|拍的|照得|很|真|太|不错|好[看漂]|挺|糊|模糊|清[楚晰]|漂亮|美|歪|反了|倒|黑|亮|没|不见|呢)"
)
_OF_ALL = re.compile(r"(?:都|均|全)(?:是|为|转|走|按|用)?(?=[\d一二两三四五六七八九十半百])")
_REST = re.compile("(?:千万)?(?:别|不要|不许|不准|不能|不可以|请勿|勿)(?:再|乱|随便|到处)*动(?![手作脑弹力])")
_DO_ALONE = re.compile(r"(?:^|[，,。；;！!\s先再])(做下)(?=$|[，,。；;！!\s]|然后|接着|再)")
_RELATIVE = re.compile("的(?!同时|时候|时)(?=[^，。！？；,.!?;\\s了吧呢吗话])")
_POLITE = ("麻烦", "请", "劳驾", "拜托", "烦请")
_ONLY = re.compile("只[^，,。；;]{1,6}不[^，,。；;]{1,6}[，,]")
_TAKEN = re.compile("[拍照摄][下到好]?的")
_VERBS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)
_BREAKS = (TokenKind.COMMA, TokenKind.AND, TokenKind.END)
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.TIMES)
#: An action of the robot, and an opinion about it.
_ACTION = (
    "(?:拍照?|照相|挥手|招手|握手|比心|跳舞|舞蹈?|转圈|转身|坐下?|站"
    "|伸懒腰|后空翻|鞠躬|走路?|转|打招呼|问好|动作|姿势|表演|鼓掌|击掌|拜年|作揖)"
)
_BLAME = "丑|难看|差|烂|奇怪|僵硬|笨"
_OPINION = (
    f"(?:棒极了?|棒|好看|漂亮|可爱|帅气?|酷|乖|厉害|精彩|不错|优雅|好|稳|萌|甜|赞|牛|标准|到位|有趣|搞笑|美|{_BLAME})"
)
_VERY = "(?:真的?|好|太|很|非常|超级?|特别|挺|相当|这么|那么|有点)"
_PRAISED = re.compile(
    r"(?:^|[。！!？?\n])[\s，,]*(?:(?:哇|哈+|谢谢|嗯|天哪|哎呀|厉害)[啊呀哦\s，,]*)*(?:你的|这个?|那个?|刚才的?|这次的?)*"
    rf"(?P<praise>(?:好|真|很|太|超|非常)?{_OPINION}的{_ACTION}"
    rf"|{_ACTION}(?:{_ACTION})?(?:得{_VERY}?{_OPINION}|{_VERY}{_OPINION}|不错|棒极))[了啊呀哦哈呢吧的]*"
    r"\s*(?=$|[。！!？?，,~～…\n])"
)


def shared_later(tokens: list[Token], said: str) -> list[Token]:
    """先左转再右转，都是四十五度: what is said of all actions before is not the amount of the last one."""
    starts = [found.start() for found in _OF_ALL.finditer(said)]
    found = [t._replace(kind=TokenKind.WORD, value=None) if t.start in starts else t for t in tokens]
    return found


def rests_after(tokens: list[Token], said: str) -> list[Token]:
    """前进一米，别动: it may mean to stay there afterwards, or deny the walk; 停下别动 and 然后别动 are clear."""
    found = list(tokens)
    for rest in _REST.finditer(said):
        at = next((n for n, t in enumerate(found) if t.start >= rest.start()), len(found))
        before = [t for t in found[:at] if t.kind not in (TokenKind.SOFT, TokenKind.COMMA, TokenKind.END)]
        motion = bool(before) and before[-1].kind in (TokenKind.MOVE, TokenKind.TURN, TokenKind.DIR, *_AMOUNTS)
        if not motion:
            continue
        after = next((n for n, t in enumerate(found) if t.start >= rest.end()), len(found))
        denial = [Token(k, None, rest.start(), rest.end()) for k in (TokenKind.NOT, TokenKind.MOVE, TokenKind.TURN)]
        found[at:after] = denial
    return found


def reported_pictures(tokens: list[Token], said: str) -> list[Token]:
    """谢谢你的照片, 照片收到了: something is said of a picture, none is asked for."""
    reported = [found.span(found.lastgroup or 0) for found in _PICTURE_REPORTED.finditer(said)]

    def is_reported(token: Token) -> bool:
        return token.kind is TokenKind.PICTURE and any(start <= token.start < end for start, end in reported)

    return [token._replace(kind=TokenKind.WORD, value=None) if is_reported(token) else token for token in tokens]


def of_relative_clauses(tokens: list[Token], said: str) -> list[Token]:
    """拍的照片, 走的路: an action that describes a thing is not commanded."""

    def describes(token: Token) -> bool:
        of = _RELATIVE.match(said, token.end) or _TAKEN.match(said, token.start)
        return token.kind in (*_VERBS, TokenKind.SHOW) and of is not None

    return [token._replace(kind=TokenKind.WORD, value=None) if describes(token) else token for token in tokens]


def denied_until_request(tokens: list[Token], said: str) -> list[Token]:
    """没有人麻烦你后退: the request is not denied, so the denial's end is not known."""
    found = list(tokens)
    acts = asked = False  # whether a verb, and a request before it, stand later in the clause
    for at in range(len(tokens) - 1, -1, -1):
        token = tokens[at]
        if token.kind is TokenKind.NOT and asked:
            found[at] = token._replace(kind=TokenKind.WORD, value=None)
        ends = token.kind in _BREAKS
        acts = not ends and (acts or token.kind in _VERBS)
        asked = not ends and (asked or (acts and said[token.start : token.end].startswith(_POLITE)))
    return found


def only_one_of_two(tokens: list[Token], said: str) -> list[Token]:
    """只转身不走路: it does not say whether the turn is one more or the one that is commanded."""
    found = [match.start() for match in _ONLY.finditer(said)]
    return [t._replace(kind=TokenKind.WORD, value=None) if t.start in found else t for t in tokens]


def sits_or_does(tokens: list[Token], said: str) -> list[Token]:
    """做下，站起来: likely 坐下 with a wrong character, so it must not be passed over as "do"."""
    found = [match.start(1) for match in _DO_ALONE.finditer(said)]
    return [t._replace(kind=TokenKind.WORD, value=None) if t.start in found else t for t in tokens]


def praised(tokens: list[Token], said: str) -> list[Token]:
    """漂亮的挥手, 跳得真棒: the robot is praised, or blamed, for what it did, and nothing is asked for."""
    found = tokens
    for praise in _PRAISED.finditer(said):
        found = as_judgement(found, *praise.span("praise"), blames=re.search(_BLAME, praise["praise"]) is not None)
    return found
