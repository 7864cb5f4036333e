"""The encoder process answers and may be killed; the real model works without a network."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from agentrob.board.server import create_app
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import ConfigError
from agentrob.semantic import encoder as meaning
from agentrob.semantic.encoder import MIN_SIMILARITY, SIZE, Encoder, EncoderError, cosine_similarity

#: A fake model: every component of a vector is the text's length; one text ends the process, one makes it hang.
DOUBLE = """
import json, sys, time
for line in sys.stdin.buffer:
    for text in json.loads(line):
        if text == "die": sys.exit(1)
        if text == "wait": time.sleep(1000)
        sys.stdout.buffer.write(bytes([len(text)]) * 512)
    sys.stdout.buffer.flush()
"""
COMMAND = (sys.executable, "-c", DOUBLE)


def test_any_number_of_texts_is_encoded_in_order() -> None:
    encoder = Encoder(COMMAND)
    assert encoder.encode([]) == []
    texts = ["x" * (n % 100) + "\n狗 \ud800" for n in range(500)]
    assert encoder.encode(texts) == [bytes([len(text)]) * SIZE for text in texts]
    encoder.close()


def test_a_dead_process_is_reported_and_restarted() -> None:
    encoder = Encoder(COMMAND)
    with pytest.raises(EncoderError, match="ended"):
        encoder.encode(["one", "die"])
    assert encoder.encode(["one"]) == [bytes([3]) * SIZE]
    assert encoder._process is not None
    os.kill(encoder._process.pid, signal.SIGKILL)
    encoder._process.wait()
    assert encoder.encode(["four"]) == [bytes([4]) * SIZE]
    encoder.close()


def test_a_process_that_does_not_answer_times_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meaning, "TIMEOUT_S", 0.1)
    encoder = Encoder(COMMAND)
    with pytest.raises(EncoderError, match="timeout after"):
        encoder.encode(["wait"])
    assert encoder._process is None
    encoder.close()


def test_close_ends_the_process_without_waiting_for_calls() -> None:
    encoder, said = Encoder(COMMAND), list[str]()
    assert encoder.encode(["x"])
    process = encoder._process
    assert process is not None

    def ask() -> None:
        try:
            encoder.encode(["wait"])
        except EncoderError as e:
            said.append(str(e))

    asking = threading.Thread(target=ask)
    asking.start()
    encoder.close()
    asking.join(60)
    assert said
    assert process.poll() is not None
    with pytest.raises(EncoderError, match="closed"):
        encoder.encode(["x"])


def test_a_process_started_during_close_is_ended_too(monkeypatch: pytest.MonkeyPatch) -> None:
    shut, started = threading.Event(), list[subprocess.Popen[bytes]]()

    class Watched(Encoder):
        def __setattr__(self, name: str, value: Any) -> None:
            super().__setattr__(name, value)
            if (name, value) == ("_closed", True):
                shut.set()

    encoder = Watched(COMMAND)
    closing = threading.Thread(target=encoder.close)

    class Late(subprocess.Popen[bytes]):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            closing.start()
            assert shut.wait(60)
            super().__init__(*args, **kwargs)
            started.append(self)

    monkeypatch.setattr(subprocess, "Popen", Late)
    with pytest.raises(EncoderError, match="closed"):
        encoder.encode(["wait"])
    closing.join(60)
    assert not closing.is_alive()
    assert [process.poll() is not None for process in started] == [True]


def test_similarity_is_that_of_directions() -> None:
    one, other = bytes([10] * SIZE), bytes([120] * SIZE)
    assert cosine_similarity(one, other) == pytest.approx(1.0)
    assert cosine_similarity(one, bytes([246] * SIZE)) == pytest.approx(-1.0)
    assert cosine_similarity(one, bytes(SIZE)) == 0.0


def test_a_forum_configured_without_the_extra_does_not_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meaning, "_PACKAGE", "no_such_package")
    settings = BoardSettings.from_config(BoardConfig(semantic=True), tmp_path)
    with pytest.raises(ConfigError, match=r"agentrob\[semantic\]"):
        create_app(settings)


@pytest.mark.slow
def test_the_real_model_handles_english_and_chinese_offline() -> None:
    encoder = Encoder()
    said = {
        "dog": "The robot was followed by a puppy on its walk.",
        "battery": "It stopped half way because the battery was nearly empty.",
        "window": "机器人看到窗户是开着的。",
        "stairs": "它不会爬楼梯。",
    }
    asked = {
        "dog": ("a small dog came along", "一只小狗跟着机器人"),
        "battery": ("it ran out of power", "电池用完了"),
        "window": ("somebody left the window open", "窗户没有关"),
        "stairs": ("can it climb stairs?", "上楼梯"),
    }
    kept = dict(zip(said, encoder.encode(list(said.values())), strict=True))
    for thing, queries in asked.items():
        for query, vector in zip(queries, encoder.encode(queries), strict=True):
            likeness = {other: cosine_similarity(vector, kept[other]) for other in kept}
            assert max(likeness, key=likeness.__getitem__) == thing, (query, likeness)
            assert likeness[thing] >= MIN_SIMILARITY, (query, likeness)
    assert encoder.encode(["", " \n"]) == [bytes(SIZE)] * 2
    hostile = ["\0", "\ud800", "𝕏" * 3000, "\u202e", "a" * 70_000]
    assert all(len(v) == SIZE for v in encoder.encode(hostile))
    encoder.close()
