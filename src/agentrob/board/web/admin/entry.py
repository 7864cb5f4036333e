"""Pages by which people come in without e-mail: an invite, a new password by a one-time link, another password."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.templating import go, show
from agentrob.errors import BoardError
from agentrob.model import Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


@router.get("/invite/{secret}")
async def invited(request: Request, viewer: AnyViewer, secret: str) -> Response:
    """Shows a form only: a prefetch of the link uses nothing up."""
    return show(request, viewer, "invited.html", {"secret": secret, "draft": ""}, here="sign-in")


@router.post("/invite/{secret}")
async def accept_invite(request: Request, services: AppServices, viewer: AnyViewer, secret: str) -> Response:
    form = await forms.read(request)
    name = forms.stripped(form, "name")
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.sign_up(services, name, forms.password(form, "password"), forms.address(request), secret)
    except BoardError as e:
        data = {"secret": secret, "draft": name, "problem": forms.problem(e)}
        return show(request, viewer, "invited.html", data, status=e.status, here="sign-in")
    return _signed_in(services, session)


@router.get("/password/{secret}")
async def forgotten(request: Request, viewer: AnyViewer, secret: str) -> Response:
    return show(request, viewer, "password.html", {"action": f"/password/{secret}", "old": False}, here="sign-in")


@router.post("/password/{secret}")
async def reset_password(request: Request, services: AppServices, viewer: AnyViewer, secret: str) -> Response:
    form = await forms.read(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.new_password(services, secret, forms.password(form, "password"), forms.address(request))
    except BoardError as e:
        data = {"action": f"/password/{secret}", "old": False, "problem": forms.problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="sign-in")
    return _signed_in(services, session)


@router.get("/password")
async def own_password(request: Request, viewer: ReadingViewer) -> Response:
    access.account_of(viewer)
    return show(request, viewer, "password.html", {"action": "/password", "old": True}, here="me")


@router.post("/password")
async def change_password(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.GUEST)
    old, new = forms.password(form, "old"), forms.password(form, "password")
    try:
        session = await access.change_password(services, by, old, new, forms.address(request))
    except BoardError as e:
        data = {"action": "/password", "old": True, "problem": forms.problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="me")
    return _signed_in(services, session)


def _signed_in(services: Services, session: str) -> Response:
    response = go("/")
    access.set_session(response, services, session)
    return response
