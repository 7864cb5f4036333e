"""Pages by which people come in without e-mail: an invite, a new password by a one-time link, another password."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.services import Services, get_services
from agentrob.board.web.admin import forms
from agentrob.board.web.templating import go, show
from agentrob.errors import BoardError
from agentrob.model import Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]


@router.get("/invite/{secret}")
async def invited(request: Request, viewer: Anybody, secret: str) -> Response:
    """Shows a form only: a prefetch of the link uses nothing up."""
    return show(request, viewer, "invited.html", {"secret": secret, "draft": ""}, here="sign-in")


@router.post("/invite/{secret}")
async def accept_invite(request: Request, viewer: Anybody, secret: str) -> Response:
    form = await forms.read(request)
    name, known = forms.field(form, "name"), get_services(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.sign_up(known, name, forms.password(form, "password"), forms.address(request), secret)
    except BoardError as e:
        data = {"secret": secret, "draft": name, "problem": forms.problem(e)}
        return show(request, viewer, "invited.html", data, status=e.status, here="sign-in")
    return _signed_in(known, session)


@router.get("/password/{secret}")
async def forgotten(request: Request, viewer: Anybody, secret: str) -> Response:
    return show(request, viewer, "password.html", {"action": f"/password/{secret}", "old": False}, here="sign-in")


@router.post("/password/{secret}")
async def reset_password(request: Request, viewer: Anybody, secret: str) -> Response:
    form, known = await forms.read(request), get_services(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.new_password(known, secret, forms.password(form, "password"), forms.address(request))
    except BoardError as e:
        data = {"action": f"/password/{secret}", "old": False, "problem": forms.problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="sign-in")
    return _signed_in(known, session)


@router.get("/password")
async def own_password(request: Request, viewer: Reading) -> Response:
    access.account_of(viewer)
    return show(request, viewer, "password.html", {"action": "/password", "old": True}, here="me")


@router.post("/password")
async def change_password(request: Request, viewer: Anybody) -> Response:
    form, by = await forms.sent(request, viewer, Role.GUEST)
    known, old, new = get_services(request), forms.password(form, "old"), forms.password(form, "password")
    try:
        session = await access.change_password(known, by, old, new, forms.address(request))
    except BoardError as e:
        data = {"action": "/password", "old": True, "problem": forms.problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="me")
    return _signed_in(known, session)


def _signed_in(known: Services, session: str) -> Response:
    response = go("/")
    access.set_session(response, known, session)
    return response
