"""English words of harm within Chinese sentences ("追那个kid", "要crash了"), in Chinese for the rules about danger.

Those rules know sentences of one language; a sentence of both would pass between them.
"""

from __future__ import annotations

import re

_HAN = "[\u3400-\u9fff]"
#: What the Chinese rules say for these English words.
_LOAN_WORDS = {
    "打": "beat beating punch punching slap slapping",
    "踢": "kick kicks kicking",
    "推": "push pushes pushing shove shoving",
    "追": "chase chases chasing",
    "跟着": "follow follows following",
    "跟踪": "stalk stalking",
    "撞": "hit hits hitting crash crashes crashing ram ramming bump bumping collide",
    "砸": "smash smashes smashing",
    "攻击": "attack attacks attacking",
    "吓": "scare scaring",
    "咬": "bite biting",
    "杀": "kill killing",
    "摔": "fall falls falling",
    "孩子": "kid kids child children baby boy girl",
    "人": "people person guy guys man woman someone somebody stranger",
    "他": "him",
    "她": "her",
    "他们": "them",
    "猫": "cat cats",
    "墙": "wall",
    "楼梯": "stairs",
    "玻璃": "glass window",
}
_CHINESE = {word: chinese for chinese, words in _LOAN_WORDS.items() for word in words.split()}
#: Not a part of a handle, of an address or of a longer word.
_WORD = re.compile(rf"(?<![a-z0-9_@'./-])(?:{'|'.join(_CHINESE)})(?![a-z0-9_'./-])")


def in_chinese(text: str) -> str:
    """Return a text with its English words of harm in Chinese; unchanged if it has no Chinese character.

    `text` is in lower case. Spaces beside these words go, as Chinese has none.
    """
    if not re.search(_HAN, text):
        return text
    marked = _WORD.sub(lambda found: f"\0{_CHINESE[found[0]]}\0", text)
    return re.sub(" ?\0+ ?", "", marked)
