"""Posts of one to three actions with the plan that each means, built from tables that share nothing with the parser.

A language is a `Tables`: actions, what people say around them (politeness, reminders, hedges), what joins two actions
and in which order, purposes and remarks, and counts. `posts` draws from them with a fixed seed.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

Steps = tuple[str, ...]


@dataclass(frozen=True)
class Action:
    """One action: as an order, as an activity ("turning left"; empty where nobody says so), and the step it means."""

    order: str
    activity: str
    steps: Steps


@dataclass(frozen=True)
class Post:
    """A text, the plans that it may mean (none: it has to be asked back), and the constructs it is made of."""

    text: str
    plans: frozenset[Steps]
    constructs: tuple[str, ...]


@dataclass(frozen=True)
class Tables:
    """Phrases of one language.

    `motions` are (order, activity, step) with {metres} or {degrees} for an amount, `actions` the same without, `beyond`
    actions that no robot here can do. `joins` join two orders in the order said; `reversed_joins` put the second first.
    `stop` ends a sentence. `activity_joins` have an activity as {a}; `*_reversed` likewise. `frames` stand around an
    order and change nothing.
    `counts` follow a gesture; `ahead` and `afterwards` repeat the whole post.
    """

    stop: str
    motions: Sequence[tuple[str, str, str]]
    metres: Mapping[str, str]
    degrees: Mapping[str, str]
    actions: Sequence[tuple[str, str, str]]
    beyond: Sequence[str]
    frames: Mapping[str, Sequence[str]]
    joins: Sequence[str]
    reversed_joins: Sequence[str]
    activity_joins: Sequence[str]
    activity_reversed: Sequence[str]
    purposes: Sequence[str]
    remarks: Sequence[str]
    denials: Sequence[str]
    counts: Mapping[str, int]
    counted: frozenset[str]
    ahead: Mapping[str, int]
    afterwards: Mapping[str, int]


def _rows(table: str) -> list[tuple[str, str, str]]:
    """Return the rows `order / activity = step` of a table."""
    found = []
    for row in table.strip().splitlines():
        said, _, step = row.partition("=")
        order, _, activity = said.partition("/")
        found.append((order.strip(), activity.strip(), step.strip()))
    return found


def _amounts(table: str) -> dict[str, str]:
    return dict(part.strip().split("=") for part in table.replace("\n", "|").split("|"))


def _list(table: str) -> list[str]:
    return [part.strip("\n") for part in table.replace("\n", "|").split("|") if part.strip()]


EN = Tables(
    stop=". ",
    motions=_rows(
        """walk forward {metres} / walking forward {metres} = F{}
        walk {metres} / walking {metres} = F{}
        go straight ahead for {metres} / going straight ahead for {metres} = F{}
        move forward {metres} / moving forward {metres} = F{}
        step back {metres} / stepping back {metres} = B{}
        back up {metres} / backing up {metres} = B{}
        move {metres} to the left / moving {metres} to the left = L{}
        strafe right {metres} / strafing right {metres} = R{}
        {metres} forward / = F{}
        forward {metres} / = F{}
        turn left {degrees} / turning left {degrees} = l{}
        rotate right by {degrees} / rotating right by {degrees} = r{}
        turn {degrees} to the right / turning {degrees} to the right = r{}
        spin {degrees} clockwise / spinning {degrees} clockwise = r{}
        {degrees} left / = l{}
        left {degrees} / = l{}"""
    ),
    metres=_amounts(
        "1 m=1|one metre=1|2 metres=2|two meters=2|1.5 m=1.5|half a metre=0.5|one and a half metres=1.5|3 feet=0.9144"
        "|ten feet=3.048|a foot=0.3048|20 cm=0.2|fifty centimetres=0.5|0.4 m=0.4|six inches=0.1524"
        "|a metre and a half=1.5"
    ),
    degrees=_amounts(
        "90 degrees=90|ninety degrees=90|forty five degrees=45|45°=45|30 deg=30|a hundred and eighty degrees=180"
        "|one hundred twenty degrees=120|15 degrees=15"
    ),
    actions=_rows(
        """turn left / turning left = l90
        turn right / turning right = r90
        turn around / turning around = l180
        wave / waving = hello
        wave at me / waving at me = hello
        say hello / saying hello = hello
        take a photo / taking a photo = photo
        send me a picture / sending me a picture = photo
        show me what you see / = photo
        snap a pic / = photo
        sit down / sitting down = sit
        sit / sitting = sit
        stand up / standing up = stand
        clap your hands / clapping = clap
        shake hands / shaking hands = shake
        make a heart / making a heart = heart
        stretch / stretching = stretch
        do a backflip / doing a backflip = backflip"""
    ),
    beyond=_list(
        """sing a song|open the door|tell me the temperature|walk to the kitchen|frobnicate|meander 2 m|patrol the room
        |report the weather|show me your teeth|follow me|fetch the ball|go upstairs|whistle|water the plants
        |turn ten inches to the right|find my keys|count the chairs|lift the box|wait five seconds|walk in a triangle"""
    ),
    frames={
        "politeness": _list(
            """please {}|{} please|could you {}|can you please {}|would you {}|i want you to {}|kindly {}|{} for me
            |{} if you can|you should {}|go ahead and {}|{} thanks|ok {}|would you mind and {}|hey robot, {}
            |i'd like you to {}|{}, if you please|be so kind and {}"""
        ),
        "reminder": _list(
            "don't forget to {}|remember to {}|be sure to {}|make sure to {}|make sure you {}|never forget to {}"
        ),
        "hedge": _list("maybe {}|try to {}|just {}|perhaps you could {}|i think you should {}|well, {}|um {}|so, {}"),
        "order word": _list("now {}|finally {}|next, {}|also {}|first {}|lastly, {}|{} first|{} last|{} next"),
    },
    joins=_list(
        """{a}, {b}|{a}, then {b}|{a}. {b}|{a}. Then {b}|{a} and {b}|{a} and then {b}|{a}; {b}|{a}, and {b}|{a}! {b}
        |{a}, after that {b}|{a} then {b}|{a}, and also {b}|{a}, and finally {b}|{a}, next {b}|{a} — {b}|{a} & {b}
        |{a}, afterwards {b}|first {a}, then {b}|first {a} and then {b}|{a}, followed by this: {b}|{a} before you {b}
        |{a}, and before you {b} do nothing else|after you {a}, {b}|once you {a}, {b}|when you have done that: {b} {a}
        |{a}. When you're done, {b}|{a}, and when that is done {b}|{a}. After this, {b}|{a}... {b}|1. {a} 2. {b}
        |{a} {b}|{a} first, then {b}|{a}, and then afterwards {b}|{a} + {b}|{a}, as well as {b}
        |not only {a}, but also {b}"""
    ),
    reversed_joins=_list(
        """{b} after you {a}|before you {b}, {a}|{b}, but first {a}|{b}, but {a} first|{b}, but before that {a}
        |{b} once you {a}|{b}. Before that, {a}|{b} as soon as you {a}|{b}, and {a} beforehand|{b} last, {a} first
        |{b}, having first done this: {a}"""
    ),
    activity_joins=_list("after {a}, {b}|{b} after {a}|{b} once done {a}|when you're done {a}, {b}"),
    activity_reversed=_list("{b} before {a}|before {a}, {b}"),
    purposes=[
        " so i can see better",
        " so that we can film it",
        " because i am bored",
        " so that nobody trips",
        " to get a better view",
        " in order to see the door",
        " so the kids can see you",
        " for the video",
    ],
    remarks=[
        ", i will watch",
        ", it's fun",
        ", the cat is in another room",
        ", nobody is here",
        ", good robot",
        ", the floor is clean",
        ", what a nice day",
        ", my friends are watching",
        ", well done",
    ],
    denials=[", but don't {}", ", don't {}", " and do not {}", " without {}", ". Never {}", " instead of {}"],
    counts={
        " twice": 2,
        " three times": 3,
        " two times": 2,
        " 2 times": 2,
        " 3 times": 3,
        " four times": 4,
        ", twice": 2,
        " 2x": 2,
        " once": 1,
        " thrice": 3,
    },
    counted=frozenset(["hello", "sit", "stand", "clap", "shake", "heart", "stretch", "backflip", "photo"]),
    ahead={"twice: ": 2, "three times: ": 3, "do this twice: ": 2, "do the following 3 times: ": 3, "2 times: ": 2},
    afterwards={
        ", and do all of that twice": 2,
        ". Do everything two times": 2,
        ". Repeat all of that": 2,
        ". Do all this three times.": 3,
        ", then do it all again": 2,
        ", and repeat everything once": 2,
    },
)

