"""Parse a post into a goal: "walk to the red ball and tell me what is beside it", "come home". Pure, no model.

Every clause must be fully known, as a request to reach, face, find or describe something of a closed vocabulary, to go
home, or as a step that the grammar reads. With one unknown clause or word there is no goal, and the robot asks back.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache

from agentrob.language.addressing import part_for
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.parser.grammar import MAX_CHARS, parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.robot_order import ordering_words
from agentrob.language.visible_text import OMITTED
from agentrob.minds.llm.prompt import clean
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.vocabulary import chinese, colours, one_of, things
from agentrob.model import Intent, Language

#: Most parts of one goal.
MAX_TASKS = 8
_ROBOT = "robot"
_CLAUSES = re.compile(
    r"[,;.!?\n，。；！？、]+|\b(?:and then|and after that|after that|afterwards|then|and)\b"
    r"|然后|接着|并且|之后|再|并(?!排)"
)
_POLITE = re.compile(
    r"^(?:(?:please|now|first|next|finally|hey|hi|hello|ok|okay|so|(?:could|can|would|will) you(?: please)?"
    r"|i want you to|i would like you to|go and|come on)\s+)+|\s+(?:please|now|for me|thanks|thank you)$"
    r"|^(?:请你?|麻烦你?|帮我|现在|先|能不能|可以|你好|去(?=看|找))+|(?:吧|好吗|一下|谢谢|呗)+$"
)
#: What stands before a question mark, and what requests; a mere question never moves the robot.
_ASKED = re.compile(r"([^,;.!?\n，。；！？、]*)[?？]")
_REQUESTED = re.compile(r"\b(?:(?:could|can|would|will) you|please)\b|请|麻烦|帮我|能不能|可以|能否|能(?!看)")
_MOVING = (Aim.APPROACH, Aim.FACE, Aim.FIND, Aim.HOME)
_QUESTIONS = {Aim.SEE, Aim.COLOURS}
_TELL = re.compile(r"\b(?:tell|say|report|look for)\b|告诉|说说|报告")
_WHERE = {
    "beside": "beside", "next to": "beside", "near": "beside", "around": "around", "behind": "behind",
    "in front of": "in front of", "on": "on", "on top of": "on", "under": "under", "in": "in", "inside": "in",
    "旁边": "beside", "边上": "beside", "附近": "beside", "周围": "around", "后面": "behind", "后边": "behind",
    "前面": "in front of", "前边": "in front of", "上面": "on", "上": "on", "下面": "under", "里面": "in", "里": "in",
}  # fmt: skip
#: How a goal is described, to the model (always in English) and to people.
_SENTENCES = {
    "en": {
        Aim.APPROACH: "go to the {thing}",
        Aim.FACE: "turn towards the {thing}",
        Aim.FIND: "find the {thing}",
        Aim.LOOK: "say what is {where} the {thing}",
        "describe": "describe the {thing}",
        "around": "look around and say what is there",
        "ahead": "say what the camera shows",
        Aim.SEE: "look for the {thing}",
        Aim.COLOURS: "name the colours that the camera shows",
        Aim.HOME: "go home",
        "joint": ", then ",
    },
    "zh": {
        Aim.APPROACH: "走到{thing}旁边",
        Aim.FACE: "转向{thing}",
        Aim.FIND: "找到{thing}",
        Aim.LOOK: "说出{thing}{where}有什么",
        "describe": "描述{thing}",
        "around": "环顾四周并说出有什么",
        "ahead": "说出看到了什么",
        Aim.SEE: "看看有没有{thing}",
        Aim.COLOURS: "说出看到了哪些颜色",
        Aim.HOME: "回家",
        "joint": "，然后",
    },
}
_ZH_WHERE = {"beside": "旁边", "around": "周围", "behind": "后面", "in front of": "前面", "on": "上面", "under": "下面"}


def goal_of(text: str, addressee: Addressee, language: Language) -> Goal | None:
    """Return the goal of a post's visible text if its steps are decided on the way and every word of it is known."""
    part = clean(part_for(text, addressee.names, addressee.others)).strip(" ,:：，")
    if ordering_words(text, addressee.names, addressee.others):
        return None
    if OMITTED in part or len(part) > MAX_CHARS or re.search(r"[\"“”「」]", part):
        return None
    clauses, found = list(_clauses(part)), list[Subgoal]()
    if not any(pattern.fullmatch(clause) for clause in clauses for pattern, _ in _patterns()):
        return None  # without reading the rest
    if any(_moves(asked[1]) for asked in _ASKED.finditer(part)):
        return None
    for clause in clauses:
        tasks = _tasks(clause, addressee, found)
        if tasks is None or len(found) + len(tasks) > MAX_TASKS:
            return None
        found += tasks
    aims = {task.aim for task in found}
    if aims & _QUESTIONS and not (aims <= _QUESTIONS or _TELL.search(part)):
        return None  # "see the red ball, walk 1 m": perhaps a condition
    return Goal(tuple(found)) if aims - {Aim.STEP} else None


