"""Who ended a lease: the reason, the sentence, and the name of who stopped it, which is untrusted text."""

from __future__ import annotations

import asyncio
import math
import unicodedata
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.errors import LeaseLost
from agentrob.process.host_lock import namespaced
from agentrob.robots.codec import display_name
from agentrob.robots.driver.lease import TTL_S, Leases
from agentrob.robots.driver.stop import stop_driver
from tests.robots.driver_scene import FAR, NEAR, Drivers, moving


@pytest.mark.parametrize("why", ["stop", "halt"])
def test_law_14_who_ended_the_lease_is_reported_to_its_holder_and_to_who_comes_too_late(why: str) -> None:
    leases = Leases()
    lease = leases.take("walker")
    leases.end(why, "ada")
    assert leases.lost(lease) == why
    for call in (lambda: leases.renew(lease), lambda: leases.take("walker", 0.0)):
        with pytest.raises(LeaseLost, match=f"by a {why} of ada;") as caught:
            call()
        assert (caught.value.why, caught.value.by) == (why, "ada")


def test_a_lease_that_lapsed_was_ended_by_nobody() -> None:
    leases = Leases(ttl_s=0.0)
    lease = leases.take("walker")
    for unknown in (lease, "", "guessed"):
        with pytest.raises(LeaseLost, match="lapsed") as caught:
            leases.renew(unknown)
        assert (caught.value.why, caught.value.by) == ("lease_lapsed", "")
    leases.end("shutdown")
    with pytest.raises(LeaseLost, match="by a shutdown;"):
        leases.take("walker", 0.0)


@given(st.lists(st.tuples(st.floats(0, 0.5), st.floats(0, 3))))
def test_law_11_a_lease_ends_a_second_after_its_last_renewal_was_sent(renewals: list[tuple[float, float]]) -> None:
    now_s = 100.0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("agentrob.robots.driver.lease.time", SimpleNamespace(monotonic=lambda: now_s))
        leases = Leases()
        lease, sent_s = leases.take("walker"), now_s
        for later_s, way_s in renewals:
            now_s += later_s
            if now_s >= sent_s + TTL_S:
                break
            leases.renew(lease, now_s - way_s)
            sent_s = max(sent_s, now_s - way_s)
        now_s = max(now_s, math.nextafter(sent_s + TTL_S, 0.0))
        assert leases.lost(lease) == (None if now_s < sent_s + TTL_S else "lease_lapsed")
        now_s = max(now_s, sent_s + TTL_S)
        assert leases.lost(lease) == "lease_lapsed"


def test_a_renewal_from_the_future_counts_from_now() -> None:
    with pytest.MonkeyPatch.context() as patch:
        now_s = 100.0
        patch.setattr("agentrob.robots.driver.lease.time", SimpleNamespace(monotonic=lambda: now_s))
        leases = Leases()
        lease = leases.take("walker")
        leases.renew(lease, now_s + 1000)
        now_s += TTL_S
        assert leases.lost(lease) == "lease_lapsed"


@given(st.text(max_size=300))
def test_law_15_whatever_somebody_calls_themselves_it_is_one_short_line(text: str) -> None:
    name = display_name(text)
    assert len(name) <= 100
    assert name == " ".join(name.split())
    assert not any(unicodedata.category(c)[0] == "C" for c in name)
    assert display_name(name) == name


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("ada", "ada"),
        ("  Ada \n Lovelace\t", "Ada Lovelace"),
        ("\x1b[31mred\x00", "[31mred"),
        ("\u202eevil\u200b", "evil"),
        ("小明", "小明"),
        ("x" * 500, "x" * 100),
        ("\r\n", ""),
    ],
)
def test_a_name_loses_what_cannot_be_seen(text: str, name: str) -> None:
    assert display_name(text) == name


async def test_law_13_who_stopped_from_a_shell_reaches_the_holder_of_the_lease(drivers: Drivers) -> None:
    name, _ = drivers.start()
    async with drivers.client(name) as robot, robot.lease("walker") as lease:
        assert await robot.lost(lease) is None
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        await asyncio.to_thread(
            stop_driver, namespaced(f"driver/fake/{name}"), "Ada\x1b at the\u202e desk " + "x" * 200
        )
        assert (await step).reason == "stop"
        lost = await robot.lost(lease)
        assert lost is not None
        assert lost.why == "stop"
        assert lost.by.startswith("Ada at the desk xxx")
        assert len(lost.by) == 100
        with pytest.raises(LeaseLost, match=f"by a stop of {lost.by}; take a new one") as caught:
            await robot.step(lease, NEAR, 10)
        assert caught.value.by == lost.by


async def test_law_14_who_stopped_over_the_socket_reaches_who_waits_for_a_lease(drivers: Drivers) -> None:
    name, _ = drivers.start()
    async with drivers.client(name) as robot:
        accepted_s = asyncio.get_running_loop().time()
        await robot.stop("passer-by")
        with pytest.raises(LeaseLost, match="by a stop of passer-by") as caught:
            async with robot.lease("agent", accepted_s):
                pass
        assert (caught.value.why, caught.value.by) == ("stop", "passer-by")
