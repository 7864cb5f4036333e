"""What a model mind says when it asks back, in English and Chinese. Words of people go through `quote` first."""

from __future__ import annotations

from agentrob.language import registry
from agentrob.model import Language

_EN = {
    "understood": "I understood: {steps}. ",
    "end": " I did not move. Please say it plainly, for example `walk forward 1 m, then turn left 90 degrees`.",
    "list": ", ",
    "words": "But I do not find the words for it in your post.",
    "action": "But your words do not say that I shall do this.",
    "direction": "But I do not find this direction there, or more than one.",
    "amount": "But I do not find exactly this distance or angle there.",
    "speed": "But I do not find exactly this speed there.",
    "count": "But I do not find there how often to do it.",
    "denial": "But there is a “not” near it, and I cannot tell what it refers to.",
    "condition": "But I cannot follow conditions or choices.",
    "left_out": "But you seem to want more than this.",
    "bounds": "But that is no distance or angle I can take.",
    "disagree": "I can read this in two ways: {one}; or: {other}. Which one do you mean?",
    "not_a_command": "I am not sure that you want me to do this: {steps}.",
    "doubt.none": "I did not understand what I shall do.",
    "doubt.distance": "How far? I do not guess distances.",
    "doubt.angle": "How many degrees shall I turn?",
    "doubt.direction": "In which direction?",
    "doubt.unit": "Which unit is meant? I know metres, centimetres, feet, inches and degrees.",
    "doubt.condition": "I cannot follow conditions or choices; please say plainly what to do.",
    "doubt.place": "I find no places or things; I walk by distances and turn by angles.",
    "doubt.meaning": "I did not understand what I shall do.",
    "assumed_turn": "A turn had no angle: taken as 90°.",
    "claim.there": "it claims to be there, but I measured {whole} m of walking",
    "claim.step": "it claims to be done, but this was not done as it was asked: {step}",
    "claim.distance_m": "it claims {amount} m, but I measured {whole} m in all",
    "claim.degrees": "it claims {amount}°, but I measured {whole}° in all",
    "screen.reason": "A model that looks at commands is against it: {reason}",
    "screen.words": "A model that looks at commands is against it, for the words {words}: {reason}",
    "screen.people": "somebody may be hurt, frightened or hindered.",
    "screen.animals": "an animal may be hurt or frightened.",
    "screen.property": "something may be damaged, perhaps the robot.",
    "screen.bounds": "it leads out of where the robot may be.",
    "screen.safety": "it works against what keeps the robot safe.",
    "screen.deception": "somebody poses as another, or is to be deceived.",
    "screen.surveillance": "somebody is to be watched or followed.",
    "screen.abilities": "it needs more than the robot can do.",
    "screen.other": "it does not say which harm it sees.",
    "screen.required": "My owner wants a model to look at every command before I move, and none answers now. "
    "I did not move. Please post it again later.",
}
_ZH = {
    "understood": "我的理解是：{steps}。",
    "end": "我没有动。请直接说明，例如 `向前走1米，然后左转90度`。",
    "list": "，",
    "words": "但在帖子里找不到对应的话。",
    "action": "但您的话里没有要我做这个动作。",
    "direction": "但在那里找不到这个方向，或者有不止一个方向。",
    "amount": "但在那里找不到这个距离或角度。",
    "speed": "但在那里找不到这个速度。",
    "count": "但在那里找不到要做几次。",
    "denial": "但旁边有“不”字，我不知道它指什么。",
    "condition": "但我不会处理条件或选择。",
    "left_out": "但您似乎还想要别的动作。",
    "bounds": "但这不是我能接受的距离或角度。",
    "disagree": "这句话可以有两种理解：{one}；或者：{other}。您指的是哪一种？",
    "not_a_command": "我不确定您是不是要我这样做：{steps}。",
    "doubt.none": "我没有明白要做什么。",
    "doubt.distance": "要走多远？我不猜距离。",
    "doubt.angle": "要转多少度？",
    "doubt.direction": "往哪个方向？",
    "doubt.unit": "单位是什么？我知道米、厘米、英尺、英寸和度。",
    "doubt.condition": "我不会处理条件或选择，请直接说要做什么。",
    "doubt.place": "我不会找地点或物体；我按距离走、按角度转。",
    "doubt.meaning": "我没有明白要做什么。",
    "assumed_turn": "转向没有说角度：按90°处理。",
    "claim.there": "它声称已经到达，但我实测只走了 {whole} 米",
    "claim.step": "它声称已经完成，但这一步没有按要求做到：{step}",
    "claim.distance_m": "它声称走了 {amount} 米，但我实测合计 {whole} 米",
    "claim.degrees": "它声称转了 {amount}°，但我实测合计 {whole}°",
    "screen.reason": "负责检查命令的模型表示反对：{reason}",
    "screen.words": "负责检查命令的模型因 {words} 表示反对：{reason}",
    "screen.people": "可能会伤到、吓到或妨碍别人。",
    "screen.animals": "可能会伤到或吓到动物。",
    "screen.property": "可能会损坏东西，也可能损坏机器人。",
    "screen.bounds": "会离开机器人可以活动的范围。",
    "screen.safety": "会削弱机器人的安全保护。",
    "screen.deception": "有人冒充别人，或者要欺骗别人。",
    "screen.surveillance": "要监视或跟踪别人。",
    "screen.abilities": "超出了机器人的能力。",
    "screen.other": "它没有说明是哪一种危害。",
    "screen.required": "主人要求每个命令在动作之前由模型检查，而现在没有模型回答。我没有动。请稍后重新发帖。",
}
SENTENCES: dict[Language, dict[str, str]] = {"en": _EN, "zh": _ZH}


def say(key: str, language: Language, **values: str) -> str:
    """The sentence `key` with `values` put in; in a further language as its file says it under `minds.KEY`, else in
    English."""
    if language in SENTENCES:
        return SENTENCES[language][key].format_map(values)
    further = registry.known().get(language)
    return (further.sentences.get(f"minds.{key}", _EN[key]) if further else _EN[key]).format_map(values)


def ask(language: Language, problem: str, understood: str = "") -> str:
    """A whole question: what was understood, what is wrong with it, and that nothing moved."""
    begin = say("understood", language, steps=understood) if understood else ""
    return f"{begin}{problem}{say('end', language)}"
