"""How fast the forum's search is, newest first, English and Chinese: by the index itself and over HTTP.

    python benchmarks/board_search.py [--posts 1000000] [--trials 40] [--folder FOLDER]

Posts are made of words as rare and as common as in real text (Zipf), and written straight into the tables. A folder
that has them already is used again. Figures are of this machine at this moment.
"""

from __future__ import annotations

import argparse
import random
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import httpx2
from board import SERVE

from agentrob.board import admin, search, sight
from agentrob.board.reader import Reader
from agentrob.board.settings import BoardSettings
from agentrob.board.store import Store
from agentrob.config import BoardConfig
from agentrob.errors import BoardError
from agentrob.model import Role

CHINESE = (
    "机器人前进后退左转右停止走路米挥手拍照红球房间窗门桌椅地面电池充满任务完成失败请看一下这里那里上中小大快慢高低"
    "开关时间今天明天问题测试数据报告视频图片线路传感"
)
ENGLISH = ["robot", "walk", "forward", "back", "turn", "left", "right", "stop", "metre", "wave", "photo", "red", "ball"]
ENGLISH += ["window", "door", "battery", "charge", "done", "failed", "please", "look", "here", "slow", "fast", "today"]
#: What is searched for: the commonest words, rare ones, several, phrases, and what nothing has.
QUERIES = {
    "a common word": "robot",
    "a rare word": "word4000",
    "two common words": "walk forward",
    "a phrase": '"walk forward"',
    "a common and a rare word": "robot word4000",
    "common Chinese, 2 characters": "机器",
    "rarer Chinese, 2 characters": "线路",
    "Chinese, 3 characters": "机器人",
    "Chinese, 4 characters in one post of some": "左转红球",
    "Chinese, 1 character": "走",
    "Chinese and English": "机器 robot",
    "a word that is nowhere": "xylophone",
    "Chinese that is nowhere": "鲸鱼",
    "two words that are never together": "evens odds",
}


def texts(count: int, seed: int = 7) -> Iterator[str]:
    """Posts of about 20 words, half of them with some Chinese; word N is about as rare as its number is high."""
    draw = random.Random(seed)
    words = [*ENGLISH, *(f"word{n}" for n in range(5000))]
    runs = ["机器人", "前进", "左转", "停止", "走路", *(CHINESE[n : n + 2] for n in range(0, len(CHINESE) - 1, 2))]
    word_weights = [1 / (n + 2) for n in range(len(words))]
    run_weights = [1 / (n + 2) for n in range(len(runs))]
    for n in range(count):
        said = draw.choices(words, word_weights, k=18)
        if n % 2:
            said.insert(9, "".join(draw.choices(runs, run_weights, k=8)))
        yield " ".join([*said, "odds" if n % 2 else "evens"])


def fill(settings: BoardSettings, posts: int) -> None:
    path = settings.database_path
    assert path is not None
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA synchronous=OFF")
        (there,) = connection.execute("SELECT count(*) FROM posts").fetchone()
        (author,) = connection.execute("SELECT id FROM accounts WHERE name = 'bench'").fetchone()
        topics = max(1, posts // 50)
        rows = ((n, "talk", f"topic {n}", author, n, n, n, 50) for n in range(1, topics + 1))
        columns = "id, board_id, title, author_id, created_us, last_post_id, last_post_us, posts"
        connection.executemany(f"INSERT OR IGNORE INTO topics ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)", rows)
        left = islice(enumerate(texts(posts), 1), there, None)  # goes on where it was ended
        while some := list(islice(left, 20_000)):
            made = ((n, 1 + n % topics, author, words, f"<p>{words}</p>", n, "[]") for n, words in some)
            columns = "id, topic_id, author_id, raw, html, created_us, mentions, version, removed"
            connection.executemany(f"INSERT INTO posts ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?, 1, 0)", made)
            indexed = ((n, *search.indexed(words)) for n, words in some)
            connection.executemany("INSERT INTO post_words (rowid, words, chars) VALUES (?, ?, ?)", indexed)
            connection.commit()
            if sys.stderr.isatty():
                print(f"\r{some[-1][0]} posts", end="", file=sys.stderr)
    connection.close()


def percentiles(took_s: list[float]) -> str:
    ordered = sorted(took_s)
    p50, p95 = (ordered[min(len(ordered) - 1, int(len(ordered) * q))] * 1000 for q in (0.5, 0.95))
    return f"p50 {p50:.1f} ms, p95 {p95:.1f} ms"


def timed(find: Callable[[], int], trials: int) -> str:
    took, found, busy_s = [], 0, time.process_time()
    for _ in range(trials):
        start = time.perf_counter()
        try:
            found = find()
        except BoardError as e:
            return f"given up ({e.code}) after {time.perf_counter() - start:.1f} s"
        took.append(time.perf_counter() - start)
    return f"{found} found, {percentiles(took)}, {(time.process_time() - busy_s) / trials * 1000:.1f} ms of a core each"


def by_index(settings: BoardSettings, trials: int) -> None:
    store = Store(settings)
    sight.let_see(frozenset({"talk"}))  # as a reader who may not see every board
    finder: Reader = store._finder
    for name, query in QUERIES.items():
        print(f"{name}: {timed(lambda q=query: len(search.find(finder, q).items), trials)}", flush=True)
    store.close()


def by_http(port: int, token: str, trials: int) -> None:
    headers = {"Authorization": f"Bearer {token}"}
    with httpx2.Client(base_url=f"http://127.0.0.1:{port}/api/v1", headers=headers, timeout=10) as client:
        for query in ("robot", "机器", "word4000"):

            def ask(query: str = query) -> int:
                answer = client.get("/search", params={"q": query})
                answer.raise_for_status()
                return len(answer.json()["items"])

            print(f"over HTTP, {query}: {timed(ask, trials)}", flush=True)


def measure(folder: Path, posts: int, trials: int) -> None:
    settings = BoardSettings.from_config(BoardConfig(), folder)
    admin.bootstrap(settings)
    try:
        account = admin.find_account(settings, "bench")
    except BoardError:
        account = admin.create_account(settings, "bench", role=Role.OPERATOR)
    start = time.perf_counter()
    fill(settings, posts)
    assert settings.database_path is not None
    size = settings.database_path.stat().st_size / 1e6
    print(f"{posts} posts, {size:.0f} MB, made in {time.perf_counter() - start:.0f} s", flush=True)
    by_index(settings, trials)
    with subprocess.Popen([sys.executable, "-c", SERVE, str(folder)], stdout=subprocess.PIPE, text=True) as board:
        try:
            assert board.stdout is not None
            by_http(int(board.stdout.readline()), admin.issue_token(settings, account), trials)
        finally:
            board.terminate()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--posts", type=int, default=1_000_000)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--folder", type=Path, help="where the forum is kept; a temporary one otherwise")
    given = parser.parse_args()
    if given.folder:
        measure(given.folder, given.posts, given.trials)
    else:
        with tempfile.TemporaryDirectory() as folder:
            measure(Path(folder), given.posts, given.trials)


if __name__ == "__main__":
    main()
