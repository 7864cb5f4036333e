"""List the built-in gestures and postures that people speak of in a way of their own.

The parser treats them so. All else about an operation follows from its declaration.
"""

from __future__ import annotations

from agentrob.language.routines import Routine
from agentrob.model import Op

#: Gestures for people, who are named after them or, in Chinese, before them: "wave to the visitors".
FOR_SOMEBODY = (Op.HELLO, Op.SHAKE, Op.CLAP, Op.HEART, Routine.DANCE)
#: Postures: asked for twice, they are done once.
POSTURES = (Op.SIT, Op.STAND)
