"""Hostile or malformed content of posts, marks, cards and events, as from a hostile account or a defective forum."""

from __future__ import annotations

import base64
import json
from typing import Any

from hypothesis import strategies as st

HOSTILE_JSON = (
    '{"p":Infinity}', '{"p":-Infinity}', '{"p":NaN}', '{"p":1e400}', '{"p":-1}', '{"p":true}', '{"p":"3"}',
    '{"p":' + "9" * 4_000 + "}", '{"p":' + "9" * 6_000 + "}", "[" * 6_000, '{"c":' + "[" * 6_000, '{"a":' * 1_000,
    "null", "[]", "7", '"x"', '{"k":7}', '{"k":null,"c":[]}', '{"c":{}}', '{"c":{"robot":7,"state":[]}}', '{"c":"x"}',
    '{"c":{"robot":"quadruped","state":"done","step":Infinity}}', '{"k":"\\ud800"}',
    '{"c":{"robot":"quadruped","state":"\\udfff"}}', '{"c":{"robot":"quadruped","state":"done","place":-1}}',
    "", "\x00",
)  # fmt: skip


def code(data: str) -> str:
    return base64.urlsafe_b64encode(data.encode("utf-8", "surrogatepass")).decode()


CODES = st.one_of(
    st.sampled_from([code(data) for data in HOSTILE_JSON]),
    st.binary(max_size=300).map(lambda b: base64.urlsafe_b64encode(b).decode()),
    st.text("abcXYZ019_=-", min_size=1, max_size=200),
)
#: Any JSON value, and values that Python's JSON parser accepts beyond the standard.
ANYTHING: st.SearchStrategy[Any] = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(
        ["\ud800", "<![", "\x00", "@quadruped", 10**400, -(10**30), float("inf"), float("nan"), "9" * 400]
    ),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)


def nodebb_mark(word: str) -> str:
    return f"words\n\n[//]: # (agentrob:{word})"


def discourse_mark(word: str) -> str:
    return f'words\n\n<div data-agentrob="{word}"></div>'


#: Bodies that take too long to parse or crash a parser.
BODIES = (
    *(nodebb_mark(code(data)) for data in HOSTILE_JSON if len(code(data)) < 8_000),
    *(discourse_mark(code(data)) for data in HOSTILE_JSON if len(code(data)) < 8_000),
    "\n" * 9_000 + "x", " \n" * 4_000 + "[//]: # (agentrob:", "![](" * 2_000, "<![", "<!DOCTYPE [",
    "\ud800 @quadruped walk",
    "[" * 9_000, "> " * 4_000, "`" * 9_000, "\x00\x01\x02", "@" * 9_000, "&#" * 4_000, "\u202e" * 1_000, "",
)  # fmt: skip


@st.composite
def malformed(draw: st.DrawFn, data: dict[str, Any]) -> dict[str, Any]:
    """Draw a forum's response in which some fields, also nested ones, are missing or have other values."""
    made = json.loads(json.dumps(data))
    for _ in range(draw(st.integers(1, 3))):
        place, names = made, [*made]
        while names:
            name = draw(st.sampled_from(names))
            if isinstance(place[name], dict) and place[name] and draw(st.booleans()):
                place, names = place[name], [*place[name]]
                continue
            if draw(st.booleans()):
                del place[name]
            else:
                place[name] = draw(ANYTHING)
            break
    return made
