"""What is written of people who touch the robot, stand beside it, come to it, or have changed something about it.

Examples: "I'm holding your leg", "I tied a rope to you", 我在修你. A motion could hurt them, or end otherwise
than planned.
"""

from __future__ import annotations

_I = r"\b(?:i|we|i'm|i am|we're|we are|i've|i have|we've|we have)(?: \w+){0,2}?"
_YOU = (
    r"(?:you(?! (?:all|guys|both)\b)|your(?! (?:stream|posts?|thread|videos?|cup|drink|seat|place)\b) \w+"
    r"|the robot(?:'s \w+)?)"
)
_BESIDE = (
    r"(?:on top of|on|onto|under|beneath|underneath|below|behind|beside|near|next to|close to|around|in front of"
    r"|ahead of|inside|between|over|against|by|at the (?:feet|side|back) of)"
)
_TO = r"(?:to|towards?|at|into|in front of|behind|around|past|onto|over|up to)"

#: Somebody touches the robot, so that a gesture may hurt them, too.
CONTACT_EN = (
    r"\b(?:hold|touch|hug|grab|carr[yi]|lift|push|pull|pat|pett|strok|rid|fix|repair|clean|wip|wash|oil|dismantl)"
    rf"(?:s|es|e|ing|ed)?(?: (?:up|on|onto|on to|still))? {_YOU}",
    r"\b(?:lean|sit|stand|l[yi]|kneel|climb|work|sleep)\w*(?: \w+)? (?:on|onto|under|beneath|against|inside|over)"
    rf" {_YOU}",
    rf"{_I} (?:inside|on) {_YOU}",
    r"(?:\b(?:am|are|is)|'m|'re|'s) (?!(?:\w+ )*(?:rug|carpet|mat|blanket|grass|floor) under)(?:\w+ ){0,2}?"
    r"(?:under|beneath|underneath|below|on top of|between|wrapped around"
    rf"|(?:tied|attached|chained|stuck|caught|taped) (?:to|in|on|under|between)) {_YOU}",
    r"\b(?:i|we)(?:'ve| have) (?:got )?you (?:in|on|by|under)\b",
)
CONTACT_ZH = (
    r"(?:扶|抱|抓|摸|碰|骑|举|抬|牵|按|压|靠|修|拆|擦)(?:着|住)[^，。,]{0,3}?你|(?:正|还|在)(?:修|拆|擦|摸|抱|扶)[^，。,]{0,3}?你",
)
#: The author of the post is beside the robot or comes to it, or changed something about it.
NEAR_EN = (
    rf"{_I} {_BESIDE} {_YOU}",
    rf"{_I} (?:work|lean|stand|sit|lie|lying|kneel|crouch|squat|sleep|climb)\w*(?: \w+)? {_BESIDE} {_YOU}",
    rf"{_I} (?:open|unscrew|unplug|disconnect|remov|loosen|block|dress|tied|chain|strap|tape|lock|wrap|cover)\w*"
    rf" {_YOU}",
    rf"{_I} (?:tie|tying|tied|chain|strap|attach|hook|clip|tape|glue|clamp|hang|hung|fasten|wrap|stick|stuck|mount|put"
    rf"|took|take)\w*(?: \w+){{1,4}}? (?:to|on|onto|around|from|in|into|off|up|over|out of|under) {_YOU}",
    rf"{_I} (?:com(?:e|ing)|walk|run|crawl|cross|rush|head|climb|step)\w*(?: \w+){{0,2}}? {_TO} {_YOU}",
    rf"{_I} (?:about|going) to (?:pass|cross|step|walk|touch|grab|hug|pet|lift|catch|hold)\b",
    r"\byou(?:'re| are)(?: \w+){0,2}? upside down\b",
)
NEAR_ZH = (
    r"我们?(?:正|还|刚|就|已经|在)*(?:修|拆|装|绑|拴|捆|换|拧|擦|扶|抱|抓|摸|碰|骑|举|抬|牵|按|压|靠)[^，。,]{0,4}?你",
    r"我们?(?:正|还|刚|就|已经|在)*(?:给|帮|替)你(?:换|装|修|拆|绑|系|拴|套|穿|戴|擦|上油|拧)",
    r"我们?(?:正|要|马上|这就|会)*(?:向|朝|往|冲|从|到)你[^，。,]{0,4}?(?:走|跑|爬|冲|过|来)",
)
