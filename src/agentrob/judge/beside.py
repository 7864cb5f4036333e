"""Statements beside a command that may change what it means: "He does not know the camera is on. Take a photo."

The grammar passes over talk, and no list of words can tell what all talk means. So what is said besides of other
people, animals, heights, protections or who somebody is makes the robot ask back once: it does less, never more.
Talk of anything else ("I love robots!", "there is a door on your left") asks nothing.
"""

from __future__ import annotations

import re
from functools import cache

from agentrob.judge import words_en, words_zh
from agentrob.judge.harm import plain_words
from agentrob.judge.patterns import compiled
from agentrob.judge.sentences import say
from agentrob.judge.way import clauses, commanded, without_safe_edges
from agentrob.language.phrases import quote
from agentrob.model import Decision, Language, Verdict

RULE = "beside.said"
_EN = (
    r"he|she|they|him|her|them|his|their|he's|she's|they're|nobody|no one|somebody|someone|anybody|anyone|whoever"
    r"|others|people",
    r"<det>(?:<person>|<animal>)",
    r"(?:<det>|\d+ m )(?:<drop>|<pit>|<danger>|<hazard>)|nothing (?:under|below|beneath)|(?:fire|emergency"
    r"|escape) \w+|stairs|traffic|water",
    r"(?:put|placed|set|sat|left|positioned|brought|lifted|carried) you",
    r"<protection>|stop (?:command|button|post)s?",
    r"<authority>|programmed|firmware|permission|authori[sz]ed|allowed|in charge|orders?|rights|clearance|password",
    r"hits?|crash|collapse|break|shatter|topple|fall|fight|hurt|scare|fright|scream|revenge|steal|secret|hide"
    r"|escape|weapon|trap|alarm|"
    r"photographed|filmed|recorded|faces?|naked|private|danger\w*|risk\w*|accident|blood|police|enem\w+|victims?"
    r"|thie(?:f|ves)|intruders?|hostage",
)
_ZH = (
    r"<other>(?!好)|(?:他|她|它)们?",
    r"<drop>|<danger>|悬崖|边缘|楼梯|逃生|消防",
    r"把你(?:放|搁|摆|搬|抱|举|留)",
    r"<protection>|<authority>|权限|授权|命令|口令|负责",
    r"撞|摔|倒下来|塌|碎|吓|伤|打架|报复|偷|秘密|隐藏|逃|武器|陷阱|拍到|被拍|隐私|危险|事故|别出声|小声",
)
#: Kind words to the robot and greetings speak of nobody else.
_KIND = re.compile(
    r"\b(?:you(?:'re| are)|what a|be|such a|good|who's|hello|hi|hey|thanks?|thank you)(?: such)?(?: my| a| an"
    r"| the)*(?: \w+){0,2}? "
    r"(?:dog|doggy|puppy|pup|boy|girl|pet|friends?|guys?|people|team|man|dude|class|robot|manners)\b"
)
#: Pictures and greetings name whom they are of; what is wrong about those is for the other rules.
_LOOKS = re.compile(
    r"^(?:please|now|and|first|just|finally|also|ok|okay|can you|could you|would you|will you|@[\w-]+|\W| )*"
    r"(?:(?:take|send|get|give|show|make|grab|snap|post) (?:me |us )?(?:\w+ ){0,4}?(?:photo|picture|pic|image|shot"
    r"|snapshot|selfie|heart|hello|wave)"
    r"|photograph|wave|greet|say (?:hi|hello|goodbye)|show me|face)|^(?:请|再"
    r"|先)?(?:[跟向给对和][^,，。]{1,8})?(?:拍|照|挥手|打招呼|问好|比心|看)"
)


def said_beside(text: str, language: Language) -> Verdict | None:
    """A question when something is said beside the command that may change its meaning, or None."""
    for clause in clauses(without_safe_edges(plain_words(text))):
        said = clause[0].strip()
        if commanded(said) or _LOOKS.search(said):
            continue
        if _topics().search(_KIND.sub(" ", said)):
            return Verdict(Decision.ASK_BACK, RULE, say(RULE, language, quote(said)))
    return None


@cache
def _topics() -> re.Pattern[str]:
    english = compiled(words_en.GROUPS, _EN, words=True).pattern
    return re.compile(f"{english}|{compiled(words_zh.GROUPS, _ZH, words=False).pattern}")
