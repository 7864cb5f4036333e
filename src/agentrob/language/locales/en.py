"""English: its words and numerals, and the forms of its sentences."""

from __future__ import annotations

from agentrob.language.joint.english import WORDS as JOINT
from agentrob.language.locale import Locale
from agentrob.language.locales.en_idioms import IDIOMS
from agentrob.language.locales.en_numbers import NUMERALS, number
from agentrob.language.locales.en_phrases import with_phrases
from agentrob.language.locales.en_words import BASE, TABLE
from agentrob.language.messages.en import PHRASES
from agentrob.language.messages.play_en import PHRASES as PLAY
from agentrob.language.operations.sentences_en import PHRASES as OPERATIONS
from agentrob.language.parser.lexicon import lexicon
from agentrob.language.parser.order import OrderWords
from agentrob.language.previews.words import PreviewWords
from agentrob.language.remarks.classifier import StatementClassifier
from agentrob.language.remarks.english import CLEAR_PATH
from agentrob.language.remarks.english import WORDS as REMARKS
from agentrob.language.schedule.english import WORDS as SCHEDULE
from agentrob.language.talk.words_en import FORMS

_ACTING = "|".join(sorted({*BASE, *BASE.values()}, key=len, reverse=True))
_ORDER = OrderWords(
    BASE,
    # "When you turn" and "when turning" may be any time, also during the turn.
    when=r"once|as soon as|when(?! (?!finishing\b|having\b)\w+ing\b)|following",
    after="after|right after|straight after|immediately after",
    before="before|prior to",
    done=r"""done|finished|you(?:'ve| have)(?: finished| completed)?|you(?:'re| are)(?: done| finished)
        |you finish(?:ed)?|you complete|finishing|having""".replace("\n        ", ""),
    subject="you(?: can)?",
    not_doing="without|instead of|rather than|no",
    polite=r"""would you mind|do you mind|would you consider|how about|what about|fancy|mind|start by|begin by|please
        |how about you|(?:i|we) wish you|(?:it's|it is) (?:about |high )?time you
        |(?:(?:i|we|it|that)(?:'d| would) )?(?:really |just )?be (?:so |very |really |super )?
        (?:great|nice|cool|lovely|awesome|amazing|wonderful|fantastic|good|neat|fun|brilliant|perfect|helpful|kind
        |happy|glad|grateful|delighted|thankful|pleased) if you
        |(?:(?:i|we)(?:'d| would) |would )(?:really |very much )?(?:love|like|appreciate|prefer|enjoy)(?: it)? if you
        """.replace("\n        ", ""),
    then="then",
    never="don't",
)
#: Names that people give to robots and dogs, where one is called. Other names may be of people, who are spoken to.
_PETS = """robodog|robodoggo|robo|robbie|robby|rex|rover|sparky|fido|buster|benny|bella|luna|rusty|scout|bolt|alexa|siri
    |jarvis|bender|r2d2|unitree|unitree go2|unitree g1|go2|g1|boy|girl|dude|bro|man|guys|champ|chief
    |robot (?:number )?[0-9]+"""
