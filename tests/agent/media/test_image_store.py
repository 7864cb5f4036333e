"""Pictures of replies in an image store: a real S3 server on loopback, and every way in which it can fail."""

from __future__ import annotations

import asyncio
import json
import socket
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import obstore
import pytest

from agentrob.agent.media import image_store as images
from agentrob.agent.media.image_store import Bucket, Link, make_store
from agentrob.config.load import parse
from agentrob.errors import ConfigError, ImageStoreError
from tests.agent.agent_scene import Driver, make_scene
from tests.agent.media.s3_server import BUCKET, DOMAIN, READER, WRITER, S3Server
from tests.host_numbers import free_port

DRAWS = True

JPEG = b"\xff\xd8\xff\xe0 not really"
WALK = "@quadruped walk forward 0.5 m and take a photo"


@pytest.fixture(scope="module")
def s3(tmp_path_factory: pytest.TempPathFactory) -> Iterator[S3Server]:
    server = S3Server(tmp_path_factory.mktemp("s3"))
    yield server
    server.end()


@pytest.fixture(autouse=True)
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, (key, secret) in (("AWS", WRITER), ("READER", READER)):
        monkeypatch.setenv(f"{name}_ACCESS_KEY_ID", key)
        monkeypatch.setenv(f"{name}_SECRET_ACCESS_KEY", secret)
    monkeypatch.setenv("TOS_ACCESS_KEY", WRITER[0])
    monkeypatch.setenv("TOS_SECRET_KEY", WRITER[1])


def bucket(url: str, **more: object) -> Bucket:
    given = {"store": "s3", "bucket": BUCKET, "endpoint": url, "region": "us-east-1", **more}
    store = make_store(parse({"images": given}).images)
    assert isinstance(store, Bucket)
    return store


def fetch(url: str, proxy: str = "") -> tuple[int, str, bytes]:
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({"http": proxy} if proxy else {}))
    try:
        with opener.open(url, timeout=100) as answer:
            return answer.status, answer.headers["content-type"], answer.read()
    except urllib.error.HTTPError as e:
        return e.code, "", b""


# -------------------------------------------------------------------- the store
async def test_a_picture_is_kept_and_its_link_shows_it_to_whoever_has_it(s3: S3Server) -> None:
    store = bucket(s3.url)
    link = await store.keep("7-step1", JPEG)
    assert await asyncio.to_thread(fetch, link.url) == (200, "image/jpeg", JPEG)
    left = link.until - datetime.now(UTC)
    assert timedelta(hours=23) < left <= timedelta(days=1)
    another = await store.keep("7-step1", JPEG)
    assert another.url.partition("?")[0] != link.url.partition("?")[0], "an address must not be guessed from the post"


async def test_without_its_signature_or_after_its_time_a_link_shows_nothing(s3: S3Server) -> None:
    store = bucket(s3.url)
    link = await store.keep("7-path", JPEG)
    plain = link.url.partition("?")[0]
    assert (await asyncio.to_thread(fetch, plain))[0] == 403
    assert (await asyncio.to_thread(fetch, link.url.replace("Expires=86400", "Expires=86401")))[0] == 403
    soon = obstore.sign(store._store, "GET", plain.partition(f"/{BUCKET}/")[2], timedelta(seconds=1))
    end_s = time.monotonic() + 60
    while (status := (await asyncio.to_thread(fetch, soon))[0]) == 200 and time.monotonic() < end_s:
        pass
    assert status == 403


