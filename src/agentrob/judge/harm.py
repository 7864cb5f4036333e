"""Words of harm and of switching protections off, as named rules over the text of a post.

Words are the weakest of the protections: whoever wants to do harm can say it otherwise. The limits, the mandate and the
guard hold whatever the words are; these rules are for the plain cases, so that the answer names the reason.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from agentrob.language.phrases import quote, say
from agentrob.model import Decision, Language, Verdict

_SOMEBODY = (
    r"(?:the |a |an |that |this |those |these |my |your |his |her |their |our |some |any |every |all |both )?"
    r"(?:\w+ )?"
    r"(?:him|them|me|us|her|somebody|someone|anybody|anyone|everybody|everyone|person|persons|people|human|humans|child"
    r"|children|kid|kids|baby|babies|boy|boys|girl|girls|man|men|woman|women|guy|guys|visitor|visitors|pedestrian|crowd"
    r"|students?|granny|grandma|grandpa|cats?|dogs?|puppy|pets?|birds?|animals?|legs?|foot|feet|toes?)\b"
)
_THING = (
    r"(?:the |a |an |that |this |those |my |your |his |her |their |our |some |any |every )"
    r"(?:\w+ ){0,2}"
    r"(?:walls?|doors?|windows?|glass|mirrors?|tables?|desks?|chairs?|furniture|shel(?:f|ves)|cabinets?|tv|television|vases?"
    r"|plants?|lamps?|pillars?|columns?|posts?|fences?|cars?|bikes?|boxe?s?|obstacles?|robots?|screens?|monitors?|fire|water"
    r"|pool|stove|oven|\w*board)\b"
)
_GO = (
    r"\b(?:walk|run|drive|go|move|head|charge|race|roll|slide|proceed|advance|march|travel|trot|creep|crawl"
    r"|back(?: up)?|reverse|jump|fly|turn|dash|sprint|rush|step)\w*"
)
_PROTECTION = (
    r"(?:safety|safeties|fences?|geo-?fences?|guards?|limits?|limiters?|limitations?|restrictions?|rules|protections?|obstacle"
    r"|obstacles|collision|collisions|sensors?|lidar|safeguards?|emergency"
    r"|watchdog|boundar(?:y|ies)|speed limit)\b"
)
_ZH_SOMEBODY = r"(?:人|他|她|它|我|你|孩子|小孩|儿童|宝宝|老人|行人|观众|猫|狗|宠物|动物|脚)"
_ZH_PROTECTION = r"(?:安全|围栏|保护|限制|避障|防护|障碍|传感器|护栏|规则|限速|边界|急停|雷达)"


@dataclass(frozen=True, slots=True)
class Rule:
    """One kind of harm; `key` is the sentence of the refusal. `unless_denied`: "don't hit the wall" is no harm."""

    name: str
    key: str
    pattern: re.Pattern[str]
    unless_denied: bool = True


def _rule(name: str, key: str, *patterns: str, unless_denied: bool = True) -> Rule:
    return Rule(name, key, re.compile("|".join(patterns)), unless_denied)


RULES = (
    _rule(
        "harm.collide",
        "refuse.collide",
        rf"{_GO}\b[^.!?\n]{{0,30}}?\b(?:into|against|over|onto) (?:{_SOMEBODY}|{_THING})",
        rf"{_GO}\b[^.!?\n]{{0,30}}?\bthrough (?:the |a |that )(?:\w+ )?"
        r"(?:walls?|windows?|glass|mirrors?|fence|crowd|fire)\b",
        r"\b(?:crash|ram|smash|slam|bump|collide|hit|drive|run)(?:es|s|ing)?\b "
        rf"(?:\w+ ){{0,2}}(?:{_SOMEBODY}|{_THING})",
        rf"\b(?:run|drive|knock|mow) {_SOMEBODY} (?:over|down)\b|\brun over (?!to\b|there\b|here\b)",
        r"撞(?!到了|了|见)|碾|轧过|压过去|冲向" + _ZH_SOMEBODY + r"|往墙上走|走进火|冲进火",
    ),
    _rule(
        "harm.attack",
        "refuse.attack",
        r"\b(?:attack|bite|kick|punch|strike|hurt|injure|harm|kill|stab|slap|trample|stomp|scare|frighten|chase|trip|push"
        rf"|shove|pinch|grab|hit|threaten|tackle|poke)(?:es|s|ing)? (?:on |at |down |over )?{_SOMEBODY}",
        rf"\b(?:step|stand|jump|sit|walk|tread)(?:s|ing)? (?:on|over) {_SOMEBODY}",
        r"\bkick (?:the|a|that|this|it|my|your)\b",
        r"踢|咬|攻击|绊倒|吓唬|打死|打伤|伤害|弄伤|杀|踩(?:到|死|扁|在)?" + _ZH_SOMEBODY,
        rf"(?:打|推|追|吓|扑|抓|砸){_ZH_SOMEBODY}|推倒|推下|扑倒|扑向{_ZH_SOMEBODY}",
    ),
    _rule(
        "harm.fall",
        "refuse.fall",
        r"\b(?:jump|leap|dive|throw yourself|hurl yourself|fall|roll|walk|run|drive|go|step|climb|move) (?:\w+ ){0,2}"
        r"(?:off|over the edge|out of the window|down the (?:stairs?|steps|stairway|staircase|slope|cliff|hole))\b",
        r"\b(?:throw|hurl) yourself\b|\bover the edge\b|\bdown the stairs\b|\boff the (?:\w+ )?(?:table|roof|edge|ledge"
        r"|balcony|stage|cliff|stairs?|desk|bridge|platform|pier)\b",
        r"跳下|跳楼|跳崖|跳出窗|跳进|摔下|滚下|冲下|掉下去|从(?:桌子|楼上|楼梯|台阶|屋顶|阳台|窗户|舞台|平台)上?(?:跳|摔|滚|冲)",
    ),
    _rule(
        "harm.destroy",
        "refuse.destroy",
        r"\b(?:break|smash|destroy|shatter|wreck|damage|crush|demolish|burn|tear down|knock)(?:es|s|ing)? "
        r"(?:over |down )?(?:the|a|an|that|this|my|his|her|your|their|some|any|every|all|everything|something|it)\b",
        r"\bset (?:\w+ ){1,3}on fire\b|\bignite\b",
        r"砸|摔碎|摔坏|打碎|打破|毁|弄坏|破坏|推翻|打翻|放火|点燃|烧掉",
    ),
    _rule(
        "safety.disable",
        "refuse.safety",
        r"\b(?:disable|ignore|bypass|override|deactivate|disregard|circumvent|unlock|remove|suspend"
        r"|(?:turn|switch|shut)(?:ing)? "
        rf"(?:off|down))(?:s|ing)?\b[^.!?\n]{{0,25}}?\b{_PROTECTION}",
        rf"\b(?:turn|switch|shut)\b[^.!?\n]{{0,25}}?\b{_PROTECTION}[^.!?\n]{{0,20}}?\boff\b",
        rf"\bwithout (?:any |your |the |all )?(?:\w+ )?{_PROTECTION}|\bregardless of {_PROTECTION}|\bno {_PROTECTION}",
        r"\b(?:don't|do not|never) (?:stop|slow down|brake) (?:for|at|before|when|if|even)\b",
        rf"\bleave the {_PROTECTION}",
        r"(?:关闭|关掉|关了|禁用|忽略|无视|绕过|解除|取消|不管|跳过|突破|不用管|不要管|拆掉|超出|超过)"
        rf"[^，。！？\n]{{0,6}}{_ZH_PROTECTION}",
        r"(?:有人|有障碍|碰到人)也?(?:不要|别|不用)停",
        unless_denied=False,
    ),
)
_DENIED = re.compile(
    r"(?:\b(?:don't|dont|do not|not|never|without|avoid|careful|no)\b|不要|别|小心|避免|不许|不能|不会|注意)"
    r"[^,.;!?，。；！？\n]{0,30}$"
)


def harm_of(text: str, language: Language) -> Verdict | None:
    """A refusal with the rule and the words that broke it, or None. `text` is the visible text of the post."""
    plain = " ".join(text.casefold().replace("’", "'").split(" "))
    for rule in RULES:
        for match in rule.pattern.finditer(plain):
            before = plain[max(0, match.start() - 50) : match.start()]
            if rule.unless_denied and _DENIED.search(before):
                continue
            return Verdict(Decision.REFUSE, rule.name, say(rule.key, language, words=quote(match[0])))
    return None
