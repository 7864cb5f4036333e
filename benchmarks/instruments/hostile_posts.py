"""Let several accounts write hostile posts as fast as the forum answers, as a separate process: posts and edits of 32
to 64 KiB that are expensive for a Markdown parser, previews of them, and posts with very many mentions.

    python benchmarks/instruments/hostile_posts.py < words

`words` is a line of JSON: {"url", "topic", "cookie", "accounts": [{"name", "token", "session"}]}. It prints `under way`
when the forum has accepted one of each kind. When its input ends, it prints the number of answers by kind and status:
{"post": {"201": n, …}, "edit": …, "preview": …, "names": …}.
"""

from __future__ import annotations

import asyncio
import json
import sys
from collections import Counter, defaultdict
from itertools import count
from typing import Any

import httpx2

from agentrob.board.access import csrf_token

SIZES = (65_000, 48_000, 32_000)
UNITS = ("![", "[", "![](", "[a](", "*_", "*a **a ", "- a\n* a\n", "a|b\n-|-\n", "`a``b", "<a ", "> - a\n", "*a*, ")
SOME = (
    "[a]: http://x.example/" + "u" * 20_000 + "\n\n" + "![a]" * 5_000,
    "|" + "a|" * 300 + "\n|" + "-|" * 300 + "\n" + "|\n" * 15_000,
    ">" * 100 + "a\n" + "a\n" * 15_000,
)
WAIT_S = 60.0
KINDS = {"post", "edit", "preview", "names"}


def text(number: int) -> str:
    """A different text for each number, in turn."""
    kinds = len(UNITS) + len(SOME)
    if (kind := number % kinds) >= len(UNITS):
        return SOME[kind - len(UNITS)]
    unit, size = UNITS[kind], SIZES[number // kinds % len(SIZES)]
    return unit * (size // len(unit.encode()))


async def attack(words: dict[str, Any], over: asyncio.Event) -> dict[str, dict[str, int]]:
    """Run all accounts concurrently until the input ends."""
    answers: dict[str, Counter[str]] = defaultdict(Counter)
    missing = set(KINDS)

    def answered(what: str, answer: httpx2.Response) -> None:
        answers[what][str(answer.status_code)] += 1
        if answer.is_success and what in missing:
            missing.remove(what)
            if not missing:
                print("under way", flush=True)

    everybody = " ".join(f"@{account['name']}" for account in words["accounts"])

    async def write(account: dict[str, str], first: int) -> None:
        headers = {"Authorization": f"Bearer {account['token']}"}
        session = {"csrf": csrf_token(account["session"])}
        api, replies = f"{words['url']}/api/v1", f"/topics/{words['topic']}/posts"
        async with (
            httpx2.AsyncClient(base_url=api, headers=headers, timeout=WAIT_S, trust_env=False) as program,
            httpx2.AsyncClient(
                base_url=words["url"], cookies={words["cookie"]: account["session"]}, timeout=WAIT_S, trust_env=False
            ) as browser,
        ):
            for number in count(first):
                if number > first or first % 2:  # half of them begin with a preview and mentions
                    looked = await browser.post("/preview", data=session | {"body": text(number + 2)})
                    answered("preview", looked)
                    named = await program.post(replies, json={"body": f"{everybody} " + f"@{account['name']} " * 1_500})
                    answered("names", named)
                made = await program.post(replies, json={"body": text(number)})
                answered("post", made)
                if made.status_code == 201:
                    edit = {"body": text(number + 1)}
                    edited = await program.patch(f"/posts/{made.json()['post']['id']}", json=edit)
                    answered("edit", edited)

    writing = [asyncio.create_task(write(account, 7 * n)) for n, account in enumerate(words["accounts"])]
    await over.wait()
    for task in writing:
        task.cancel()
    await asyncio.gather(*writing, return_exceptions=True)
    return {what: dict(found) for what, found in answers.items()}


async def main() -> None:
    words = json.loads(sys.stdin.readline())
    over = asyncio.Event()
    asyncio.get_running_loop().run_in_executor(None, sys.stdin.read).add_done_callback(lambda _: over.set())
    print(json.dumps(await attack(words, over)))


if __name__ == "__main__":
    asyncio.run(main())