async def test_tos_is_spoken_to_with_the_bucket_in_the_host_name(s3: S3Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HTTP_PROXY", s3.url)  # the way to a host of that name leads to our server
    store = bucket(f"http://{DOMAIN}", store="tos", region="cn-test")
    link = await store.keep("7-path", JPEG)
    assert link.url.startswith(f"http://{BUCKET}.{DOMAIN}/agentrob/")
    assert await asyncio.to_thread(fetch, link.url, s3.url) == (200, "image/jpeg", JPEG)
    tos = parse({"images": {"store": "tos", "bucket": "b-1", "region": "cn-beijing"}}).images
    assert tos.bucket_address == "https://b-1.tos-s3-cn-beijing.volces.com"


async def test_a_key_that_may_not_write_is_reported_as_one_short_sentence(s3: S3Server) -> None:
    store = bucket(s3.url, key_env="READER_ACCESS_KEY_ID", secret_env="READER_SECRET_ACCESS_KEY")
    with pytest.raises(ImageStoreError, match=r"7-path: .*403 Forbidden.*AccessDenied") as refused:
        await store.keep("7-path", JPEG)
    assert READER[1] not in str(refused.value)
    assert len(str(refused.value)) < 200


async def test_a_store_that_is_down_is_reported_soon() -> None:
    begun_s = time.monotonic()
    with pytest.raises(ImageStoreError):
        await bucket(f"http://127.0.0.1:{free_port()}").keep("7-path", JPEG)
    assert time.monotonic() - begun_s < images.KEEP_S + 2


async def test_a_store_that_never_answers_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(images, "KEEP_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        begun_s = time.monotonic()
        with pytest.raises(ImageStoreError, match=r"within 0\.5 s"):
            await bucket(f"http://127.0.0.1:{silent.getsockname()[1]}").keep("7-path", JPEG)
    assert time.monotonic() - begun_s < 3


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"store": "s3"}, "needs bucket and region"),
        ({"store": "tos", "bucket": "abc", "region": "cn-beijing", "path_style": True}, "host name only"),
        ({"store": "ftp"}, "'inline', 's3' or 'tos'"),
        ({"store": "s3", "bucket": "abc", "region": "r", "endpoint": "http://me:hunter2@x"}, "without a user"),
        ({"store": "s3", "bucket": "abc", "region": "r", "link_s": 10}, "60"),
        ({"secret": "hunter2"}, "valid here: bucket"),
    ],
)
def test_a_wrong_table_says_what_would_be_valid_and_repeats_no_secret(given: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said) as wrong:
        parse({"images": given})
    assert "hunter2" not in str(wrong.value)


def test_missing_keys_are_named_before_anything_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("TOS_SECRET_KEY")
    with pytest.raises(ConfigError, match="TOS_ACCESS_KEY and TOS_SECRET_KEY"):
        make_store(parse({"images": {"store": "tos", "bucket": "abc", "region": "cn-beijing"}}).images)
    assert make_store(parse({}).images) is None


# -------------------------------------------------------------------- the reply
async def test_a_reply_links_its_pictures_and_the_data_and_says_until_when(
    s3: S3Server, driver: Driver, tmp_path: Path
) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent(store=bucket(s3.url)):
        reply = await scene.final(await scene.post("alice", WALK))
    assert not reply.images
    assert "Whoever has a link can open it for 1 day; then it is void." in reply.raw
    urls = {name: reply.raw.partition(f"[{name}](")[2].partition(")")[0] for name in ("photo of step 2", "its data")}
    assert (await asyncio.to_thread(fetch, urls["photo of step 2"]))[:2] == (200, "image/jpeg")
    status, _, data = await asyncio.to_thread(fetch, urls["its data"])
    assert status == 200
    assert json.loads(data.splitlines()[0])["robot"] == "quadruped"


class LimitedStore:
    """A store that accepts only the first pictures."""

    def __init__(self, good: int) -> None:
        self.good = good

    async def keep(self, name: str, data: bytes) -> Link:
        self.good -= 1
        if self.good < 0:
            raise ImageStoreError("the image store does not answer")
        return Link(f"http://127.0.0.1/{name}", datetime.now(UTC), 60.0)


@pytest.mark.parametrize(("good", "attached"), [(0, 2), (1, 1)])
async def test_what_the_store_does_not_take_is_in_the_post_itself(
    driver: Driver, tmp_path: Path, good: int, attached: int
) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent(store=LimitedStore(good)):
        reply = await scene.final(await scene.post("alice", WALK))
    assert reply.card is not None
    assert reply.card.state == "done"
    assert len(reply.images) == attached
    assert reply.raw.count("](http://127.0.0.1/") == good
    assert "its data" not in reply.raw
