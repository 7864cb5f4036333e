"""The double over HTTP: `create_app(site)` returns an ASGI app with Discourse's routes."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response, StreamingResponse
from starlette.routing import Route

from tests.doubles.discourse import admin, answers
from tests.doubles.discourse.caller import Caller, Handler, body
from tests.doubles.discourse.document import filled
from tests.doubles.discourse.site import Category, Refusal, Site, missing
from tests.doubles.discourse.visitors import Visitors


def create_app(site: Site) -> Starlette:
    visitors = Visitors(site)

    def handled(handler: Handler) -> Callable[[Request], Awaitable[Response]]:
        async def endpoint(request: Request) -> Response:
            try:
                user, by_api = visitors.who(request) if handler is not poll else visitors.who_or_nobody(request)
                return await handler(request, Caller(site, visitors, user, by_api))
            except Refusal as e:
                return _refused(e)

        return endpoint

    app = Starlette(routes=[Route(path, handled(h), methods=[m]) for m, path, h in [*ROUTES, *admin.ROUTES]])
    app.state.visitors = visitors
    return app


def _refused(e: Refusal) -> Response:
    headers = {"Retry-After": str(e.wait_s)} if e.wait_s is not None else {}
    if e.plain:
        said = f"Slow down, you're making too many requests.\nPlease retry again in {e.wait_s} seconds.\n"
        return Response(said, e.status, headers, "text/plain")
    body: dict[str, Any] = {"errors": [e.said]}
    if e.status == 422:
        body = {"action": "create_post", **body}
    if e.kind:
        body["error_type"] = e.kind
    if e.wait_s is not None:
        body["extras"] = {"wait_seconds": e.wait_s}
    return JSONResponse(body, e.status, headers)


# ---------------------------------------------------------------- reading
async def categories(request: Request, caller: Caller) -> Response:
    return JSONResponse(answers.categories(caller.site, caller.user))


async def category_topics(request: Request, caller: Caller) -> Response:
    category: Category | None = caller.site.categories.get(int(request.path_params["id"]))
    if category is None:
        raise missing()
    if request.path_params["slug"] != (path := answers.category_path(caller.site, category)):
        return RedirectResponse(f"/c/{path}/{category.id}.json", 301)
    page = int(request.query_params.get("page", 0))
    return JSONResponse(answers.category_topics(caller.site, category, caller.user, page))


async def latest_posts(request: Request, caller: Caller) -> Response:
    before = int(request.query_params.get("before", 0))
    return JSONResponse(answers.latest_posts(caller.site, caller.user, before if before > 0 else None))


async def post(request: Request, caller: Caller) -> Response:
    return JSONResponse(answers.filled_post(answers.post(caller.site, caller.post(request), caller.user)))


async def post_by_number(request: Request, caller: Caller) -> Response:
    topic, number = caller.topic(request), int(request.path_params["number"])
    for n in topic.posts:
        if caller.site.posts[n].number == number and caller.site.visible(caller.user, caller.site.posts[n]):
            return JSONResponse(answers.filled_post(answers.post(caller.site, caller.site.posts[n], caller.user)))
    raise missing()


async def topic(request: Request, caller: Caller) -> Response:
    username = request.query_params.get("username_filters")
    return JSONResponse(answers.topic_view(caller.site, caller.topic(request), caller.user, username))


async def topic_posts(request: Request, caller: Caller) -> Response:
    first = caller.topic(request).posts[: int(caller.site.settings["posts_per_page"])]
    ids = [int(n) for n in request.query_params.getlist("post_ids[]")] or first
    raw = "include_raw" in request.query_params
    return JSONResponse(answers.some_posts(caller.site, caller.topic(request), caller.user, ids, raw))


async def topic_by_external_id(request: Request, caller: Caller) -> Response:
    wanted = request.path_params["external_id"]
    for t in caller.site.topics.values():
        if t.external_id == wanted and caller.site.sees(caller.user, t):
            return RedirectResponse(f"/t/{answers.slug(t)}/{t.id}.json", 301)
    raise missing()


async def profile(request: Request, caller: Caller) -> Response:
    user = caller.site.named(request.path_params["username"])
    if user is None or not user.active:
        raise missing()
    return JSONResponse(answers.profile(caller.site, user))


async def actions(request: Request, caller: Caller) -> Response:
    user = caller.site.named(request.query_params["username"])
    if user is None:
        raise missing()
    wanted = set(request.query_params["filter"].split(","))
    offset = int(request.query_params["offset"])
    return JSONResponse(answers.actions(caller.site, user, caller.user, wanted, offset))


async def notifications(request: Request, caller: Caller) -> Response:
    mine = [
        {k: v for k, v in n.items() if k != "user_id"} | {"user_id": n["user_id"]}
        for n in reversed(caller.site.notifications)
        if n["user_id"] == caller.user.id
    ]
    offset, limit = (int(request.query_params.get(name, usual)) for name, usual in (("offset", 0), ("limit", 60)))
    shown = mine[offset : offset + min(limit, 60)]
    return JSONResponse({"notifications": shown, "total_rows_notifications": len(mine), "seen_notification_id": 0})


async def search(request: Request, caller: Caller) -> Response:
    page = int(request.query_params.get("page", 1))
    return JSONResponse(answers.search(caller.site, caller.user, request.query_params.get("q", ""), page))


async def pending(request: Request, caller: Caller) -> Response:
    user = caller.site.named(request.path_params["username"])
    if user is None or not (caller.user.staff or caller.user.id == user.id):
        raise missing()
    mine = [(n, w) for n, (who, w) in caller.site.waiting.items() if who == user.id]
    found = [{"id": n, "raw_text": w["raw"], "topic_id": w.get("topic_id"), "username": user.username} for n, w in mine]
    return JSONResponse({"pending_posts": found})


async def file(request: Request, caller: Caller) -> Response:
    if (elsewhere := caller.site.moved.get(request.path_params["name"])) is not None:
        return RedirectResponse(elsewhere, 302)
    found = caller.site.uploads.get(request.path_params["name"])
    if found is None:
        raise missing()
    return Response(found[1], media_type=found[0])


# ---------------------------------------------------------------- writing
async def create(request: Request, caller: Caller) -> Response:
    answer = caller.site.create(caller.user, await body(request), caller.by_api)
    if "post" not in answer:
        return JSONResponse(answer)
    return JSONResponse(filled("post", "/posts.json", answers.post(caller.site, answer["post"], caller.user)))


async def revise(request: Request, caller: Caller) -> Response:
    found = caller.post(request)
    caller.site.revise(caller.user, found, (await body(request))["post"]["raw"])
    return JSONResponse(filled("put", "/posts/{id}.json", {"post": answers.post(caller.site, found, caller.user)}))


async def delete(request: Request, caller: Caller) -> Response:
    caller.site.delete(caller.user, caller.post(request))
    return Response(status_code=200)


async def upload(request: Request, caller: Caller) -> Response:
    user, form = caller.user, await request.form()
    given = form["file"]
    if isinstance(given, str):
        raise Refusal(400, "param is missing or the value is empty: file")
    content, name = await given.read(), given.filename or ""
    kind = name.rpartition(".")[2].lower()
    if kind not in ("jpg", "jpeg", "png", "gif", "webp"):
        raise Refusal(
            422, "Sorry, the file you are trying to upload is not authorized (authorized extensions: jpg, …)."
        )
    stored = caller.site.add_upload(content, kind)
    known = {
        "id": len(caller.site.uploads), "url": caller.site.upload_path(f"upload://{stored}"), "extension": kind,
        "original_filename": name, "filesize": len(content), "width": 1, "height": 1, "short_url": f"upload://{stored}",
        "short_path": f"/uploads/short-url/{stored}", "human_filesize": f"{len(content)} Bytes",
    }  # fmt: skip
    caller.site.limit("upload", user.id, caller.site.settings.get("uploads_per_minute", 0), 60)
    return JSONResponse(filled("post", "/uploads.json", known))


# ---------------------------------------------------------------- accounts and the message bus
async def sign_up(request: Request, caller: Caller) -> Response:
    return JSONResponse(caller.visitors.sign_up(await body(request), caller.known if caller.by_api else None))


async def honeypot(request: Request, caller: Caller) -> Response:
    return JSONResponse(caller.visitors.honeypot())


async def csrf(request: Request, caller: Caller) -> Response:
    return caller.visitors.csrf(request)


async def sign_in(request: Request, caller: Caller) -> Response:
    return caller.visitors.sign_in(request, await body(request))


async def current(request: Request, caller: Caller) -> Response:
    if caller.known is None:
        raise missing()
    return JSONResponse({"current_user": answers.basic(caller.user)})


async def poll(request: Request, caller: Caller) -> Response:
    """Hold the request open and send chunks, or answer at once (`dlp=t`)."""
    places = {k: int(v) for k, v in (await body(request)).items() if k != "__seq"}
    user = caller.known
    who, groups = (None, set()) if user is None else (user.id, None if user.admin else user.groups)
    if request.query_params.get("dlp") == "t":
        return JSONResponse(caller.site.bus.backlog(places, who, groups))
    pieces = caller.site.bus.held(places, who, groups, caller.site.settings["long_polling_interval_s"])
    return StreamingResponse(pieces, media_type="text/plain", headers={"X-Client": secrets.token_hex(4)})


ROUTES: list[tuple[str, str, Handler]] = [
    ("GET", "/categories.json", categories),
    ("GET", "/c/{slug:path}/{id:int}.json", category_topics),
    ("GET", "/posts.json", latest_posts),
    ("POST", "/posts.json", create),
    ("GET", "/posts/{id:int}.json", post),
    ("PUT", "/posts/{id:int}.json", revise),
    ("DELETE", "/posts/{id:int}.json", delete),
    ("GET", "/posts/by_number/{id:int}/{number:int}.json", post_by_number),
    ("GET", "/posts/{username}/pending.json", pending),
    ("GET", "/t/{id:int}.json", topic),
    ("GET", "/t/{id:int}/posts.json", topic_posts),
    ("GET", "/t/external_id/{external_id}.json", topic_by_external_id),
    ("POST", "/uploads.json", upload),
    ("GET", "/uploads/default/original/1X/{name}", file),
    ("GET", "/u/{username}.json", profile),
    ("GET", "/user_actions.json", actions),
    ("GET", "/notifications.json", notifications),
    ("GET", "/search.json", search),
    ("POST", "/users.json", sign_up),
    ("GET", "/session/hp.json", honeypot),
    ("GET", "/session/csrf.json", csrf),
    ("POST", "/session.json", sign_in),
    ("GET", "/session/current.json", current),
    ("POST", "/message-bus/{client}/poll", poll),
]