ZH = Tables(
    stop="。",
    motions=_rows(
        """前进{metres} / = F{}
        往前走{metres} / = F{}
        向前走{metres} / = F{}
        朝前走{metres} / = F{}
        走{metres} / = F{}
        后退{metres} / = B{}
        往后退{metres} / = B{}
        向左平移{metres} / = L{}
        往右移动{metres} / = R{}
        左转{degrees} / = l{}
        向右转{degrees} / = r{}
        往左转{degrees} / = l{}
        右转{degrees} / = r{}
        顺时针转{degrees} / = r{}"""
    ),
    metres=_amounts(
        "一米=1|1米=1|两米=2|2米=2|半米=0.5|一米五=1.5|1.5米=1.5|五十厘米=0.5|50厘米=0.5|30公分=0.3|三英尺=0.9144|两米半=2.5"
    ),
    degrees=_amounts("90度=90|九十度=90|四十五度=45|45度=45|30度=30|一百八十度=180|一百二十度=120|180度=180"),
    actions=_rows(
        """左转 / = l90
        右转 / = r90
        掉头 / = l180
        转身 / = l180
        挥手 / = hello
        挥挥手 / = hello
        给他挥挥手 / = hello
        打个招呼 / = hello
        向大家问好 / = hello
        拍照 / = photo
        拍张照片 / = photo
        发一张照片 / = photo
        坐下 / = sit
        站起来 / = stand
        鼓掌 / = clap
        握手 / = shake
        比心 / = heart
        伸个懒腰 / = stretch
        来个后空翻 / = backflip"""
    ),
    beyond=_list(
        "唱首歌|打开门|告诉我温度|去厨房|汇报|巡逻仓库|给他做个后空翻|把那个箱子打开|让我看看你坐下|跟着我|捡球|上楼|找我的钥匙"
        "|数椅子|念诗|浇花|等五秒|走之字形|学狗叫|去红球那里"
    ),
    frames={
        "politeness": _list(
            "请{}|请你{}|帮我{}|麻烦你{}|{}吧|{}，谢谢|我想让你{}|你{}|能不能{}|劳驾{}|{}好吗|可以{}吗|小狗，{}|拜托你{}"
        ),
        "reminder": _list("别忘了{}|不要忘记{}|记得{}|务必{}|一定要{}|记住要{}"),
        "hedge": _list("试试{}|要不{}|大概{}|嗯，{}|那就{}|试着{}|不如{}"),
        "order word": _list("先{}|最后{}|现在{}|首先{}|再{}|马上{}|接下来{}"),
    },
    joins=_list(
        """{a}，{b}|{a}，然后{b}|{a}。{b}|{a}，再{b}|{a}，接着{b}|{a}；{b}|{a}，并{b}|{a}，最后{b}|{a}然后{b}|{a}，随后{b}|{a}！{b}
        |{a}，之后{b}|{a}并且{b}|{a}，还要{b}|先{a}再{b}|先{a}，再{b}|先{a}，然后{b}|{a}之后{b}|{a}以后{b}|{a}后{b}|{a}完{b}
        |{a}之后再{b}|等{a}完再{b}|{a}再{b}|{a}{b}|{a}、{b}|首先{a}，其次{b}|{a}，完了{b}|{a}，做完以后{b}|{a}，紧接着{b}|{a}和{b}
        |不但{a}，还要{b}"""
    ),
    reversed_joins=_list(
        """{b}之前先{a}|{b}前先{a}|{b}，不过要先{a}|{b}，但是先{a}|{b}，在这之前{a}|在{b}之前，{a}|{b}，先{a}|{b}以前{a}|{b}之前{a}
        |最后{b}，先{a}"""
    ),
    activity_joins=(),
    activity_reversed=(),
    purposes=["，为了看清楚", "，好让大家看见", "，这样能看得清楚", "，免得绊倒人", "，因为我很无聊", "让我看清楚点"],
    remarks=[
        "，我看着",
        "，我很无聊",
        "，这样很好",
        "，前面没有人",
        "，地板很干净",
        "，大家都在看",
        "，真乖",
        "，天气真好",
    ],
    denials=["，不要{}", "，别{}", "，但是不用{}", "而不是{}", "，千万别{}"],
    counts={"两次": 2, "三次": 3, "两遍": 2, "2次": 2, "3遍": 3, "，两次": 2, "一次": 1, "两下": 2},
    counted=frozenset(["hello", "sit", "stand", "clap", "shake", "heart", "backflip"]),
    ahead={"两次：": 2, "重复三次：": 3, "以下动作做两遍：": 2},
    afterwards={"，全部做两遍": 2, "，以上重复一遍": 2, "。整套动作做三次": 3, "，再来一遍": 2},
)