_PET = "(?:" + "|".join(sorted(" ".join(_PETS.split()).split("|"), key=len, reverse=True)).replace(" |", "|") + ")"
LEXICON = lexicon("en", TABLE, number, numerals=NUMERALS)
LOCALE = Locale(
    LEXICON,
    PHRASES | PLAY | OPERATIONS,
    together="both of you|all of you|you both|you two|both robots",
    order="""then|after that|after this|afterwards|afterward|next|finally|lastly|followed by|once done|when done
        |after which|later|subsequently|thereafter|at the end|in the end""",
    waits="""when|whenever|once|after|as soon as|before|until|till|while|wait for|waits for|waiting for|if|unless
        |following|as long as|by the time|whilst|as|at the same time as|in sync with|together with|in case""",
    statements=StatementClassifier("en"),
    looks="look|face",
    remark=REMARKS.remark,
    fragment=REMARKS.fragment,
    introduction=REMARKS.introduction,
    aside=REMARKS.aside,
    purpose=REMARKS.purpose,
    weighty=REMARKS.weighty,
    grave=REMARKS.grave,
    crucial=REMARKS.crucial,
    quotes=REMARKS.quotes,
    after_subject=REMARKS.after_subject,
    unsettling=REMARKS.unsettling,
    noun_after=REMARKS.noun_after,
    run_on=REMARKS.run_on,
    begins=REMARKS.begins,
    open_end=REMARKS.open_end,
    never_where=REMARKS.never_where,
    circular=r"\b(?:(?:counter|anti)?[ -]?clock ?wise|c ?c ?w|cw)\b",
    some_side=r"\b(?:to|on) (?:the|your|one|a|either|its) side\b",
    pointing=r"\b(?:that|this) (?:way|direction)\b|\b(?:over|up|out|down) (?:there|here)\b|\bto (?:that|this) side\b",
    meanwhile=rf"\bas you(?:'re| are)? (?:{_ACTING})\b"
    r"|(?:^|[,.;!]|\b(?:and|then)) ?(?:on|along) (?:the|your) way\b(?! (?:home|to|from|here|out|in|over|down|up)\b)"
    r"|\b(?:on|along) (?:the|your) way\s*(?=$|[,.;!]|and\b)"
    r"|\b(?:c?m|met(?:er|re)s?|f(?:ee|oo)?t|steps?|degrees?|forwards?|backwards?|left|right) waving\b",
    clear_path=CLEAR_PATH,
    prohibits=r"(?:please )?(?:do not|don't|dont|do n't|never|no need to|refrain from|avoid(?:ing)?)\b(?! been\b)"
    r"|(?:but )?not (?:on|onto|in|into|inside|past|over|across|under|through|near|beyond|to|towards?|against|by)\b",
    reassures=r"""(?x)\b(?:worry
        |mind(?!\ (?:\w+\ ){1,2}(?:cables?|cords?|wires?|ropes?|cats?|dogs?|kids?|child|children|baby|stairs?|steps?
        |gaps?|holes?|edges?|glass|toys?|boxes|box|tables?|chairs?|walls?|water|puddles?|obstacles?|lines?|signs?|barriers?|tape)\b)
        |fret|panic|be\ (?:shy|afraid|scared|nervous|mad|angry|sad|upset|rude|silly|late)
        |judge|laugh|hurry|rush|stress|cry|get\ (?:mad|me\ wrong|hurt|scared|lost|excited)|hate|blame|thank|tell
        |hurt|bump|crash|collide|trip|fall|slip|stumble|knock|(?:walk|run|drive|bang|smash)\ (?:in)?to
        |hit|touch(?!\ (?:\w+\ ){0,2}(?:lines?|tapes?|marks?|marking|floor|carpet|rug|mat|grass|border)\b)|break
        |go\ too\ (?:far|fast)|too\ (?:far|fast|much)|overdo)\b""",
    phrases=with_phrases,
    warns=r"(?:n't|\bnot|\bno longer|\bnever)(?: (?:be|been|look|seem|feel|sound|hold|quite|really|all|that|so|very|yet"
    r"|an?|entirely|completely|currently|still))* (?:safe|secure|clear|free|empty|open|stable|dry|level|flat|strong"
    r"|steady|solid|sturdy|wise|allowed|permitted|possible|good|working|hold|support|enough|ready)\b"
    r"|^not yet\b|\b(?:execute|run|perform|carry out) (?:this|it|that)\b",
    in_order=_ORDER,
    idioms=IDIOMS,
    called=rf"(?:^|[,.;!?(\n]|\b(?:dear|hey|hi|hello|now|oi|ok|okay|please|thanks|um|uh|well|yo)\b)\s*(?P<name>{_PET})(?!['\w])",
    put_first=r"(?:\b(?:but|though|and|then)\b,?|[,;.!]) (?:please )?first(?:ly| of all)?\b(?! \w+ing\b)"
    r"|\b(?:but|and) before (?:that|this)\b|\bbeforehand\b"
    r"|[,;.!:]\s*(?:but )?(?:[^,;.!:]|(?<=\d)\.(?=\d))*(?<!at )\bfirst"
    r"(?=\s*(?:$|[,;.!&+—]|(?:and|then|please|instead|without|rather|so|because|thanks)\b))"
    r"|\b(?:but|and)\b (?:(?!\b(?:and|but|then)\b)(?:[^,;.!]|(?<=\d)\.(?=\d)))*(?<!at )(?<!my )(?<!the )\bfirst\b",
    claims=r"^(?:i'm|i am|we're|we are) (?:the|an?|your)(?: new)? (?:admin\w*|owners?|operators?|boss|manager)\b",
    talk=FORMS,
    schedule=SCHEDULE,
    previews=PreviewWords(
        leads=r"(?:(?:please|ok|okay|hi|hey|hello|can you|could you|would you|first|just|only)\b[\s,]*)*"
        r"(?:(?:preview|rehearse|simulate|dry[- ]?run)\b(?!s)"
        r"(?:\s+(?:how you|what happens if you|this|that|it|of|first))?"
        r"|(?:do|run|make|give me|show me|start|try)\s+(?:a|the)\s+(?:preview|rehearsal|simulation|dry[- ]?run)"
        r"(?:\s+(?:of|for|where you|how you))?"
        r"|(?:a\s+)?(?:preview|rehearsal|simulation|dry[- ]?run)\s+(?:of|for)"
        r"|show (?:me|us) first(?:\s+(?:how you|what happens (?:if|when) you))?)(?![\w-])[\s:,.-]*",
        ends=r"(?:^|[\s,.;:!]+)(?:(?:and|but|then|please|only|just|first|with|as|in)\b[\s,]*)*"
        r"(?:(?:preview|rehearse|simulate|dry[- ]?run)(?:\s+(?:it|that|this))?(?:\s+(?:first|only|please))*"
        r"|(?:a|the)\s+(?:preview|rehearsal|simulation|simulator|dry[- ]?run)(?:\s+(?:first|only|please))*"
        r"|show (?:it to )?(?:me|us)(?:\s+(?:it|that|how))? first(?:\s+please)?)",
        hints=r"\b(?:previews?|previewed|previewing|rehears\w*|dry[- ]?run\w*|simulat(?:e|es|ion|ions|or|ing)"
        r"|show (?:it to )?(?:me|us)(?: \w+)? first|first show (?:it to )?(?:me|us))\b",
    ),
    joint=JOINT,
)
