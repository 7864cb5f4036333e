"""The pages of signing in, signing up, invites and passwords."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.forms import Line, PageForm
from agentrob.board.web.templating import error_text, own_path, redirect, render_page
from agentrob.errors import BoardError

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


class SignInForm(PageForm):
    """`next` is the page to go to after signing in."""

    name: Line = ""
    password: str = ""
    next: str = ""


class PasswordForm(PageForm):
    old: str = ""
    password: str = ""


SentForm = Annotated[PageForm, Form()]
SentSignIn = Annotated[SignInForm, Form()]
SentPassword = Annotated[PasswordForm, Form()]


# -------------------------------------------------------------------- by name and password
@router.get("/sign-in")
async def sign_in_form(request: Request, viewer: AnyViewer, next: str = "/") -> Response:
    if viewer.account:
        return redirect(own_path(next))
    return _sign_in_page(request, viewer, up=False, path=own_path(next))


@router.get("/sign-up")
async def sign_up_form(request: Request, services: AppServices, viewer: AnyViewer, next: str = "/") -> Response:
    if not services.settings.sign_up:
        raise BoardError(403, "sign_up_off", "this forum does not let people make their own accounts")
    return _sign_in_page(request, viewer, up=True, path=own_path(next))


@router.post("/sign-in")
async def sign_in(request: Request, services: AppServices, viewer: AnyViewer, form: SentSignIn) -> Response:
    return await _open_session(request, services, viewer, form, up=False)


@router.post("/sign-up")
async def sign_up(request: Request, services: AppServices, viewer: AnyViewer, form: SentSignIn) -> Response:
    return await _open_session(request, services, viewer, form, up=True)


@router.post("/sign-out")
async def sign_out(services: AppServices, viewer: AnyViewer, form: SentForm) -> Response:
    access.check_form(viewer, form.csrf)
    response = redirect("/sign-in")
    await access.sign_out(services, viewer, response)
    return response


async def _open_session(
    request: Request, services: Services, viewer: Viewer, form: SignInForm, *, up: bool
) -> Response:
    path, begin = own_path(form.next), access.sign_up if up else access.sign_in
    try:
        access.check_form(viewer, form.csrf)
        session = await begin(services, form.name, form.password, forms.address(request))
    except BoardError as e:
        return _sign_in_page(request, viewer, up=up, path=path, draft=form.name, error=e)
    return _signed_in(services, session, path)


def _sign_in_page(
    request: Request, viewer: Viewer, *, up: bool, path: str, draft: str = "", error: BoardError | None = None
) -> Response:
    return _page(request, viewer, "sign_in.html", {"up": up, "next": path, "draft": draft}, error)


# -------------------------------------------------------------------- by links
@router.get("/enter/{secret}")
async def enter_form(request: Request, viewer: AnyViewer, secret: str) -> Response:
    """Shows only a button, so that a prefetch does not use the link up."""
    return _page(request, viewer, "enter.html", {"secret": secret})


@router.post("/enter/{secret}")
async def enter(services: AppServices, viewer: AnyViewer, secret: str, form: SentForm) -> Response:
    access.check_form(viewer, form.csrf)
    return _signed_in(services, await access.enter(services, secret))


@router.get("/invite/{secret}")
async def invite_form(request: Request, viewer: AnyViewer, secret: str) -> Response:
    """Shows only a form, so that a prefetch does not use the invite up."""
    return _page(request, viewer, "invited.html", {"secret": secret, "draft": ""})


@router.post("/invite/{secret}")
async def accept_invite(
    request: Request, services: AppServices, viewer: AnyViewer, secret: str, form: SentSignIn
) -> Response:
    try:
        access.check_form(viewer, form.csrf)
        session = await access.sign_up(services, form.name, form.password, forms.address(request), secret)
    except BoardError as e:
        return _page(request, viewer, "invited.html", {"secret": secret, "draft": form.name}, e)
    return _signed_in(services, session)


# -------------------------------------------------------------------- passwords
@router.get("/password/{secret}")
async def reset_password_form(request: Request, viewer: AnyViewer, secret: str) -> Response:
    return _page(request, viewer, "password.html", {"action": f"/password/{secret}", "old": False})


@router.post("/password/{secret}")
async def reset_password(
    request: Request, services: AppServices, viewer: AnyViewer, secret: str, form: SentPassword
) -> Response:
    try:
        access.check_form(viewer, form.csrf)
        session = await access.new_password(services, secret, form.password, forms.address(request))
    except BoardError as e:
        return _page(request, viewer, "password.html", {"action": f"/password/{secret}", "old": False}, e)
    return _signed_in(services, session)


@router.get("/password")
async def change_password_form(request: Request, services: AppServices, viewer: ReadingViewer) -> Response:
    old = access.has_password(services, access.account_of(viewer))
    return _page(request, viewer, "password.html", {"action": "/password", "old": old}, here="me")


@router.post("/password")
async def change_password(request: Request, services: AppServices, viewer: AnyViewer, form: SentPassword) -> Response:
    by = form.sender(viewer)
    old = access.has_password(services, by)
    try:
        session = await access.change_password(services, by, form.old, form.password, forms.address(request))
    except BoardError as e:
        return _page(request, viewer, "password.html", {"action": "/password", "old": old}, e, here="me")
    return _signed_in(services, session)


# -------------------------------------------------------------------- responses
def _page(
    request: Request,
    viewer: Viewer,
    template: str,
    data: dict[str, Any],
    error: BoardError | None = None,
    here: str = "sign-in",
) -> Response:
    data |= {"problem": error_text(error)}
    return render_page(request, viewer, template, data, status=error.status if error else 200, here=here)


def _signed_in(services: Services, session: str, path: str = "/") -> Response:
    response = redirect(path)
    access.set_session(response, services, session)
    return response