def posts(count: int, seed: int = 16) -> Iterator[Post]:
    """Yield this many posts, the same for the same seed."""
    rng = random.Random(seed)
    for _ in range(count):
        yield _Writer(rng, rng.choice((EN, ZH))).post()


class _Writer:
    """Writes one post."""

    def __init__(self, rng: random.Random, tables: Tables) -> None:
        self._rng, self._tables = rng, tables
        self._constructs: list[str] = []
        self._paired = False  # a pair out of order was said last

    def post(self) -> Post:
        rng, tables = self._rng, self._tables
        wanted = rng.choice((2, 2, 3))
        begins = rng.random() < 0.1  # with a pair out of order
        text, plans = self._in_other_order() if begins else self._one()
        if begins and wanted > 1:
            wanted -= 1
        for _ in range(1, wanted):
            text, plans = self._joined(text, plans)
        if rng.random() < 0.06:
            text, plans = self._denied(text, plans)
        if rng.random() < 0.07:
            words, times = rng.choice(sorted(tables.ahead.items()))
            self._constructs.append("repeated ahead")
            text, plans = words + text, frozenset(plan * times for plan in plans)
        elif rng.random() < 0.07:
            words, times = rng.choice(sorted(tables.afterwards.items()))
            self._constructs.append("repeated afterwards")
            text, plans = text + words, frozenset(plan * times for plan in plans)
        return Post(text, plans, tuple(self._constructs))

    def _action(self, activity: bool = False) -> Action:
        """Draw an action; with `activity` one that people also say as an activity."""
        rng, tables = self._rng, self._tables
        rows = [row for row in (*tables.motions, *tables.actions) if row[1] or not activity]
        order, said, step = rng.choice(rows)
        for slot, amounts in (("{metres}", tables.metres), ("{degrees}", tables.degrees)):
            if slot in order:
                words, value = rng.choice(sorted(amounts.items()))
                order, said, step = order.replace(slot, words), said.replace(slot, words), step.format(value)
        return Action(order, said, (step,))

    def _one(self) -> tuple[str, frozenset[Steps]]:
        """Return one action with what is said around it; no plan where it is beyond the robots."""
        rng, tables = self._rng, self._tables
        if rng.random() < 0.08:
            self._constructs.append("beyond")
            return rng.choice(tables.beyond), frozenset()
        action = self._action()
        text, steps = action.order, action.steps
        if steps[0] in tables.counted and rng.random() < 0.2:
            words, times = rng.choice(sorted(tables.counts.items()))
            self._constructs.append("count")
            text, steps = text + words, steps * times
        if rng.random() < 0.4:
            kind = rng.choice(sorted(tables.frames))
            self._constructs.append(kind)
            text = rng.choice(tables.frames[kind]).format(text)
        if rng.random() < 0.08:
            self._constructs.append("purpose")
            text += rng.choice(tables.purposes)
        elif rng.random() < 0.08:
            self._constructs.append("remark")
            text += rng.choice(tables.remarks)
        return text, frozenset([steps])

    def _joined(self, text: str, plans: frozenset[Steps]) -> tuple[str, frozenset[Steps]]:
        """Join a further action."""
        rng, tables = self._rng, self._tables
        if self._paired:  # what follows a pair without a stop may be meant for either of the two
            return self._after_pair(text, plans)
        if rng.random() < 0.2:
            more, theirs = self._in_other_order()
            return f"{text}{tables.stop}{more}", frozenset(a + b for a in plans for b in theirs)
        join = rng.choice(tables.joins)
        if join in ("when you have done that: {b} {a}", "{a}, and before you {b} do nothing else"):
            join = "{a}, {b}"  # says the order in a way that nobody can tell
        more, theirs = self._one()
        # Without a pause between, the same said twice is meant once, and an amount completes what was said before.
        if join in ("{a} {b}", "{a}{b}"):
            join = rng.choice(("{a}, {b}", "{a}. {b}") if tables is EN else ("{a}，{b}", "{a}。{b}"))
        self._constructs.append("join" if len(join) < 14 else "long join")
        return join.format(a=text, b=more), frozenset(a + b for a in plans for b in theirs)

    def _after_pair(self, text: str, plans: frozenset[Steps]) -> tuple[str, frozenset[Steps]]:
        """Add an action in a sentence of its own."""
        self._paired = False
        more, theirs = self._one()
        return f"{text}{self._tables.stop}{more}", frozenset(a + b for a in plans for b in theirs)

    def _in_other_order(self) -> tuple[str, frozenset[Steps]]:
        """Return a sentence of two actions that says which of them comes first."""
        rng, tables = self._rng, self._tables
        kinds = [kind for kind in ("reversed_joins", "activity_joins", "activity_reversed") if getattr(tables, kind)]
        kind = rng.choice(kinds)
        join: str = rng.choice(getattr(tables, kind))
        said, plans = self._one()
        self._constructs.append(kind.replace("_", " "))
        self._paired = True
        first = kind != "activity_reversed"
        other = self._action(activity=kind != "reversed_joins")
        words = other.order if kind == "reversed_joins" else other.activity
        joined = frozenset(other.steps + plan if first else plan + other.steps for plan in plans)
        # "When you're done turning, wave": the turn may be one that was ordered before.
        return join.format(a=words, b=said), joined | plans if "done" in join else joined

    def _denied(self, text: str, plans: frozenset[Steps]) -> tuple[str, frozenset[Steps]]:
        """Add an action that is not to be done."""
        words = self._rng.choice(self._tables.denials)
        action = self._action(activity=words.startswith((" without", " instead")))
        self._constructs.append("denial")
        said = action.activity if words.startswith((" without", " instead")) else action.order
        return text + words.format(said), plans


def merged(steps: Sequence[str]) -> Steps:
    """Two pictures on end are one: nothing has changed between them."""
    return tuple(step for at, step in enumerate(steps) if step != "photo" or tuple(steps[at - 1 : at]) != ("photo",))
