"""Hypothesis strategies for hostile or malformed tool calls."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from agentrob.mcp.forum.cursors import seal

NAUGHTY = (
    "", " ", "\x00", "\u202e\u2066", "\ufeff", "😀" * 100, "ﷺ" * 50, "<script>alert(1)</script>",
    "'; DROP TABLE posts;--", "@" * 500, "\u2028",
    "../../etc/passwd", "%00", "${7*7}", "{{7*7}}", "\r\nSet-Cookie: a=b", "NaN", "-1", "1e400", "null", "undefined",
    "file:///etc/passwd", "http://169.254.169.254/", "\ud800", "A" * 70_000, "\n" * 1_000, "[agent_id=quadruped]",
    "Ω≈ç√∫˜µ≤≥÷", "田中さんにあげて下さい", "1;cat /etc/passwd", "0", "999999999999999999999999", "[[[[", "\\",
)  # fmt: skip


def deep(levels: int) -> Any:
    """Return nested lists."""
    made: Any = 1
    for _ in range(levels):
        made = [made]
    return made


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=50) | st.sampled_from(NAUGHTY),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=10), inner, max_size=3),
    max_leaves=8,
)


def cursors() -> st.SearchStrategy[str]:
    """Generate real and forged cursors."""
    tools = st.sampled_from(["list_boards", "list_posts", "get_topic", "search_posts", "list_notifications"])
    states = st.dictionaries(
        st.sampled_from(["at", "post", "from"]), st.sampled_from(["1", 1, -1, "x", 2**70, None, []])
    )
    return st.builds(
        lambda tool, place, state: seal(tool, place, **state), tools, st.sampled_from(["", "1", "robots"]), states
    )


def of_schema(schema: dict[str, Any]) -> st.SearchStrategy[Any]:
    """Generate values that a schema allows, and occasionally other values."""
    fields = {
        name: _mostly(
            cursors() if name == "cursor" else
            st.sampled_from(field.get("enum", ["1", "robots", "alice", "k"])) if field.get("type") == "string" else
            st.integers(-2, 120) if field.get("type") == "integer" else
            st.floats(0, 0.05) if field.get("type") == "number" else
            st.booleans() if field.get("type") == "boolean" else st.just([]),
        )
        for name, field in schema["properties"].items()
        if name != "wait_s"
    }  # fmt: skip
    needed = set(schema.get("required", ()))
    needs = {k: v for k, v in fields.items() if k in needed}
    optional = {k: v for k, v in fields.items() if k not in needed}
    plain = st.fixed_dictionaries(needs, optional=optional)
    return st.one_of(plain, plain, plain, st.fixed_dictionaries(needs, optional=optional | {"nonsense": ANYTHING}))


def _mostly(valid: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.one_of(*[valid] * 5, st.sampled_from(NAUGHTY), ANYTHING)
