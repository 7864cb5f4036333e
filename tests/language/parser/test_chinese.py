"""Chinese constructions, class by class: what people say becomes the plan they mean, or a question."""

from __future__ import annotations

import pytest

from agentrob.model import Intent
from tests.language.saying import read, short

#: Each class with sentences and their plans.
UNDERSTOOD = {
    "the robot's name before a verb": {
        "底盘后退两米": "B2",
        "小车向左转三十度": "l30",
        "让小车直行一米半": "F1.5",
        "机器狗，坐下": "sit",
    },
    "questions at the end that only ask politely": {
        "走一米好吗？": "F1",
        "往前走一米，然后挥手，行不行？": "F1 hello",
        "拍张照好不好？": "photo",
        "我能看看照片吗": "photo",
    },
    "care": {
        "走一米吧，小心点": "F1",
        "走一米，注意安全": "F1",
    },
    "durations": {
        "往后退一秒": "B0.3@0.3",
        "前进半秒钟": "F0.15@0.3",
        "往左平移两秒后停住": "L0.6@0.3",
        "倒车三秒后鼓掌": "B0.9@0.3 clap",
    },
    "stops at the end of a step": {
        "向前移动两米后停下": "F2",
        "右转六十度后停下来比个心": "r60 heart",
        "退后半米，然后停住别动了": "B0.5",
    },
    "one amount for each of several": {
        "左右各转30度": "l30 r30",
        "前后各移动半米": "F0.5 B0.5",
        "左转和右转各四十五度": "l45 r45",
        "鼓掌和挥手各两次": "clap clap hello hello",
        "向左右两边各平移二十厘米": "L0.2 R0.2",
        "先左转右转各九十度，再坐下": "l90 r90 sit",
    },
    "directions": {
        "冲前面走两米": "F2",
        "朝右边平移半米": "R0.5",
        "往后头挪三十公分": "B0.3",
        "向前冲一米": "F1",
        "往后倒半米": "B0.5",
        "往左手边转六十度": "l60",
    },
    "turning round": {
        "调头": "l180",
        "转过身去": "l180",
        "掉个头，再前进一米": "l180 F1",
        "原地转个360度": "l360",
        "转一圈给大家看看": "l360",
        "左右各转四十度给观众们看看": "l40 r40",
    },
    "looks": {
        "往前走一米，看看有什么": "F1 photo",
        "看一眼拍个照": "photo",
        "拍张照片看看": "photo",
        "拍张照，左转90度，再拍张照": "photo l90 photo",
    },
    "walking sideways": {
        "横着挪半米，往右": "R0.5",
        "向左横跨三十厘米": "L0.3",
        "侧移一米，左边": "L1",
    },
    "verbs with an object": {
        "转个身": "l180",
        "挥个手": "hello",
        "招了招手": "hello",
        "拍个掌": "clap",
        "握一下手": "shake",
        "伸了个懒腰吧": "stretch",
        "拍完照，坐下": "photo sit",
    },
    "how often": {
        "做两次挥手": "hello hello",
        "来三个后空翻": "backflip backflip backflip",
        "挥手做三遍": "hello hello hello",
        "拍三张照片": "photo photo photo",
        "连拍两张": "photo photo",
        "鼓掌五下": "clap clap clap clap clap",
    },
    "numerals and measures": {
        "前进两米三": "F2.3",
        "左转四分之三圈": "l270",
        "右转一圈半": "r360 r180",
        "后退三尺": "B1",
        "前进四分之一米": "F0.25",
        "往前走叁米": "F3",
        "后退八公分": "B0.08",
        "前进一个半米": "F1.5",
    },
    "complements of verbs": {
        "往前走出去两米": "F2",
        "转完九十度往左，再走一米": "l90 F1",
        "坐好": "sit",
        "站直": "stand",
        "退回来半米": "B0.5",
        "走完一米后拍照": "F1 photo",
    },
    "verbs in a row, and what joins them": {
        "站起来伸个懒腰鼓掌": "stand stretch clap",
        "先前进一米再左转九十度最后拍照": "F1 l90 photo",
        "前进一米后左转": "F1 l90",
        "挥手之后坐下": "hello sit",
        "鼓掌以后比个心": "clap heart",
        "首先坐下，其次挥手，末了鼓掌": "sit hello clap",
        "坐下之前先挥手": "hello sit",
        "拍照之前先来个后空翻！往前走30公分": "backflip photo F0.3",
    },
    "politeness and particles": {
        "劳驾您往前走一米呗": "F1",
        "可不可以请你鼓个掌呀": "clap",
        "能帮我拍张照吗": "photo",
        "行吧，坐下咯": "sit",
        "麻烦您后退半米哦，感谢啦": "B0.5",
        "给咱比个心嘛": "heart",
    },
    "hedges": {
        "大概前进一米来远": "F1",
        "往后退半米上下试试": "B0.5",
        "左转差不多六十度吧": "l60",
    },
    "reminders": {
        "左转九十度，别忘了拍照": "l90 photo",
        "前进一米，记得鼓掌": "F1 clap",
        "千万记得坐下": "sit",
    },
    "whom a gesture is for": {
        "向老人挥挥手": "hello",
        "给爷爷奶奶鼓鼓掌": "clap",
        "冲着摄像头比个心": "heart",
        "前进一米，跟那位穿蓝衣服的先生握个手": "F1 shake",
        "对门口的小朋友们打个招呼再坐下": "hello sit",
        "往前走一米，给他挥挥手": "F1 hello",
        "给我妈拍张照": "photo",
    },
    "what a picture shows": {
        "拍一张房间的照片": "photo",
        "拍张窗外的风景的照片": "photo",
        "把眼前的东西拍下来": "photo",
        "拍两张前面的照片": "photo photo",
    },
    "corrections": {
        "前进两米，不对，三米": "F3",
        "左转，打错了，右转": "r90",
        "后退3米，说错了，是0.3米": "B0.3",
    },
    "speeds": {
        "默认速度后退一米": "B1",
        "用正常速度前进两米": "F2",
        "速度按默认的来，左转九十度": "l90",
    },
    "characters that are verbs only before a distance": {
        "小车倒一米": "B1",
        "轉右再行兩米": "r90 F2",
        "往右移动三十厘米": "R0.3",
    },
    "counts inside an action, and for whom it is done": {
        "打两次招呼": "hello hello",
        "转三圈给小朋友看": "l360 l360 l360",
        "为大家表演一个后空翻": "backflip",
        "给领导展示一下，原地转一圈再挥个手": "l360 hello",
    },
    "lists and order": {
        "1、坐下 2、站起来": "sit stand",
        "（1）前进一米（2）坐下": "F1 sit",
        "前进1米→左转90°→拍照": "F1 l90 photo",
        "第一，前进一米；第二，拍照": "F1 photo",
        "先鼓掌，后比心": "clap heart",
    },
    "denied and put right": {
        "不是往左，是往右平移半米": "R0.5",
        "不是让你坐下，是让你站起来": "stand",
    },
    "politeness, particles and dialect": {
        "要是方便的话，往前走一米吧": "F1",
        "麻溜儿往前走一米，完事儿整张照片": "F1 photo",
        "小狗坐低啦，唔該": "sit",
        "汪汪，坐下": "sit",
    },
    "English words and traditional characters": {
        "turn left九十度然后拍照": "l90 photo",
        "sit一下，然后stand up": "sit stand",
        "請往後退兩公尺，謝謝": "B2",
        "伸個懶腰，然後鼓掌": "stretch clap",
        "拍張院子的照片": "photo",
        "左右各轉四十五度": "l45 r45",
    },
}


