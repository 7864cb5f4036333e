"""The imports of an agent's process: the fork server of `tests/forked_process.py` imports this module, so that its
children have them. They take 1.5 s of CPU.
"""

from __future__ import annotations

import gc

from agentrob.agent.media import plot
from agentrob.language.parser.grammar import parse
from agentrob.model import Op
from agentrob.screening.screen import prepare

plot.warm_up()
prepare()
for text in ("walk forward 1 m, then turn left", "hello", "向前走 1 米，然后左转"):
    parse(f"@robot {text}", ("robot",), (), frozenset(Op))
# So that a collection in a child searches, and copies, only what the child made.
gc.collect()
gc.freeze()
