"""Chinese phrases that are asked about, or only reported: 前进一米，别动, 都是四十五度, 照片收到了.

Each function takes the tokens of a post and returns them rewritten, as those in `zh_phrases`.
"""

from __future__ import annotations

import re

from agentrob.language.parser.lexicon import Token, TokenKind

_PICTURES = "照片|相片|图片|图像|截图|合影|合照|特写|美照|快照|画面|视图|图|照"
_PICTURE_REPORTED = re.compile(
    rf"(?:谢谢|感谢|多谢|谢)(?:你们?|您|大家)?(?:的|发的|拍的|这张|那张)*(?P<picture>{_PICTURES})"
    rf"|(?<![拍照发传来张个])(?P<reported>{_PICTURES})(?:我|我们|大家|都|也|已经?|全|刚|有点|好像)*"
    "(?:收到|看到|看见|看了|存|保存|拍得|拍的|照得|很|真|太|不错|好[看漂]|挺|糊|模糊|清[楚晰]|漂亮|美|歪|反了|倒|黑|亮|没|不见|呢)"
)
_OF_ALL = re.compile(r"(?:都|均|全)(?:是|为|转|走|按|用)?(?=[\d一二两三四五六七八九十半百])")
_REST = re.compile("(?:千万)?(?:别|不要|不许|不准|不能|不可以|请勿|勿)(?:再|乱|随便|到处)*动(?![手作脑弹力])")
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.TIMES)


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
