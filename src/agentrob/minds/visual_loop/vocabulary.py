"""The things and colours that a goal may name: a closed vocabulary, so that no text of a post reaches a model with
tools.

English word: English synonyms | Chinese names. People and animals are not in it: a robot neither walks up to them nor
watches them on such a command. Pure.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from agentrob.model import Language

_THINGS = """
ball: football, soccer ball, sphere, basketball, tennis ball | 球, 足球, 皮球, 篮球, 网球, 小球
box: cardboard box, carton, crate, cube, package, parcel | 箱子, 盒子, 纸箱, 纸盒, 方块, 包裹, 箱
column: pillar, pole, post, cylinder | 柱子, 立柱, 杆子, 圆柱, 柱
cone: traffic cone | 锥桶, 路锥, 交通锥, 锥形桶
door: doorway, exit, entrance, gate | 门, 门口, 出口, 入口, 大门
window: | 窗户, 窗子, 窗
wall: | 墙, 墙壁
table: desk, workbench, bench | 桌子, 书桌, 工作台, 办公桌, 桌
chair: armchair, stool, seat | 椅子, 凳子, 板凳
sofa: couch | 沙发
shelf: shelves, bookshelf, bookcase, rack, cupboard, cabinet | 架子, 书架, 柜子, 货架, 书柜
bed: | 床
plant: potted plant, flower, flowerpot, tree | 植物, 盆栽, 花盆, 树, 绿植
lamp: light | 灯, 台灯, 落地灯
poster: picture, painting, sign, whiteboard, notice | 海报, 画, 标志, 标牌, 白板, 牌子
rug: carpet, mat | 地毯, 垫子
bottle: water bottle | 瓶子, 水瓶
cup: mug, glass | 杯子, 水杯
bin: trash can, rubbish bin, garbage can, waste bin, trash bin | 垃圾桶, 垃圾箱
bag: backpack, suitcase, handbag | 包, 背包, 箱包, 手提包, 行李箱
book: | 书
toy: teddy bear | 玩具, 玩偶
laptop: computer | 电脑, 笔记本电脑
screen: monitor, television, tv | 屏幕, 显示器, 电视, 电视机
bucket: | 水桶, 桶
charger: charging station, dock, charging dock | 充电桩, 充电站, 充电器
robot: other robot | 机器人
shoe: shoes | 鞋, 鞋子
bicycle: bike | 自行车
umbrella: | 雨伞, 伞
fridge: refrigerator | 冰箱
fire extinguisher: extinguisher | 灭火器
marker: tag, qr code, apriltag | 标记, 二维码
"""
_COLOURS = """
red: | 红
blue: | 蓝
green: | 绿
yellow: | 黄
orange: | 橙, 橘
black: | 黑
white: | 白
grey: gray | 灰
brown: | 棕, 褐, 咖啡
pink: | 粉, 粉红
purple: violet | 紫
teal: turquoise, cyan | 青
"""

_NAME: dict[Language, str] = {
    "en": r"(?:(?:the|an?)\s+)?(?:(?P<colour>{colour})\s+)?(?P<thing>{thing})",
    "zh": r"(?:(?P<colour>{colour})色?的?)?(?P<thing>{thing})",
}


@cache
def things(language: Language) -> dict[str, str]:
    """Return each name of a thing with its English word."""
    return _names(_THINGS, language)


@cache
def colours(language: Language) -> dict[str, str]:
    """Return each name of a colour with its English word."""
    return _names(_COLOURS, language)


@cache
def one_of(language: Language, what: str) -> str:
    """Return a pattern for any name of a thing or a colour, longest first."""
    names = things(language) if what == "thing" else colours(language)
    return "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))


@cache
def chinese(word: str) -> str:
    """Return the Chinese name of a thing or colour."""
    for table, end in ((things("zh"), ""), (colours("zh"), "色")):
        for name, english in table.items():
            if english == word:
                return name + end
    return word


@dataclass(frozen=True, slots=True)
class NamedThing:
    """A thing by its English word, and its colour where the name says one."""

    thing: str
    colour: str = ""

    def fits(self, other: NamedThing | None) -> bool:
        """Whether this name, which may leave out the colour, fits the other thing."""
        return other is not None and self.thing == other.thing and self.colour in ("", other.colour)


@cache
def thing_named(words: str) -> NamedThing | None:
    """Return what a name such as "the red ball" or 红色的球 means; None where the vocabulary lacks it."""
    for language, pattern in _NAME.items():
        name = pattern.format(colour=one_of(language, "colour"), thing=one_of(language, "thing"))
        if found := re.fullmatch(name, words.strip().casefold()):
            return NamedThing(things(language)[found["thing"]], colours(language).get(found["colour"] or "", ""))
    return None


def _names(table: str, language: Language) -> dict[str, str]:
    found: dict[str, str] = {}
    for line in table.strip().splitlines():
        word, _, names = line.partition(":")
        english, _, other = names.partition("|")
        said = [word, *english.split(",")] if language == "en" else other.split(",")
        found |= {name.strip(): word for name in said if name.strip()}
    return found
