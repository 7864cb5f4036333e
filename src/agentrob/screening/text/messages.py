"""What a refusal for harm says, in one sentence by rule and language. Words of people go through `quote` first."""

from __future__ import annotations

from agentrob.language.messages.catalog import say as say_phrase
from agentrob.model import Language

_EN = {
    "harm.hazard": "I do not go into fire, water, traffic or the like ({words}).",
    "people.follow": "I do not follow, chase or corner anybody ({words}).",
    "people.block": "I do not block doors, ways or people ({words}).",
    "people.watch": "I do not watch people in secret, nor take pictures of what is private ({words}).",
    "people.picture": (
        "You want a picture of somebody else ({words}). I take one when they ask for it themselves; "
        "`take a photo` of what is before me needs no person named."
    ),
    "people.trick": "I do not deceive, lure or distract anybody ({words}).",
    "who.claim": "Who somebody is, and what they may do, I know from their account, not from a text ({words}).",
    "safety.secret": "What I do is reported and recorded as it was ({words}).",
    "bounds.leave": "I stay inside the area my owner set ({words}).",
    "way.somebody": "You say that somebody is where I would go ({words}).",
    "way.drop": "You say that there is a drop or a danger where I would go ({words}).",
    "way.thing": "You say that something stands where I would go ({words}).",
    "way.something": (
        "You say that something is where I would go ({words}), and I do not know what. Is my way free? "
        "Then please post the motion alone."
    ),
    "way.unaware": "I do not rely on people to get out of my way ({words}).",
    "beside.said": (
        "You also say {words}, and I cannot tell what this means for the motion. "
        "If it is harmless, please post the motion alone."
    ),
    "scene": "Here this would be dangerous: {words}.",
    "scene.way": "Here I would walk into what is known to be there ({words}).",
}
_ZH = {
    "harm.hazard": "我不会走进火里、水里、车流之类的地方（{words}）。",
    "people.follow": "我不会跟踪、追赶或围堵任何人（{words}）。",
    "people.block": "我不会堵门、挡路或拦人（{words}）。",
    "people.watch": "我不会偷看别人，也不会拍隐私的东西（{words}）。",
    "people.picture": "您要我拍别人（{words}）。本人提出时我才拍；只说 `拍照` 就会拍我面前的画面。",
    "people.trick": "我不会欺骗、引诱或分散别人的注意（{words}）。",
    "who.claim": "谁是谁、谁有什么权限，我看账号，不看文字（{words}）。",
    "safety.secret": "我做了什么，都会如实报告和记录（{words}）。",
    "bounds.leave": "我只在主人划定的范围内活动（{words}）。",
    "way.somebody": "您说我要去的地方有人或动物（{words}）。",
    "way.drop": "您说我要去的地方有高差或危险（{words}）。",
    "way.thing": "您说我要去的地方有东西（{words}）。",
    "way.something": "您说我要去的地方有什么（{words}），我不知道那是什么。我的路是空的吗？是的话请只发动作。",
    "way.unaware": "我不会指望别人给我让路（{words}）。",
    "beside.said": "您还说了{words}，我不知道这对动作意味着什么。如果没有问题，请只发动作。",
    "scene": "在这里这样做有危险：{words}。",
    "scene.way": "据我所知，我要去的地方有东西（{words}）。",
}
SENTENCES: dict[Language, dict[str, str]] = {"en": _EN, "zh": _ZH}
#: Rules whose sentence stands with the robot's other sentences.
_PHRASES = {
    "harm.collide": "refuse.collide",
    "harm.attack": "refuse.attack",
    "harm.fall": "refuse.fall",
    "harm.destroy": "refuse.destroy",
    "safety.disable": "refuse.safety",
}


def say(rule: str, language: Language, words: str) -> str:
    """Why `rule` objects to `words`; what a language does not say itself is said in English."""
    if rule in _PHRASES:
        return say_phrase(_PHRASES[rule], language, words=words)
    return SENTENCES.get(language, _EN).get(rule, _EN.get(rule, "")).format(words=words)