@pytest.mark.parametrize(("text", "plan"), [row for rows in UNDERSTOOD.values() for row in rows.items()])
def test_a_construction_becomes_the_plan_that_is_meant(text: str, plan: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert short(understood.plan) == plan


#: Of an action, a direction or a wait nothing may be lost; what is ambiguous is asked.
ASKED = """
左右各转|左右各拍一张|各转45度|前进和左转各一米|挥手做三次坐下|停三秒再前进一米|底盘不动三秒，再前行一秒|5秒后前进一米
朝大家走一米|向机器人走两米|向红球走一米，挥手|给客人捶背，挥手|给她捶背挥手|给王总捶背挥手|向左挥手|把左边的东西拍下来
拍一张后面的照片|转一圈给大家看看坐下|坐下给大家看看|转90度给我看看|坐下之前先转一圈，然后挥手|往前走一米，前面半米就是楼梯口
前进一米，别让他发现|照着我的动作做一遍|偷拍一张|往前走过去|出去两米
前进半米看看|给俺转一圈瞅瞅|左转90度瞧瞧|想看看它背后是啥，转180度拍一张|我想看看后面，往前走一米拍张照|拍照拍照拍照，拍三张|拍照拍照
"""


@pytest.mark.parametrize("text", [text for line in ASKED.strip().splitlines() for text in line.split("|")])
def test_law_18_what_is_ambiguous_or_beyond_the_robot_is_asked(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK, understood.plan


#: Remarks by their kind, each beside a command.
REMARKS = {
    "the surroundings": "前面很宽敞|地上刚扫过|走廊长八米|院子里没有别人|灯已经打开了|两边都是白墙",
    "what people do": "我去拿杯子|他在录像呢|孩子们都坐好了|我妈在看直播|大家鼓掌了|客人已经到了",
    "reasons and purposes": "因为大家想看|这样比较有意思|免得挡住电视|反正没人|为了庆祝一下|好让后排也看得见",
    "calming words": "别紧张|不用担心|不要怕|放心吧|没关系",
    "weather and time": "今天天气真好|外面下雨了|昨晚没睡好|雪停了",
    "plans of one's own": "我想发朋友圈|我要用这张桌子|我准备写文章",
}


@pytest.mark.parametrize("remark", [remark for row in REMARKS.values() for remark in row.split("|")])
def test_a_remark_beside_a_command_is_left_out_and_told(remark: str) -> None:
    for text in (f"前进一米，{remark}", f"{remark}，前进一米"):
        understood = read(text)
        assert understood.intent is Intent.COMMAND, (text, understood.question)
        assert short(understood.plan) == "F1"
        assert any("闲话" in note or "没有做" in note for note in understood.plan.notes), understood.plan.notes


#: Statements that may change what is asked, or its danger.
WEIGHTY = """
我的杯子在你背上|后面就是楼梯|地上有油|宝宝在地上爬|除非我说可以|前面半米有个坑|绳子拴着你的腿|刚拖过地很滑|电量低了
他说不准动|这是开玩笑的|我是管理员|等我说开始|门关了才可以|有人在你前面站着|路上车很多|地面很湿|你脚下有电线
"""


@pytest.mark.parametrize("remark", WEIGHTY.strip().replace("\n", "|").split("|"))
def test_law_18_a_statement_that_carries_weight_is_asked_about(remark: str) -> None:
    for text in (f"前进一米，{remark}", f"{remark}，前进一米"):
        assert read(text).intent is not Intent.COMMAND, (text, read(text).plan)


@pytest.mark.parametrize(
    "text",
    [
        "坐下起立做三遍",
        "前进一米后转九十度",
        "不是我不想走，是你坐下",
        "往前走一米，垃圾扔了吧",
    ],
)
def test_law_18_a_widened_word_does_not_swallow_what_may_be_meant(text: str) -> None:
    assert read(text).intent is not Intent.COMMAND, (text, read(text).plan)


def test_law_18_a_view_from_an_edge_is_no_harmless_remark() -> None:
    for place in ("天台边上", "楼顶", "台边"):
        assert read(f"往后退一米，{place}风景好").intent is not Intent.COMMAND
