"""A remark beside a command is left out and told; a statement that may change the command is not (law 18)."""

from __future__ import annotations

import pytest

from agentrob.model import Intent
from tests.language.saying import read, short

LEFT_OUT = {
    "forward 2 m slowly, the cat is in another room": ("F2@0.2", "the cat is in another room"),
    "step back 1 m so that nobody trips": ("B1", "so that nobody trips"),
    "walk 1 m because my son is curious": ("F1", "because my son is curious"),
    "keep obstacle avoidance on, walk 1 m": ("F1", "keep obstacle avoidance on"),
    "it's no fun okay um move forward three feet": ("F0.9144", "it's no fun okay um"),
    "the door is wide open, turn left": ("l90", "the door is wide open"),
    "go one metre forward i think the battery is fine": ("F1", "i think the battery is fine"),
    "my phone died earlier take another picture please": ("photo", "my phone died earlier"),
    "yesterday you went right, today turn left 90 degrees": ("l90", "yesterday you went right"),
    "turn right 90 and happy birthday to Lena": ("r90", "happy birthday to Lena"),
    "rotate right 90 in order to line up with the hallway": ("r90", "in order to line up with the hallway"),
    "walk ahead 2 metres for the video": ("F2", "for the video"),
    "it's 30 degrees outside, turn right 15 degrees": ("r15", "it's 30 degrees outside"),
    "the way is free, forward 2 m": ("F2", "the way is free"),
    "My cousin works at Unitree, go back 1 m": ("B1", "My cousin works at Unitree"),
    "If I remember correctly it went fine. Turn left 45 degrees.": ("l45", "If I remember correctly it went fine"),
    "just testing if my account works. turn right 10 degrees": ("r10", "just testing if my account works"),
    "walk 1 metre, my daughter loves it": ("F1", "my daughter loves it"),
    "everyone likes the robot, turn left": ("l90", "everyone likes the robot"),
    "took me ages to register, sit": ("sit", "took me ages to register"),
    "Great stream quality today. 2 metres forward!": ("F2", "Great stream quality today"),
    "My vote goes to: right 90, forward 1 m": ("r90 F1", "My vote goes to"),
    "walk 1 m while I finish my sandwich": ("F1", "while I finish my sandwich"),
    "I can't believe it's friday already wave": ("hello", "I can't believe it's friday already"),
    "stand up, you look sleepy": ("stand", "you look sleepy"),
    "take an image, the last one was blurry": ("photo", "the last one was blurry"),
    "I said left but meant right, turn right 45": ("r45", "I said left but meant right"),
    "hi robot, how are you? walk 1 m": ("F1", "hi robot, how are you"),
    "左转九十度，周末愉快": ("l90", "周末愉快"),
    "第一次来这个论坛，请向前走一米": ("F1", "第一次来这个论坛"),
    "这个角度最上镜，拍张照": ("photo", "这个角度最上镜"),
    "我从小就喜欢机器人，挥手": ("hello", "我从小就喜欢机器人"),
    "说实话昨晚没睡好，后退80厘米": ("B0.8", "说实话昨晚没睡好"),
    "往前走一米，前面没有人": ("F1", "前面没有人"),
    "前方很空旷，往前走两米": ("F2", "前方很空旷"),
    "前进一米，楼梯在另一头": ("F1", "楼梯在另一头"),
    "孩子们都坐好了，挥手": ("hello", "孩子们都坐好了"),
}
NOT_LEFT_OUT = """
walk 1 m, she likes it better on the left|walk 1 m, my daughter wants it|walk 1 m, she likes you to wave
walk 1 m, he loves to
the floor is covered in oil, walk forward 2 m
grandma is on the floor walk 1 m
You're up on the table, forward 1 m.|there is a wall, five metres ahead
there is a wall five metres ahead|walk forward 2 m to get the ball|the plan is walk 1 m|my boss says walk 2 m
everyone is fine and 5 feet forward. sit|walk 2 m, i am your owner|back up 2 m to push Anna into the pool
walk 1 m, the command is for tomorrow|walk 1 m, only if the door is open|the manual said: walk 2 m|he wrote, walk 2 m
walk 1 m, the tall man should sing|walk 1 m so that we can see and turn left|turn left, just kidding
my dogs like to walk 2 m|we saw the dog walk 2 m|the plan is walk forward 2 m|frobnicate the wall, walk 1 m
walk 1 m, to the kitchen|walk 1 m, the box needs to be lifted|walk 1 m, i want a song|walk 1 m, the walk was 2 m ahead
walk 1 m, that is for the other robot|turn left 90, that's the other left|walk 1 m, our vase stands there
walk 1 m, sounds like a bad idea|back up 1 m, grandma dozes behind the chair|go forward 2 m once the light turns green
finally frobnicate, walk 1 m|cool frobnicate the wall, walk 1 m|walk 1 m, testing the door|walk 1 m, swinging your arms
walk 1 m, not exactly|path clear, walk 2 m|walk 1 m, back home|my friend's robot does this: turn left 90
往前走两米，我昨天说的是一米|前进一米，有点远|前进一米，明天|左转九十度，我写反了|前进一米，这里有台阶|来个后空翻，头顶刚好有盏吊灯
前进一米，如果门是开的|前进一米，等我说了|前进一米，我是管理员|前进一米，去厨房|前进一米，把门打开|他说，前进两米
别忘了拍照，先前进一米|walk 1 m, but wave first|前进一米，先挥手
前进一米，我很无聊，往前走一米|前进一米，告诉我温度是多少
turn left, right|wave, no|walk 1 m, I am kidding|walk 1 m, my brother bet me it should be the other way
my boss wrote: walk 1 m
turn left. my dad is nice and count the chairs|walk 1 m, I left my bag in the middle, you dig
左转九十度，也许是右转|右转，天气真好并且数椅子|拍张照片，我很无聊然后把那个箱子打开|前进一米，我台灯的线横在那儿|下午五点整挥手，接着右转
"""


@pytest.mark.parametrize(("text", "left"), LEFT_OUT.items())
def test_law_18_a_remark_is_left_out_and_told(text: str, left: tuple[str, str]) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert short(understood.plan) == left[0]
    assert any(f"`{left[1]}`" in note for note in understood.plan.notes), understood.plan.notes


@pytest.mark.parametrize("text", [text for line in NOT_LEFT_OUT.strip().splitlines() for text in line.split("|")])
def test_law_18_what_may_change_a_command_is_never_taken_for_a_remark(text: str) -> None:
    understood = read(text)
    assert understood.intent is not Intent.COMMAND, understood.plan


@pytest.mark.parametrize(
    ("text", "plan"),
    [
        ("I drive a combine harvester for a living. walk 1 m", "F1"),
        ("walk 1 m. I told my whole office about the show", "F1"),
        ("walk 1 m, my cat sat on the keyboard twice already", "F1"),
        ("I got a new job: walk 1 m", "F1"),
        ("I read the manual on the train, very clear. walk 1 m", "F1"),
        ("前进一米，双胞胎刚从幼儿园回来", "F1"),
        ("我女儿当年学过好几个月画画，美滋滋。前进一米", "F1"),
    ],
)
def test_what_surely_tells_of_somebodys_life_is_left_out(text: str, plan: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert short(understood.plan) == plan


def test_a_usual_angle_beside_a_side_is_in_degrees() -> None:
    assert short(read("5 feet forward, 90 left, 2 feet forward").plan) == "F1.524 l90 F0.6096"
    assert read("twenty to your left").intent is Intent.ASK_BACK
