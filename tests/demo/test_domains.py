"""Programs that choose a DDS domain at the same time get different ones."""

from __future__ import annotations

import contextlib
from concurrent.futures import ThreadPoolExecutor

import pytest

from agentrob.errors import RobotBusy
from agentrob.process import host_lock
from agentrob.sim import domains
from agentrob.sim.domains import PrivateDomain


def test_concurrent_programs_get_different_domains_until_they_release_them() -> None:
    with ThreadPoolExecutor(8) as pool, contextlib.ExitStack() as kept:
        chosen = list(pool.map(lambda _: PrivateDomain(), range(16)))
        for domain in chosen:
            kept.enter_context(contextlib.closing(domain))
        assert len({domain.number for domain in chosen}) == 16
        assert {f"domain/lo/{domain.number}" for domain in chosen} <= set(host_lock.held("domain/"))
    assert not {f"domain/lo/{domain.number}" for domain in chosen} & set(host_lock.held("domain/"))


@pytest.mark.parametrize("who", ["world/lo", "driver/lo", "domain/lo"])
def test_a_domain_in_use_is_not_chosen(monkeypatch: pytest.MonkeyPatch, who: str) -> None:
    monkeypatch.setattr(domains, "DOMAINS", range(231, 233))  # beyond the valid DDS domains: unused
    with host_lock.HostLock(f"{who}/231", "the test"), contextlib.closing(PrivateDomain()) as domain:
        assert domain.number == 232
        with pytest.raises(RobotBusy, match="all DDS domains from 231 to 232 are in use"):
            PrivateDomain()
