"""Texts as large as a post may be, each of which costs a Markdown parser more than it looks like: the known ones of
CommonMark parsers, and those that were found by trying combinations."""

from __future__ import annotations

from hypothesis import strategies as st

SIZE = 65_536
HALF = SIZE // 2


def fill(unit: str, begin: str = "") -> str:
    """As often as it fits."""
    return begin + unit * ((SIZE - len(begin.encode())) // len(unit.encode()))


def _growing(unit: str, then: str) -> str:
    text = "".join(unit * n + then for n in range(1, 400))
    return text[:SIZE]


REPEATED = [
    *(
        "![",
        "[",
        "]",
        "[a](",
        "![a](b)",
        "[a](((((((((((((((((((((((((((((((",
        '[a](b "',
        "[a](b '",
        "[a](b (",
        "[a](<b",
    ),
    *(
        "*a ",
        "*a **a ",
        "a**b",
        "a_ ",
        "_a __a ",
        "*",
        "*_",
        "x*y_",
        "_",
        "a***b** c* ",
        "***a** b ",
        "a** ",
        "~",
        "~~a~~ ",
    ),
    *(
        "` `` ",
        "a`b",
        "`",
        "\\",
        "\\`",
        "<",
        "<a ",
        '<a href="',
        "<?",
        "<!",
        "<!A",
        "<!--",
        "a <!-- ",
        "<![CDATA[",
        "</",
    ),
    *(
        "<http:",
        "<http://a>",
        "<a@a",
        "<div>",
        "<div>\n\n",
        "&",
        "&amp;",
        "&#1",
        "- ",
        "* * *\n",
        ">",
        "> ",
        "> a\n",
        "1. ",
    ),
    *("- a\n", "- a\n\n", "-\n", "- a\n* a\n", "1. a\n", "> - ", "a|b\n-|-\n", "[a]: ", "[\n", '[a]: b "\n', "[a\n\n"),
    *(
        "[a]: u\n",
        "[a]:\n",
        "a\n=\n",
        "a\n",
        "\n",
        " ",
        "\ta\n",
        "a  \n",
        "a",
        "```\n",
        "- ```\n",
        "# a\n",
        "@a1 ",
        "@",
        "a@a",
    ),
    *(
        "@aa--",
        "http://a ",
        "http://",
        "\0",
        "停",
        "\ufdfa",
        "½",
        "😀",
        "[quote]",
        "[quote a",
        "<a>",
        "x <b>",
        "<script>",
    ),
    *(
        "x <b\n\n",
        "[*a](_b `c <d ",
        "![[](",
        "[]()",
        "![]()",
        "[](",
        "](",
        "[![",
        "[`",
        "[<",
        "*[",
        "[*]",
        "![*](",
        "[a][b]",
    ),
    *("![a\n", "![![![![![![![![\n\n", "\r", "a\r\n", "    a\n", "$", "\\\n", "@stop ", "停", "stop, "),
]
TEXTS = {
    **{repr(unit): fill(unit) for unit in REPEATED},
    "nested brackets": "[" * HALF + "]" * HALF,
    "nested links": "[" * (SIZE // 5) + "a" + "](b)" * (SIZE // 5 - 1),
    "nested pictures": "![" * (SIZE // 3) + "]" * (SIZE // 3),
    "parentheses of a link": fill("(", "[a]("),
    "strong in strong": "**a " * (SIZE // 8) + " a**" * (SIZE // 8),
    "growing runs of backticks": _growing("`", "e"),
    "growing quotations": _growing(">", "a\n"),
    "a table of wide rows that are completed": "|" + "a|" * 300 + "\n|" + "-|" * 300 + "\n" + "|\n" * 30_000,
    "a table of the widest rows": "|" + "a|" * 13_000 + "\n|" + "-|" * 13_000 + "\n",
    "a table of many rows": fill("|a|b|\n", "|a|b|\n|-|-|\n"),
    "a deep quotation that goes on lazily": ">" * 100 + "a\n" + "a\n" * 30_000,
    "deep quotations": (">" * 250 + "a\n") * 250,
    "a deep list": "".join(" " * (2 * n) + "- a\n" for n in range(250)),
    "a deep list that goes on lazily": "- " * 100 + "a\n" + "a\n" * 30_000,
    "quotations and lists in each other": ("> - " * 9 + "a\n") * 1_700,
    "link definitions": "".join(f"[{n}]: a\n" for n in range(5_500)),
    "link definitions that are used": "".join(f"[{n}]: a\n" for n in range(2_500)) + "[1] " * 8_000,
    "a long link used again and again": "[a]: " + "u" * 20_000 + "\n\n" + "[a]" * 14_000,
    "a long picture used again and again": "[a]: http://x/" + "u" * 20_000 + "\n\n" + "![a]" * 11_000,
    "a label that is never closed": "[" + "a\n" * 32_000,
    "a title that is never closed": '[a]: b "' + "a\n" * 32_000,
    "an attribute that never ends": "a <a" + " " * 65_000,
    "attributes": "a <a" + " x=y" * 16_000,
    "an address of parentheses": "http://a" + ")" * 65_000,
    "an address of dots": "http://a" + "." * 65_000,
    "marks on one letter": "a" + "\u0301\u0316" * 16_000,
    "different names": "".join(f"@n{n} " for n in range(8_000)),
    "open and closed tags": "<a>" * 9_000 + "</a>" * 9_000,
}
PIECES = st.sampled_from(
    sorted({*REPEATED, "a ", "\n\n", "|", "|-|", "~~~", "---\n", "===\n", '"', "'", "**", "__", "  "})
)
#: A beginning, and something that is repeated after it.
MADE = st.builds(
    lambda begin, unit, many: ("".join(begin) * many + "".join(unit) * 5_000)[:SIZE],
    st.lists(PIECES, max_size=6),
    st.lists(PIECES, min_size=1, max_size=6),
    st.sampled_from([1, 20, 100]),
)
