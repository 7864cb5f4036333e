"""English words for harm in Chinese sentences ("追那个kid", "要crash了"), translated for the rules about danger.

Each rule matches one language, so a sentence that mixes both would match neither.
"""

from __future__ import annotations

import re

_HAN = "[\u3400-\u9fff]"
#: The English words by the Chinese word that the rules match.
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
    """Translate the English words for harm in a text that has Chinese characters; return any other text unchanged.

    `text` is in lower case. Drop the spaces beside these words, because the rules expect none.
    """
    if not re.search(_HAN, text):
        return text
    marked = _WORD.sub(lambda found: f"\0{_CHINESE[found[0]]}\0", text)
    return re.sub(" ?\0+ ?", "", marked)