def goal_sentence(goal: Goal, language: Language, steps: Sequence[str] = ()) -> str:
    """Return the goal in our own words; `steps` are the texts of its named steps, in order."""
    words, named = _SENTENCES["zh" if language == "zh" else "en"], iter(steps)
    return words["joint"].join(
        next(named) if task.aim is Aim.STEP else _task_text(task, words, language) for task in goal.tasks
    )


def _moves(asked: str) -> bool:
    """Return whether a question would move the robot if it were a request: "come home?"."""
    last = list(_clauses(asked))[-1:]
    moves = any(aim in _MOVING and pattern.fullmatch(clause) for clause in last for pattern, aim in _patterns())
    return moves and not _REQUESTED.search(asked)


def _task_text(task: Subgoal, words: dict[str, str], language: Language) -> str:
    if task.aim is Aim.LOOK and not task.thing:
        return words["around" if task.where == "around" else "ahead"]
    if language == "zh":
        thing = (chinese(task.colour) if task.colour else "") + chinese(task.thing)
        where = _ZH_WHERE.get(task.where, "旁边")
    else:
        thing, where = f"{task.colour} {task.thing}".strip(), task.where
    key = "describe" if task.aim is Aim.LOOK and not task.where else task.aim
    return words[key].format(thing=thing, where=where)


def _clauses(part: str) -> Iterator[str]:
    for piece in _CLAUSES.split(part.casefold().replace("’", "'")):
        plain = " ".join(piece.split())
        before = ""
        while before != plain:
            before, plain = plain, _POLITE.sub("", plain).strip()
        if plain:
            yield plain


def _tasks(clause: str, addressee: Addressee, before: Sequence[Subgoal]) -> list[Subgoal] | None:
    for pattern, aim in _patterns():
        if match := pattern.fullmatch(clause):
            return _task(match, aim, before)
    can = addressee.capabilities
    others = parse(f"@{_ROBOT} {clause}", (_ROBOT,), (), can.ops, ParseContext(can=can))
    if others.intent is not Intent.COMMAND or others.plan.notes or others.cancels:
        return None
    return [Subgoal(Aim.STEP, step=step) for step in others.plan.steps]


def _task(match: re.Match[str], aim: Aim, before: Sequence[Subgoal]) -> list[Subgoal] | None:
    groups = match.groupdict()
    language = "zh" if any(ord(c) > 0x2FF for c in match[0]) else "en"
    where = _WHERE.get(groups.get("where") or "", "")
    if groups.get("it") or (where not in ("", "around") and not groups.get("thing") and any(t.thing for t in before)):
        last = next((task for task in reversed(before) if task.thing), None)
        return None if last is None else [Subgoal(aim, last.thing, last.colour, where)]
    if aim in (Aim.HOME, Aim.COLOURS):
        return [Subgoal(aim)]
    if groups.get("around"):
        return [Subgoal(aim, where="around")]
    if not groups.get("thing"):
        return [Subgoal(aim, where="around" if where == "around" else "")]
    colour = colours(language).get(groups.get("colour") or "", "")
    return [Subgoal(aim, things(language)[groups["thing"]], colour, where)]


@cache
def _patterns() -> tuple[tuple[re.Pattern[str], Aim], ...]:
    """Return patterns of whole clauses with their aims."""
    pieces = {f"<{name}>": pattern for name, pattern in _PIECES.items()}
    for language in ("en", "zh"):
        pieces[f"<{language}>"] = _PIECES[f"{language}_thing"].format(
            colour=one_of(language, "colour"), thing=one_of(language, "thing")
        )
    found = []
    for aim, pattern in _PATTERNS:
        whole = pattern
        for name, piece in pieces.items():
            whole = whole.replace(name, piece)
        found.append((re.compile(whole), aim))
    return tuple(found)


