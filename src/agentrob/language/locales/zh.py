"""Chinese: its words and numerals, and the forms of its sentences. English words in Chinese text are understood too."""

from __future__ import annotations

from agentrob.language.joint.chinese import WORDS as JOINT
from agentrob.language.locale import Locale
from agentrob.language.locales import en
from agentrob.language.locales.zh_characters import TWINS
from agentrob.language.locales.zh_idioms import IDIOMS
from agentrob.language.locales.zh_numbers import NUMERALS, number
from agentrob.language.locales.zh_phrases import with_phrases
from agentrob.language.locales.zh_words import MISREAD, TABLE
from agentrob.language.messages.play_zh import PHRASES as PLAY
from agentrob.language.messages.zh import PHRASES
from agentrob.language.operations.sentences_zh import PHRASES as OPERATIONS
from agentrob.language.parser.lexicon import lexicon
from agentrob.language.previews.words import PreviewWords
from agentrob.language.remarks import chinese as remarks
from agentrob.language.remarks.classifier import StatementClassifier
from agentrob.language.schedule.chinese import WORDS as SCHEDULE
from agentrob.language.talk.words_zh import FORMS

LEXICON = lexicon("zh", TABLE, number, numerals=NUMERALS, twins=TWINS, misread=MISREAD, extends=en.LEXICON)
LOCALE = Locale(
    LEXICON,
    PHRASES | PLAY | OPERATIONS,
    script="han",
    together="你们|你们俩|你们两|你们两个|两位|二位|你俩|你们两位|各位",
    stated=remarks.STATED,
    order="""然后|接着|之后|以后|随后|而后|最后|接下来|再|完后|完了|(?<![向往朝背身])后|然後|接著|之後|以後|隨後|最後
        |(?<![向往朝背身])後""",
    waits="等到|等|当|當|如果|要是|一旦|直到|在|只要|的时候|的時候|那会儿|那會兒|那一刻|的瞬间",
    phrases=with_phrases,
    statements=StatementClassifier("zh"),
    looks="看",
    remark=remarks.REMARK,
    aside=remarks.ASIDE,
    purpose=remarks.PURPOSE,
    weighty=remarks.WEIGHTY,
    grave=remarks.GRAVE,
    crucial=remarks.CRUCIAL,
    quotes=remarks.QUOTES,
    after_subject=remarks.AFTER_SUBJECT,
    unsettling=remarks.UNSETTLING,
    noun_after=remarks.NOUN_AFTER,
    put_first="(?:[，。,；;！!]|但|不过)\\s*(?:但是?|不过|可是?)?(?:你|要|请|得){0,2}(?:[走动]|走动|行动|出发|动身|开始)?(?:之?前)?(?:先|首先)(?!生)[^，。,；;]*",
    claims=remarks.CLAIMS,
    introduction=remarks.INTRODUCTION,
    prohibits="(?:但|可|就|也|请|千万|切)*(?:别(?![人字处样墅致])|不要(?![钱紧])|不许|不准|不得|不能|不可以|勿|莫|甭|休)|没.{0,8}[就则]",
    reassures="介意|见怪|客气|担心|紧张|害?怕|害羞|着急|急|慌|笑|吵|生气|嫌|怪|谢|磕|碰(?![^，。]{0,4}(?:线|标记|地毯|地板|草))|撞|摔|绊|跌|刮|蹭|太[远快猛多久]|多[走转迈挪]|弄坏|伤",
    circular="[顺逆]着?时针",
    some_side="[往向朝](?:边上|侧面|侧边|左右|两边|一侧)|^(?:左右|上下)(?=[走挪移跑])",
    clear_path=remarks.CLEAR_PATH,
    warns="(?:不|没有?|无)(?:太|很|够|怎么|大|是很)*(?:安全|稳|平(?!时|常)|牢|结实|通|干|地|路|底|栏|护栏|扶手|围栏|允许|合适|空间)|^不大$",
    meanwhile="同时|(?<![左右前后里外这那上下旁身两周])边[^，,。.！!？?；;、\n边]{1,8}?[，,、]?(?<![左右前后里外这那上下旁身两周])边(?![上缘沿])"
    "|挥着手(?=[往向朝前后左右走转退])",
    pointing="[往向朝到去][那这](?:边|里|儿|头|一边|个方向)|[往向朝][上下](?=[走挪移跑])",
    never_where="|".join(f"{to}{side}" for to in "往向朝冲" for side in ("前", "后", "左", "右", "前面", "后面")),
    talk=FORMS,
    schedule=SCHEDULE,
    previews=PreviewWords(
        leads=r"(?:(?:请|麻烦|你好|你|帮我|能不能|可以)[\s,，、]*)*(?:先|只|仅)?(?:给我)?"
        r"(?:(?:预演|模拟|彩排|排练|演练|预览|试演)|(?<=先)演示|(?<=先给我)演示|(?<=先)给我看看?)(?:一下|一遍|一次)?[\s,，、:：]*",
        ends=r"[\s,，、。；;]*(?:(?:请|但|但是|不过|然后|再|你|麻烦|要)[\s,，、]*)*"
        r"(?:(?:先|只|仅|只是)?(?:给我)?(?:预演|模拟|彩排|排练|演练|预览|试演)|(?:先|只是)(?:给我)?演示|先给我看看?)"
        r"(?:一下|一遍|一次|看看|给我看看?|吧){0,2}",
        hints=r"预演|模拟|彩排|排练|演练|预览|试演|先.{0,4}演示|先给我看",
    ),
    joint=JOINT,
    idioms=IDIOMS,
)
