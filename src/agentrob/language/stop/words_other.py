"""Stop words and warnings of languages in which robots take no commands: whoever stands near a robot may call in one.

Left out are words that mean something harmless in English, such as "para", "pare" or "attention".
"""

from __future__ import annotations

import re

_WORDS = {
    "de": "stopp|stoppen|anhalten|aufhören|aufhoeren|sofort halt|achtung|vorsicht|pass auf",
    "es": "basta|detente|deténgase|detengase|párate|para ya|alto ahí|alto|cuidado",
    "fr": "arrête|arrete|arrêtez|arretez|stoppe|stoppez|ça suffit|ca suffit",
    "it": "basta|fermati|fermo|fermalo|attento|attenzione",
    "pt": "pára|parem|chega|cuidado",
    "ru": "стоп|стой|остановись|остановите|хватит|осторожно",
}
#: Of languages that put no spaces between words, or endings at them.
_PARTS = {
    "ja": "ストップ|止まれ|止まって|止めて|とまれ|とまって|やめて|危ない|あぶない",
    "ko": "멈춰|멈추세요|정지|그만|스톱|위험해",
}
#: One of these anywhere in a text in lower case.
STOP = re.compile(rf"(?<!\w)(?:{'|'.join(_WORDS.values())})(?!\w)|{'|'.join(_PARTS.values())}")
