"""A mind that hangs holds up nobody but whoever asked it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator, Sequence

import pytest

from agentrob.errors import MindError
from agentrob.minds import isolated
from agentrob.minds.isolated import MOST_HUNG, IsolatedMind
from agentrob.minds.protocol import Addressee, Mind
from agentrob.minds.rules import RulesMind
from agentrob.model import Intent, Plan, Understanding
from agentrob.wiring.app import capabilities_of

LIMIT_S = 30.0


class HangingMind:
    """Reads like the rules, but blocks its thread for good on "hang", and its loop until cancelled on "wait"."""

    name = "hanging"
    made = 0

    def __init__(self, release: threading.Event) -> None:
        type(self).made += 1
        self._release = release
        self.asked = asyncio.Event()

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        if "hang" in text:
            self._release.wait()
        if "wait" in text:
            await asyncio.Event().wait()
        if "fail" in text:
            raise MindError("it cannot say")
        return await RulesMind().understand(text, addressee, history)


@pytest.fixture
def make(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], Mind]]:
    release = threading.Event()
    monkeypatch.setattr(isolated, "ANSWER_S", 0.2)
    HangingMind.made = 0
    yield lambda: HangingMind(release)
    release.set()


@pytest.fixture
def addressee() -> Addressee:
    return Addressee(("rex",), (), capabilities_of("fake"))


async def given_up(mind: IsolatedMind, text: str, addressee: Addressee) -> None:
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(1.0):
            await mind.read(text, addressee)


async def test_it_answers_as_the_mind_itself_does(make: Callable[[], Mind], addressee: Addressee) -> None:
    mind = IsolatedMind(make)
    assert mind.name == "hanging"
    reading = await mind.read("@rex turn left", addressee)
    assert reading.understanding == await RulesMind().understand("@rex turn left", addressee)
    assert (await mind.understand("@rex turn left", addressee)).intent is Intent.COMMAND
    with pytest.raises(MindError, match="it cannot say"):
        await mind.read("@rex fail", addressee)
    await mind.close()


async def test_a_call_that_hangs_is_given_up_and_the_next_one_gets_a_new_mind(
    make: Callable[[], Mind], addressee: Addressee
) -> None:
    mind = IsolatedMind(make)
    await given_up(mind, "@rex hang", addressee)
    async with asyncio.timeout(LIMIT_S):
        assert (await mind.read("@rex turn left", addressee)).understanding.intent is Intent.COMMAND
    assert HangingMind.made == 2
    await mind.close()


async def test_a_call_that_is_cancelled_and_ends_keeps_its_mind(make: Callable[[], Mind], addressee: Addressee) -> None:
    mind = IsolatedMind(make)
    await given_up(mind, "@rex wait", addressee)
    assert (await mind.read("@rex turn left", addressee)).understanding.intent is Intent.COMMAND
    assert HangingMind.made == 1
    await mind.close()


async def test_a_mind_that_hangs_again_and_again_is_not_asked_any_more(
    make: Callable[[], Mind], addressee: Addressee
) -> None:
    mind = IsolatedMind(make)
    for _ in range(MOST_HUNG + 1):
        await given_up(mind, "@rex hang", addressee)
    with pytest.raises(MindError, match="has hung 5 times"):
        await mind.read("@rex turn left", addressee)
    assert HangingMind.made == MOST_HUNG + 1
