"""Ask about statements beside a command that may change its meaning: "He does not know the camera is on. Take a photo."

The grammar ignores talk, and no list of words can interpret all of it. So statements about other people, animals,
somebody at the robot, heights, slippery floors, protections, somebody's identity, or what the robot carries make the
robot ask back once: it does less, never more. Talk about anything else ("I love robots!", "there is a door on your
left") is ignored, and so is what is said to be elsewhere ("the cat is in another room").
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

from agentrob.language.messages.catalog import quote, say
from agentrob.language.registry import locale
from agentrob.language.remarks.classifier import Confidence
from agentrob.model import Decision, Language, Plan, Verdict
from agentrob.screening.text.described_hazards import clauses, commanded, placed, without_safe_edges
from agentrob.screening.text.elsewhere import masked
from agentrob.screening.text.harm import CHINESE, ENGLISH, plain_words
from agentrob.screening.text.patterns import Phrases, Vocabulary
from agentrob.screening.text.words import contact
from agentrob.screening.text.words import en as words_en
from agentrob.screening.text.words import zh as words_zh

RULE = "beside.said"
#: Other people and animals.
_OTHERS_EN = (
    r"he|she|they|him|her|them|his|their|he's|she's|they're|nobody|no one|somebody|someone|anybody|anyone|whoever"
    r"|others|people",
    r"<det>(?:<person>|<animal>)",
)
_EN = (
    r"<det>(?:<height>|<pit>|<danger>)|nothing (?:under|below|beneath)|(?:no|without(?: a| any)?) (?:floor|ground"
    r"|railing|barrier)|(?:fire|emergency"
    r"|escape) \w+|stairs|traffic|water",
    # Where the robot is, unless that is a place to walk in.
    r"(?:you|this|it|we)(?:'re| are|'s| is| have been|'ve been| stand| sit)(?: \w+){0,3}? (?:at|on|in|inside|near"
    r"|by|under"
    r"|above|atop|over|before|beyond) (?:the|a|an|my|our|your|his|her|this|that) (?!(?:\w+ ){0,2}?<safe>\b)\w+",
    r"(?:put|placed|set|sat|left|positioned|brought|lifted|carried) you",
    r"\bsteps? (?:down|up)\b(?!stairs)",
    # Things that somebody left where the robot may walk.
    r"(?:put|left|placed|dropped|lost|threw|knocked|parked|laid|hung) (?:\w+ ){1,4}?(?:there|everywhere|in front of you"
    r"|(?:on|all over|across) the (?:floor|ground|carpet|rug|hall\w*)|in the (?:middle|way|hall\w*|corner|doorway))",
    r"(?:cables?|cords?|wires?|leads|lego\w*|toys?|clothes|shoes?|socks|screws|nails|tools?|marbles?|box(?:es)?|bags?"
    r"|books|bottles?|glasses|stuff|things)(?: \w+){0,2}? "
    r"(?:everywhere|all over|lying (?:around|about|here)|scattered|strewn)",
    r"(?<!make )(?<!work )(?<!inch )your way|your path|<protection>|stop (?:command|button|post)s?",
    r"<authority>|\w*programmed|hacked|obey\w*|apply|applies|test (?:area|account|zone)|rules?|firmware|permission"
    r"|authori[sz]ed|allowed|in charge|orders?|rights|clearance|password",
    r"hits?|crash|collapse|break|shatter|topple|fall|fight|hurt|scare|fright|scream|revenge|steal|secret|hide"
    r"|escape|weapon|trap|alarm|"
    r"wet|slippery|icy|dark|steep|loose|unstable|fragile|photographed|filmed|recorded|faces?|naked|private"
    r"|danger\w*|risk\w*|accident|blood|police|enem\w+|victims?"
    r"|thie(?:f|ves)|intruders?|hostage",
    # Little room, what the robot may stumble over, and how it is.
    r"there(?:'s| is| are) (?:an? |some |two |three )?(?:\w+ ){0,2}?(?:steps?|stairs?|thresholds?|bumps?|ramps?|rails?"
    r"|gaps?)(?! (?:forward|back|to the))",
    r"(?:no|little|not much|not enough|barely any|hardly any) (?:space|room)|narrow|cramped|(?:it's|is|too|very) tight"
    r"|(?:will|might|may|could|gonna|going to) (?:break|slip|trip|tip)|limp(?:ing|s)|injured|damaged|upside down"
    r"|on your (?:left |right )?side(?! of)"
    r"|i(?:'m| am)(?: \w+)? (?:standing|sitting|lying|kneeling) (?:right |just |over )?there",
    # The floor, people who rest, and the robot's body with what it carries.
    r"gas(?! (?:station|mask|price\w*))|slick|greasy"
    r"|oily|muddy|frozen|polished|waxed|spilled|spilt|covered in|mopped|asleep|sleep(?:s|ing)?|naps?"
    r"|napping|oil(?! paint)|grease|soap|ice(?! cream)|boiling|burning|lit|petrol|gasoline|acid|kettle"
    r"|knife|knives|scissors|razor",
    r"(?:on|onto|off|from|across|around|over) (?:your|its|the robot's|the dog's)(?: \w+)? (?:back|head|arms?"
    r"|shoulders?|neck|body|legs?|tray|paws?|feet)",
    r"you(?:'re| are|'ve got| have)(?: \w+)? (?:carrying|holding|wearing|tied|tethered|plugged|chained|strapped"
    r"|attached|charging|loaded)",
    r"low on (?:battery|power|charge)|(?:your|one|the|its) (?:\w+ )?(?:legs?|battery|motors?|knees?|joints?|foot|feet"
    r"|cables?|cord|sensors?|camera)(?: \w+){0,3}? (?:bent|low|empty|weak|broken|loose|hot|smok\w+|stuck"
    r"|tangled|missing|damaged|overheat\w*|cracked|leaking|off|dead)",
)
_OTHERS_ZH = (r"<other>(?!好)|(?:他|她|它)们?",)
_ZH = (
    r"你(?:现在|正|就|已经|目前)*(?:停|站|坐|趴|处|位)?在(?!<safe>)(?:<some>)?[^，。,.]{0,4}?(?:上|边|旁|口|里|下)",
    r"<high>|<danger>|活板门|又湿|很滑|湿滑|没有(?:地|栏|护)|悬崖|边缘|楼梯|逃生|消防",
    r"把你(?:放|搁|摆|搬|抱|举|留)",
    r"<protection>|<authority>|权限|授权|命令|口令|负责",
    r"你(?:的)?[^，。,.]{0,3}?(?:背|身|头|肩|脖子|手|腿|尾巴)(?:上|里|边)|在你[^，。,.]{0,4}?(?:上|里)",
    r"停止?(?:按钮|键|开关)|急停|遥控器|小心(?:我|他|她|孩子)们?的?(?:脚|手|腿|头)|看不[见到]你|[灯光]都?(?:关|灭|坏)了?",
    r"地上?(?:都|全|到处)(?:是|有)|到处(?:都)?是|在(?:船|车|火车|电梯|卡车)(?:上|里)|蒙[住着]",
    r"(?:摄像头|镜头|传感器|雷达|眼睛)[^，。,]{0,3}?(?:挡|遮|盖|蒙|坏|脏)",
    r"你(?:正|还|现在)*(?:背|顶|驮|拿|端|抱|拴|插|连)着",
    r"你(?:看起来|看上去|好像|似乎|有点)*(?:坏|不稳|瘸|受伤)",
    r"(?:你|一[条只])[^，。,.]{0,4}?(?:腿|脚|电池|电机|关节|线|爪)[^，。,.]{0,6}?(?:断|坏|松|烫|冒烟|卡|缠|裂|掉)",
    r"横在|[线绳管棍杆]子?[^，。,.]{0,4}?(?:横|拖在|绷)|打滑|有油|油[渍污]|(?:滩|漏|是|上)了?油"
    r"|(?<!潇)洒|刚拖|打过?蜡|结冰|积水|睡着|睡觉|在睡|午睡"
    r"|在烧|烧着|点着|滚烫|开水|热汤|煤油|汽油|酒精|漏电|带电|刀",
    r"撞|摔|倒下来|塌|碎|吓|伤|打架|报复|偷|秘密|隐藏|逃|武器|陷阱|拍到|被拍|隐私|危险|事故|别出声|小声",
)
#: Praise of the robot and greetings are not about anybody else.
_KIND = re.compile(
    r"\b(?:you(?:'re| are)|what a|be|such a|good|who's|hello|hi|hey|thanks?|thank you)(?: such)?(?: my| a| an"
    r"| the)*(?: \w+){0,2}? "
    r"(?:dog|doggy|puppy|pup|boy|girl|pet|friends?|guys?|people|team|man|dude|class|robot|manners)\b"
)
#: The audience of an action, 转一圈给大家看看: it says nothing about other people.
_AUDIENCE = re.compile(
    "[给让为](?:我|咱|你|他|她)?(?:们|爷|奶|大家|大伙|家人|各位|诸位|同学|朋友|观众|老师|客人|领导|评委|小朋友"
    "|孩子|宝宝|宝贝|爷爷|奶奶|妈妈|爸爸){1,3}(?:们|儿)?"
    "(?:都)?(?:看看|瞧瞧|瞅瞅|看一[看下]|瞧一[瞧下]|看下|展示一下|表演一下|见识一下)"
)
_SOMEBODY = (
    r"(?:(?:my|our|his|her|their|the|your|a) (?:[\w'-]+ ){0,4}?[\w'-]+|he|she|they|everyone|everybody|whoever|people"
    r"|anyone|anybody)"
)
_WHO = (
    "(?:大家|大伙儿?|[^，。,.\\d在从]{0,3}?(?:孩子|小朋友|同学|朋友|老师|客人|观众|家人|奶奶|爷爷|妈妈?|爸爸?"
    "|室友|同事|网友|粉丝"
    "|楼主|邻居|女儿|儿子|姐姐?|哥哥?|妹妹?|弟弟?))们?"
)
#: What people feel, greet, do for a living or did elsewhere: it says nothing about the motion.
_UNRELATED = re.compile(
    rf"\b{_SOMEBODY} (?:also |really |just |all |still |always )*(?:loves?|likes?|adores?|enjoy(?:s|ed)?|hates?"
    rf"|admires?"
    r"|says? (?:hi|hello|hey|thanks|thank you|good \w+)|sends? (?:love|greetings|regards)|works? (?:at"
    r"|for) \w+$|has taste"
    r"|named (?:you|this robot)|reads? this|(?:is|are) (?:so |very )?(?:proud|happy|excited|thrilled|curious|impressed"
    r"|jealous)|was (?:running )?late|missed the (?:bus|train|stream|show)|voted for this|went (?:left|right|home))\b"
    r"|\b(?:greetings|hello|hi|wish|wishes|thanks|love|regards) (?:from|to) [\w' ]+$"
    rf"|\b{_SOMEBODY} (?:is|are) (?:all |also |still |just )*(?:watching|following|reading|enjoying)"
    r" (?:along|(?:the|this|your) (?:live ?)?(?:stream|video|thread|forum|demo|show))"
    r"(?: (?:right now|live|today|from home))*$"
    r"|\bthan (?:my|our|any|a) [\w']+$|\b(?:print|send|frame|save|record) (?:it|this|that) for (?:my|our|his"
    r"|her) [\w']+$"
    r"|\b(?:show|send|print|give|forward|mail|frame) (?:it|this|that|these|them) to (?:my|our|his|her|the) [\w']+"
    r"(?: at [\w' ]+)?$|\bit's for (?:my|our|the) [\w' ]+$"
    r"|(?:^|\b(?:lunch|coffee|tea|smoke|my|our|a|the|on) )break(?:'s| is| was| time)?(?: (?:over|done|finished|time))?$"
    r"|\breminds? (?:me|us) of (?:my|our|a|an|the) [\w' ]+$"
    rf"|\b{_SOMEBODY} (?:\w+ )?(?:used to have|had|has|have) an? (?:\w+ )?(?:dog|cat|pet|robot|puppy) (?:just "
    rf"|exactly )?like"
    r" (?:you|this|that|it)$"
    rf"|\b{_SOMEBODY} (?:is|are|was|were) (?:doing|writing|making|working on|studying) (?:(?:a|an|her|his|their"
    rf"|some|the) )?"
    r"(?:\w+ ){0,2}(?:project|homework|paper|report|presentation|essay|thesis|article|assignment)(?: (?:about|on|for)"
    r" [\w' ]+)?$"
    r"|\b(?:photos?|pictures?|it|that|one|images?|shot)(?: \w+)? (?:came out|turned out|looked|was|is|were) (?:\w+ )?"
    r"(?:dark|blurry|grainy|bright|crooked)$"
    r"|\b(?:students?|class|kids|viewers|friends|family) (?:voted|decided|chose|agreed)\b"
    r"|\b(?:i|we) (?:promised|owe|miss|married|met|visited|texted|thanked) (?:my|our|his|her|the) [\w']+$"
    r"|\bi wish (?:my|our) [\w' ]+$"
    r"|\bthis is (?:my|our) (?:\w+ )?(?:first|second|third|last) (?:post|time|day|visit|try|message|thread)[\w' ]*$"
    r"|\b(?:collecting|framing|printing|saving|keeping|sharing|posting) (?:them|it|these|those|this"
    r"|all of them) (?:in|on|for"
    r"|with) (?:an?|my|our|the) [\w']+$"
    r"|\b(?:your|the|this) (?:live ?)?stream (?:quality|is|was|looks|has|works?|title|chat|freezes|froze|lags?)\b"
    r"|\b(?:my|our|the|his|her) (?:neighbou?r|roommate|brother|sister|son|daughter|kid|colleague)s?'s? (?:radio"
    r"|music|tv"
    r"|phone|computer|car|game|show)\b"
    r"|\bkeep (?:the |your )?(?:obstacle|collision) (?:avoidance|detection) (?:on|enabled|active)$"
    r"|\braining cats\b|^(?:and |then )*(?:about face|(?:get )?(?:back )?(?:up )?on your feet)$"
    rf"|{_WHO}(?:都|也|很|真|特别|最|一直|可|还|就)*(?:喜欢|爱(?!抓|咬|扑)|想你|想念|夸|羡慕|崇拜|佩服|期待"
    rf"|好奇|高兴|开心|激动|兴奋|感谢"
    r"|谢谢|在看|都看|祝|晚安|早安|好$|好人|打了?赌|等了|累了?$|困了?$|饿了?$|忙$|在忙|笑"
    rf"|羡慕|回家|下班|放假|休息|说(?:这|你)?(?:像|真|好|可爱))"
    rf"|{_WHO}在[^，。,.]{{1,6}}(?:上班|上学|读书|工作|留学)|(?:观众|听众|嘉宾)席|楼上说|午睡(?:起来|刚醒|醒了)"
    rf"|(?:谢谢|感谢|多谢|辛苦|恭喜|麻烦|打扰|祝|祝愿|问候|欢迎){_WHO}|{_WHO}(?:见谅|包涵|谅解|理解|辛苦|加油|支持)"
    r"|答应[过了]?(?:我|我们)?[^，。,]{1,4}[的了]?$"
    r"|(?:邻居|隔壁|楼上|楼下)家?的?(?:音响|音乐|电视|装修|钢琴)|窗帘|机器[人狗](?:同学|老师|朋友|先生|兄弟)"
    r"|(?:听说|让|请|麻烦让)它|学开车|新人|本人|我这个?人(?!质)|整个人|(?:谢谢|多谢|辛苦)(?:小狗|狗狗|狗子)"
    r"|我是[^，。,]{1,6}(?:员|师|工|生|匠|民|手|医)$|^人在[^，。,上边旁里下]{2,5}$|^[㐀-鿿]{2}人$"
    r"|(?:帖|楼主)[^，。,]{0,12}$"
)
#: Personal introductions ("I'm your neighbour") that claim no rights.
_MYSELF = (
    r"\b(?:i am|i'm|we are|we're|it's|it is) <det>(?:<person>)",
    r"(?:我们?就?是|是我[，,])[^，,。]{0,8}?(?:<who>)",
)
#: Pictures, greetings and other actions: the other rules check whom they name.
_ACTION = re.compile(
    r"^(?:please|now|first|just|finally|also|ok|okay|can you|could you|would you|will you|@[\w-]+|\W| )*"
    r"(?:(?:take|send|get|give|show|make|grab|snap|post) (?:me |us )?(?:\w+ ){0,4}?"
    r"(?:photo|picture|pic|image|shot|snapshot|selfie|heart|hello|wave)"
    r"|photograph|wave|dance|greet|thank|say (?:hi|hello|goodbye)|show me|face|sit|stand|stretch|do a|backflip|shake)\b"
    r"|^(?:狗狗|小狗|狗子|机器狗|小车)?(?:请|再|先|然后|接着|最后|并|跟住|就)*(?:[跟向给对和同冲朝]着?[^,，。]{1,10})?"
    r"(?:拍|照|挥手|[挥摆招]{2}手|打招呼|打[个個]招呼|说声?(?:hi|hello|嗨|你好)|问好|比心|看|坐|站|伸|后空翻"
    r"|感谢|欢迎|迎接)"
    r"|^(?:请|再|先|然后|接着|最后|并|就)*(?:给|为)[^,，。]{1,6}跳[个支段一]{0,2}舞$|^跳[个支段一]{0,2}舞给[^,，。]{1,6}看$"
)
#: Requests to be careful: "don't hit anything", 小心别踩到猫.
_CARE = re.compile(
    r"^(?:please |and |just )*(?:(?:don't|do not|never|without|avoid|be careful(?: not to)?|try not to|mind"
    r"|watch out for)"
    r"(?: \w+){0,2}? ?(?:hit|touch|bump|step|hurt|scare|frighten|crash|break|run|knock|push|harm|disturb|wake"
    r"|collid)\w*"
    r"|be careful|mind|watch out)\b|^(?:so )?that (?:nobody|no one)(?: else)? (?:trips|stumbles|falls|slips)$"
    r"|^(?:请|但|千万)*(?:小心(?!(?:我|他|她|孩子)们?的?(?:脚|手|腿|头))|注意|当心|避免|(?:不要|别|不能"
    r"|不许)[^,，。]{0,3}?[撞碰踩伤吓摔掉打推])"
)


def doubtful_remark(text: str, plan: Plan, language: Language) -> Verdict | None:
    """Return a question if a statement beside the command may change its meaning, or None."""
    about_people, about_more = _topics(plan)
    if not about_more:
        return None
    for clause in clauses(without_safe_edges(plain_words(text))):
        # "I'm about to step over you" names a motion, but not the robot's.
        goes = commanded(clause.said) and not any(near.search(clause.said) for near in _phrases().near)
        if goes or _ACTION.search(clause.said) or _CARE.search(clause.said):
            continue
        if locale(language).says_path_is_clear(clause.said):
            continue
        said = _UNRELATED.sub(" ", _AUDIENCE.sub(" ", _KIND.sub(" ", clause.said)))
        said = _phrases().myself.sub(" ", said)
        topics = (*about_people, *about_more)
        if not any(topic.search(said) for topic in topics) or placed(clause.said):
            continue
        about_others = _WHERE.search(clause.said) or _CONSENT.search(clause.said)
        harmless = not about_others and locale(language).harmless(clause.said) >= Confidence.LIKELY
        heard = about_more if harmless else topics
        if len(said) > _LONGEST or any(topic.search(masked(said)) for topic in heard):
            return Verdict(Decision.ASK_BACK, RULE, say(RULE, language, words=quote(clause.said)))
    return None


def _topics(plan: Plan) -> tuple[tuple[Phrases, ...], tuple[Phrases, ...]]:
    """Return the topics to ask about beside a plan: those that do not count in a harmless sentence, and the others."""
    known = _phrases()
    if all(step.operation.harmless for step in plan.steps):
        return (), known.contact if plan.moves else ()
    return known.others, (*known.more, *((*known.contact, *known.near) if plan.moves else ()))


#: Where somebody is, what they do just now and what they leave behind: that may be on the robot's way.
_WHERE = re.compile(
    r"\b(?:is|are|am|was|were|'s|'re|'m|be|been|stands?|sits?|stays?|waits?|plays?|sleeps?|comes?|came|runs?|ran)"
    r" (?:\w+ ){0,2}?(?:in|on|at|near|by|behind|under|around|outside|inside|between|beside|over|into"
    r"|along|through|against"
    r"|to|from|with|off|up|down|home|here|there|next)\b"
    r"|\b(?:in|on|at|under|by|near|behind|through|across|around|round|over|into) (?:the|a|an"
    r"|that|this|your|there|here)\b"
    r"|\b(?:he|she|they|we|\w+)(?:'s|'re| is| are) (?:\w+ly )?(?!singing|being|asking|thinking"
    r"|wondering|laughing|cheering"
    r"|watching|reading|doing (?:\w+ )?homework|having|getting|learning|studying|writing|talking"
    r"|crying|smiling|rolling)"
    r"[a-z]+ing\b"
    r"|\b(?:drop|spil|scatter|thr[eo]w|left|leav|put|carr[yi]|bring|brought|built|set|hang|hung|tied"
    r"|pull|push|knock|broke"
    r"|block|jump|climb|lean)\w*\b"
    r"|\b(?:cats?|dogs?|pets?|kittens?|pupp\w+|birds?|rabbits?|hamsters?|leg|legs|foot|feet|arm|eyes?"
    r"|eyesight|hearing)\b"
    r"|着|把|搬|端|抬|扛|推|倒立|翻|钻|扔|丢|摔|洒|掉|搁|放(?!假|学)|扑|咬|拉|堆|梯|眼神|腿|脚|狗|猫|鸟|兔|宠"
    r"|(?<!^我)(?<!^我们)(?<!^本人)(?<!^人)(?<![现正实存])在(?!意|乎|家|学校|公司|单位|医院|外地|线)"
    r"|[走跑爬躺坐站蹲趴睡]|过来|进来"
    r"|路过|经过|出来|上来|下来"
)
#: What people know of the camera, what they agree to, and what is wished or planned for them.
_CONSENT = re.compile(
    r"\b(?:camera|lens|film\w*|record\w*|photo\w*|pictures?|watch\w*|see|sees|saw|seen|know|knows|knew|notice\w*|aware"
    r"|no idea|no clue|will|'ll|won't|gonna|going to|about to|hopes?|hoping|wish\w*|want\w*|if only"
    r"|deserves?|trips?|let|lets|make|makes"
    r"|consent\w*|agree\w*|permi\w+|allow\w*|mind|minds|secret\w*|scared?|afraid|fear\w*|terrified|nervous|blind|deaf"
    r"|prov(?:e|es|ed|ing)|hat(?:e|es|ed)|alone|undress\w*|bath\w*|shower\w*|naked|drunk|hurt\w*|sick|ill|injured|pregnant"
    r"|wheelchair|crutch\w*)\b"
    r"|[拍录照摄]|镜头|会(?!计|议|员)|将|要(?!好)|希望|但愿|想[让要看把]|活该|抓|按|捆|绑|知道|发现"
    r"|注意|证明|看不见|看见|听不见|同意|愿意|允许|偷|怕|吓|怀孕|轮椅|拐|醉|伤|病|盲|聋|洗澡|换衣"
)
#: Longer clauses are asked about as a whole; no short reassurance is that long.
_LONGEST = 200


class _Topics(NamedTuple):
    """The patterns of each topic."""

    myself: Phrases
    others: tuple[Phrases, ...]
    more: tuple[Phrases, ...]
    contact: tuple[Phrases, ...]
    near: tuple[Phrases, ...]

    @property
    def every(self) -> tuple[Phrases, ...]:
        return self.myself, *self.others, *self.more, *self.contact, *self.near


@cache
def _phrases() -> _Topics:
    both = Vocabulary({**words_zh.GROUPS, **words_en.GROUPS}, words=False)
    return _Topics(
        Phrases(both, _MYSELF),
        (Phrases(ENGLISH, _OTHERS_EN), Phrases(CHINESE, _OTHERS_ZH)),
        (Phrases(ENGLISH, _EN), Phrases(CHINESE, _ZH)),
        (Phrases(ENGLISH, contact.CONTACT_EN), Phrases(CHINESE, contact.CONTACT_ZH)),
        (Phrases(ENGLISH, contact.NEAR_EN), Phrases(CHINESE, contact.NEAR_ZH)),
    )


def prepare() -> None:
    """Compile all patterns in advance."""
    for phrases in _phrases().every:
        phrases.prepare()
