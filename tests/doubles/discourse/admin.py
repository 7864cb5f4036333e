"""The double's admin endpoints: settings, categories, groups, keys, suspension, approval."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from tests.doubles.discourse import answers
from tests.doubles.discourse.caller import Caller, Handler, body
from tests.doubles.discourse.document import filled
from tests.doubles.discourse.site import Refusal, missing


async def change_setting(request: Request, caller: Caller) -> Response:
    name = request.path_params["name"]
    if name not in caller.site.settings:
        raise Refusal(422, f"No setting named '{name}' exists")
    value = (await body(request))[name]
    caller.site.settings[name] = float({"true": 1, "false": 0}.get(str(value), value))
    return Response(status_code=200)


async def add_category(request: Request, caller: Caller) -> Response:
    given = await body(request)
    if any(c.slug == given.get("slug") for c in caller.site.categories.values()):
        raise Refusal(422, "Slug is already in use")
    c = caller.site.add_category(given["name"], given.get("slug", ""), given.get("parent_category_id"))
    known = {"id": c.id, "name": c.name, "slug": c.slug}
    return JSONResponse(filled("post", "/categories.json", {"category": known}))


async def add_group(request: Request, caller: Caller) -> Response:
    name = (await body(request))["group"]["name"]
    if any(g.name == name for g in caller.site.groups.values()):
        raise Refusal(422, "Name has already been taken")
    group = caller.site.add_group(name)
    return JSONResponse(filled("post", "/admin/groups.json", {"basic_group": {"id": group.id, "name": group.name}}))


async def group(request: Request, caller: Caller) -> Response:
    for g in caller.site.groups.values():
        if g.name == request.path_params["name"]:
            return JSONResponse(filled("get", "/groups/{name}.json", {"group": {"id": g.id, "name": g.name}}))
    raise missing()


async def add_members(request: Request, caller: Caller) -> Response:
    names = (await body(request))["usernames"].split(",")
    for name in names:
        if (user := caller.site.named(name)) is not None:
            user.groups.add(int(request.path_params["id"]))
    return JSONResponse({"success": "OK", "usernames": names, "emails": []})


async def remove_members(request: Request, caller: Caller) -> Response:
    names = (await body(request))["usernames"].split(",")
    for name in names:
        if (user := caller.site.named(name)) is not None:
            user.groups.discard(int(request.path_params["id"]))
    return JSONResponse({"success": "OK", "usernames": names, "skipped_usernames": []})


async def add_key(request: Request, caller: Caller) -> Response:
    name = (await body(request))["key"].get("username")
    return JSONResponse({"key": {"key": caller.site.add_key(caller.site.named(name) if name else None)}})


async def suspend(request: Request, caller: Caller) -> Response:
    by = caller.user
    user = caller.site.users[int(request.path_params["id"])]
    given = await body(request)
    user.suspended_till = given["suspend_until"]
    known = {
        "suspend_reason": given["reason"],
        "full_suspend_reason": given["reason"],
        "suspended_by": answers.basic(by),
    }
    known |= {"suspended_till": given["suspend_until"], "suspended_at": "2026-01-01T00:00:00.000Z"}
    return JSONResponse(filled("put", "/admin/users/{id}/suspend.json", {"suspension": known}))


async def unsuspend(request: Request, caller: Caller) -> Response:
    caller.site.users[int(request.path_params["id"])].suspended_till = None
    return JSONResponse({"suspension": {"suspended_till": None}})


async def review(request: Request, caller: Caller) -> Response:
    """Approve or reject a queued post, as a moderator."""
    number = int(request.path_params["id"])
    if number not in caller.site.waiting:
        raise missing()
    if request.path_params["action"] == "approve_post":
        caller.site.approve(number)
    else:
        del caller.site.waiting[number]
    return JSONResponse({"reviewable_perform_result": {"success": True}})


def _admins_only(handler: Handler) -> Handler:
    """Answer 404 to everybody but admins, as Discourse does."""

    async def guarded(request: Request, caller: Caller) -> Response:
        if not caller.user.admin:
            raise missing()
        return await handler(request, caller)

    return guarded


_ROUTES = [
    ("PUT", "/admin/site_settings/{name}.json", change_setting),
    ("POST", "/categories.json", add_category),
    ("POST", "/admin/groups.json", add_group),
    ("GET", "/groups/{name}.json", group),
    ("PUT", "/groups/{id:int}/members.json", add_members),
    ("DELETE", "/groups/{id:int}/members.json", remove_members),
    ("POST", "/admin/api/keys.json", add_key),
    ("PUT", "/admin/users/{id:int}/suspend.json", suspend),
    ("PUT", "/admin/users/{id:int}/unsuspend.json", unsuspend),
    ("PUT", "/review/{id:int}/perform/{action}.json", review),
]
ROUTES = [(method, path, _admins_only(handler)) for method, path, handler in _ROUTES]
