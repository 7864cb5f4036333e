"""Mask what a remark says to be absent, elsewhere or dealt with, so that it is not asked about: "the cat is upstairs".

What remains of the clause is still checked ("the cat is upstairs and the floor is wet"), and so is every obstacle near
the robot, by its sensors.
"""

from __future__ import annotations

from functools import cache

from agentrob.screening.text.harm import ENGLISH
from agentrob.screening.text.patterns import Phrases, Vocabulary
from agentrob.screening.text.words import zh as words_zh

_WHEN = r"(?: (?:today|now|already|anyway|currently|right now|at the moment|for (?:now|\w+)))*$"
_IS = r"(?:'s|'re| is| are| was| were| has been| have been) (?:all |safely |still |just )*"
#: A subject without a negation. That a protection or a person in charge is away, or an exit closed, is asked about.
_SUBJECT = (
    r"^(?:(?!\b(?:not|never|no|nothing|without|your|fire|emergency|escape|exit|<authority>|<protection>)\b|n't\b)"
    r"[^,]){1,50}?"
)
_EN = (
    # Nobody is here. "Nobody is holding the ladder" is another statement.
    r"(?:there(?:'s| is| are) )?(?:nobody|no one|no-one|no (?:other )?(?:<person>|<animal>))"
    r"(?: else)?(?:'s| is| are)?(?: anywhere| standing| left)? (?:here|there|around|near(?:by)?|about|home"
    r"|(?:in|on|near) (?:the|this|my|our|that|your) (?:\w+ )?(?:rooms?|hall|hallway|corridor|building|house|office|lab"
    r"|street|field|lawn|garden|way|path|kitchen|area|floor))" + _WHEN,
    # Somebody or something is in another place.
    _SUBJECT + _IS + r"(?:in (?:another|a different|the next|the other) \w+|at (?:school|work|home|the vet|the vet's"
    r"|the office|lunch)|on the (?:other|far) side(?: of (?:the|this) (?:building|house|hall|street|city|town))?"
    r"|upstairs|downstairs|outside|far away|miles away|out of the way|on (?:holiday|vacation)"
    r"|behind the (?:rope|line|yellow line|tape|barrier))" + _WHEN,
    # A way to a danger is closed, or the danger is gone.
    _SUBJECT
    + _IS
    + r"(?:closed|locked|shut|fenced off|roped off|mopped up|cleaned up|wiped up|drained|put away)"
    + _WHEN,
    _SUBJECT
    + r"(?:'s| is| are) (?:so |very |really |quite )?(?:loud|noisy|quiet|pretty|nice|lovely|beautiful|cute)"
    + _WHEN,
    # Somebody's likes, and the person whom a command is for.
    r"^(?:lol|haha|btw|and|so|by the way|\W)*(?:my|our|the|his|her) (?:\w+ )?(?:<person>|<animal>)"
    r" (?:really |also |just |always )?(?:likes?|loves?|hates?|misses|adores?|enjoys?|has|have)"
    r"(?: (?:you|it|this|that|robots?|videos?|photos?|pictures?|music|the same \w+)){1,2}$",
    r"^i (?:really )?(?:miss|love|like) (?:my|our|the) (?:\w+ )?(?:<person>|<animal>)$",
    r"^(?:this|that|it)(?:'s| is)(?: all)? for (?:a|the|my|our) (?:\w+ )?(?:<person>)$",
)
_ZH = (
    r"(?:没有?|冇|无)(?:其他|别的|一个)?(?:人|车|障碍物?|东西|小孩|孩子|狗|猫|宠物)(?!看|管|知道|发现|拦|能|扶|牵)",
    r"(?:口|里|边|上)?人(?:都|全|已经)*(?:走光|走完|撤走|离开)[了啦]?|人(?:都|全)?在[^，,。]{0,6}(?:开外|以外|线外|围栏外)",
    r"(?:场地|走廊|房间|路)(?:已经|都)*清空[了啦]?",
    r"(?:障碍物?|东西|椅子|桌子|杂物|箱子)(?:已经|都|全)*(?:挪开|搬走|移开|拿走|收走|收好|清走|清掉|挪走)[了啦]?",
    r"(?!<authority>|保安|门卫)(?:<who>|<drop>|<danger>)[^，,。]{0,3}?在(?:另外?一?(?:头|边|个|间|侧)|别的|隔壁|楼上|楼下|家里?|学校|公司|医院|外地)"
    r"[^，,。]{0,4}$",
    r"(?!<authority>|保安|门卫)(?:<who>)(?:已经|都|今天|现在)*(?:不在(?:家|这儿|这里|附近)?|上学去?[了啦]|上班去?[了啦]|出门[了啦])$",
    r"(?:<drop>|<danger>|门)[^，,。不没]{0,8}?(?:锁着|锁上了|锁好了|关着|关上了|封住了|封起来了|擦干净?了|拖干了|放干了)",
    r"(?:两边|两侧|四周|周围)都?有(?:护栏|栏杆|围栏)|^(?:这里|那里|这边|现在)?(?:很|挺|非常|都)安全的?$",
    r"朋友圈|机器(?:狗|人)|(?:<who>)(?:都)?(?:说你|觉得你)(?:像|真|很|好|可爱|厉害|乖)",
)


def masked(said: str) -> str:
    """Return a clause without what it says to be elsewhere."""
    for phrases in _phrases():
        said = phrases.sub(" ", said)
    return said


@cache
def _phrases() -> tuple[Phrases, ...]:
    english = Vocabulary(ENGLISH.groups, words=False)
    return Phrases(english, _EN), Phrases(Vocabulary(words_zh.GROUPS, words=False), _ZH)


def prepare() -> None:
    """Compile all patterns in advance."""
    for phrases in _phrases():
        phrases.prepare()