_PIECES = {
    "go": r"(?:walk|go|move|come|head|trot|drive|run)(?: slowly| carefully)?(?: over| up| back)?",
    "to": r"(?:to|towards?|up to|next to|near|close to)",
    "say": r"(?:tell|say|report|describe|explain|show)(?: to)?(?: me| us)?",
    "where": r"(?P<where>beside|next to|near|around|behind|in front of|on top of|on|under|inside|in)",
    "it": r"(?P<it>it|that)",
    "en_thing": r"(?:(?:the|a|an|that|this|your|my) )?(?:(?P<colour>{colour}) )?(?P<thing>{thing})",
    "zh_thing": r"(?:那个|这个|一个|那只|这只|那扇|那张|那把)?(?:(?P<colour>{colour})(?:色的?|的)?)?(?P<thing>{thing})",
    "colours": r"(?:what|which) colou?rs",
    "home": r"(?:your )?home",
    "start": r"(?:where you (?:started|began)|(?:the |your )?start(?:ing (?:point|position|place))?|the beginning)",
    "zh_go": r"(?:走|去|移动|跑|开|过去)(?:到|去|向|近|往)?",
    "zh_there": r"(?:的?(?:旁边|那里|那边|附近|前面|跟前|面前|边上))?(?:去)?",
    "zh_say": r"(?:(?:告诉|说说|报告|说)(?:给)?(?:我们?)?)?(?:看看)?",
    "zh_where": r"(?P<where>旁边|边上|附近|周围|后面|后边|前面|前边|上面|下面|里面|上|里)",
    "zh_what": r"(?:些)?什么(?:东西)?",
    "zh_it": r"(?P<it>它|那)",
}
_PATTERNS = (
    (Aim.APPROACH, r"<go> <to> <en>"),
    (Aim.APPROACH, r"approach <en>"),
    (Aim.FACE, r"(?:turn|rotate|look|point)(?: yourself)? (?:to|towards?|at|to face) <en>"),
    (Aim.FACE, r"face <en>"),
    (Aim.FIND, r"(?:find|look for|search for|locate|spot) <en>"),
    (Aim.LOOK, r"(?:<say> )?(?:what is|what's|what stands|what lies|what there is) <where> (?:<it>|<en>)"),
    (Aim.LOOK, r"<say> what (?:you see|you can see|can be seen|there is) <where> (?:<it>|<en>)"),
    (Aim.LOOK, r"(?:<say> )?what (?:(?:do|can) you see|you (?:can )?see|is there|there is)(?: there| here)?"),
    (Aim.LOOK, r"(?:<say> )?(?:what is|what's) (?:there|in front of you|ahead of you|before you)"),
    (Aim.LOOK, r"<say> (?:<it>|<en>)"),
    (Aim.LOOK, r"(?:<say> |look |have a look )(?P<around>around|about|round|your surroundings|the room|the scene)"),
    (Aim.LOOK, r"(?P<around>look around)(?: you)?"),
    (Aim.SEE, r"(?:<say> (?:if|whether) you (?:can )?|(?:do|can) you )?see <en>(?: anywhere| there| now)?"),
    (Aim.SEE, r"(?:<say> )?where(?: is|'s) <en>(?: now)?"),
    (Aim.SEE, r"(?:<say> )?where <en> is"),
    (Aim.SEE, r"is there <en>(?: there| here| anywhere| in front of you| ahead(?: of you)?| in sight)?"),
    (Aim.COLOURS, r"(?:<say> )?<colours> (?:(?:do|can) you see|you (?:can )?see|(?:are|is) there|there are)"),
    (Aim.COLOURS, r"(?:<say> )?<colours> (?:do|can) you see (?:here|there|now|ahead|in front of you)"),
    (Aim.HOME, r"(?:come|go|walk|move|head|get|run|trot|return)(?: on)?(?: back)?(?: to)? <home>(?: again)?"),
    (Aim.HOME, r"(?:(?:come|go|walk|move|head|get)(?: back)? to|return to|back to) <start>"),
    (Aim.APPROACH, r"<zh_go><zh><zh_there>"),
    (Aim.APPROACH, r"(?:靠近|接近)<zh>"),
    (Aim.FACE, r"(?:转向|面向|面对|朝向|对准|看向|转身面对|转到|转过去面对)<zh>(?:的?(?:方向|那边))?"),
    (Aim.FIND, r"(?:找到|寻找|找找|找)<zh>"),
    (Aim.LOOK, r"<zh_say>(?:<zh_it>|<zh>)的?<zh_where>(?:有|是)<zh_what>"),
    (Aim.LOOK, r"<zh_say><zh_where>(?:有|是)<zh_what>"),
    (Aim.LOOK, r"<zh_say>你?(?:能)?看(?:到|见)了?<zh_what>"),
    (Aim.LOOK, r"(?:描述|说说)<zh>"),
    (Aim.SEE, r"你?(?:有没有|能不能|能)(?:看到|看见|看得到|看得见|见到)了?<zh>(?:了)?(?:吗|么)?"),
    (Aim.SEE, r"你?(?:看到|看见|看得到|看得见|见到)(?:了|没有|没)?<zh>(?:了)?(?:吗|没有|没|么)"),
    (Aim.SEE, r"<zh>(?:现在)?在(?:哪里|哪儿|哪|什么地方|哪边|什么方向)(?:呢|啊|呀)?"),
    (Aim.SEE, r"(?:这里|那里|前面|面前)?有没有<zh>(?:吗|么)?"),
    (Aim.SEE, r"(?:这里|那里|前面|面前)?有<zh>(?:吗|么)"),
    (Aim.COLOURS, r"<zh_say>你?(?:都)?(?:能)?(?:看到|看见)了?(?:哪些|什么|哪几种|几种)颜色"),
    (Aim.COLOURS, r"(?:你)?(?:这里|前面|面前|眼前)?都?有(?:哪些|什么|哪几种)颜色"),
    (Aim.HOME, r"(?:走|跑)?(?:回家|回到家|回到你(?:的)?家)(?:去|里|里去|来)?"),
    (Aim.HOME, r"(?:走|跑)?回到?(?:你的|你)?(?:起点|原点|出发点|起始点|出发的地方|开始的地方)(?:去)?"),
    (Aim.LOOK, r"(?P<around>看看周围|看看四周|环顾四周|环顾周围|描述周围|看一看四周)"),
)
