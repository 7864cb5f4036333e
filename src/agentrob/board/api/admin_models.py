"""Request and response models of administration and moderation. Other fields are refused."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StringConstraints

from agentrob.board.admin import management
from agentrob.board.api.models import PostOut, Time, _In, _Out, time_out, whole
from agentrob.board.auth.rights import WHO, MaintenanceWindow, RobotSettings, closed_out
from agentrob.board.db import audit, records
from agentrob.model import AccountKind, ActionClass, Role

#: Strict models take enums from JSON by value only with this option.
RoleWord = Annotated[Role, Field(strict=False)]
KindWord = Annotated[AccountKind, Field(strict=False)]
ClassWord = Annotated[ActionClass, Field(strict=False)]
Whole = BeforeValidator(whole)
#: Guests do not post, and only operators and those above them command (law 2).
Poster = Literal["member", "operator", "moderator", "admin"]
Commander = Literal["operator", "moderator", "admin"]
Scope = Literal["read", "write", "admin"]
Line = Annotated[str, StringConstraints(max_length=200, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]
Slug = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9-]{0,31}$")]
Handle = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]
Clock = Annotated[str, StringConstraints(pattern=r"^([01][0-9]|2[0-3]):[0-5][0-9]$")]
Who = Literal["operator", "moderator", "admin", "owner", "nobody"]
Day = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
assert set(WHO) == set(Who.__args__)  # type: ignore[attr-defined]


class _Change(_In):
    """Changes only the given fields; null is not a value."""

    def given(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.model_fields_set}


# -------------------------------------------------------------------- accounts
class AccountIn(_In):
    name: Handle
    kind: KindWord = AccountKind.HUMAN
    role: RoleWord = Role.MEMBER
    display_name: Annotated[Line, Field(max_length=64)] = ""


class AccountChange(_Change):
    role: RoleWord = Role.MEMBER
    suspended: bool = False
    display_name: Annotated[Line, Field(max_length=64)] = ""
    commands_simulated: bool = Field(False, description="may command simulated robots, whatever its role")


class LinkIn(_In):
    purpose: Literal["enter", "password"] = "password"


class LinkOut(_Out):
    url: str


class Erased(_Out):
    posts: int
    pictures: int


class TokenIn(_In):
    label: Annotated[Line, Field(max_length=64)] = ""
    scopes: Annotated[list[Scope], Field(min_length=1, max_length=3)] = Field(["read", "write"])


class TokenWritten(_Out):
    token: str = Field(description="shown here and never again")


class TokenOut(_Out):
    id: str
    account: str
    label: str
    scopes: tuple[str, ...]
    created_at: Time
    revoked_at: Time | None


class InviteIn(_In):
    role: Literal["guest", "member", "operator", "moderator"] = "member"
    commands_simulated: bool = Field(False, description="the new accounts may command simulated robots")
    uses: Annotated[int, Field(ge=1, le=management.MAX_INVITE_USES), Whole] = 1
    days: Annotated[int, Field(ge=1, le=management.MAX_INVITE_DAYS), Whole] = 7


class InviteOut(_Out):
    id: str
    role: Role
    commands_simulated: bool
    left: int
    expires_at: Time


# -------------------------------------------------------------------- boards and robots
class BoardChange(_Change):
    name: Annotated[Line, Field(min_length=1, max_length=64)] = ""
    description: Line = ""
    read_role: RoleWord = Role.GUEST
    post_role: Poster = "member"
    command_role: Commander = "operator"

    def given(self) -> dict[str, Any]:
        roles = ("post_role", "command_role")
        return {k: Role(v) if k in roles else v for k, v in super().given().items()}


class BoardIn(BoardChange):
    id: Slug
    name: Annotated[Line, Field(min_length=1, max_length=64)]

    def record(self) -> records.Board:
        return records.Board(**self.given())


class BoardRights(_Out):
    id: str
    name: str
    description: str
    read_role: Role
    post_role: Role
    command_role: Role


class Hours(_In):
    """When a robot is in maintenance: on `days` (every day if empty) from `from` to `to` in `zone`, or until a time."""

    days: Annotated[list[Day], Field(max_length=7)] = Field([])
    start: Annotated[Clock, Field(alias="from")] = "00:00"
    end: Annotated[Clock, Field(alias="to")] = "00:00"
    zone: Annotated[Line, Field(max_length=40)] = "UTC"
    until: Annotated[datetime | None, Field(strict=False)] = None
    note: Line = ""

    def record(self) -> MaintenanceWindow:
        return MaintenanceWindow(tuple(self.days), self.start, self.end, self.zone, self.until, self.note)


class RobotChange(_Change):
    owner: Annotated[str, StringConstraints(pattern=r"^([a-z][a-z0-9_-]{1,31})?$")] = ""
    command: dict[ClassWord, Who] = Field({})
    approve: Who = "moderator"
    release: Literal["owner", "admin", "nobody"] = "owner"
    approval: Annotated[list[ClassWord], Field(max_length=4)] = Field([])
    approve_own: bool = False
    camera_role: RoleWord = Role.GUEST
    camera_days: Annotated[int, Field(ge=0, le=3650), Whole] = 0
    closed: Annotated[list[Hours], Field(max_length=20)] = Field([])

    def changes(self, kept: RobotSettings) -> dict[str, Any]:
        """The given fields as those of `RobotSettings`; `command` changes only the classes that it names."""
        found = self.given()
        if "command" in found:
            found["command"] = dict(kept.command) | {str(c): who for c, who in self.command.items()}
        if "closed" in found:
            found["closed"] = tuple(hours.record() for hours in self.closed)
        if "approval" in found:
            found["approval"] = tuple(dict.fromkeys(map(str, self.approval)))
        return found


class RobotSettingsOut(_Out):
    name: str
    owner: str
    command: dict[str, str]
    approve: str
    release: str
    approval: tuple[str, ...]
    approve_own: bool
    camera_role: Role
    camera_days: int
    closed: tuple[dict[str, Any], ...]


# -------------------------------------------------------------------- moderation and the log
class ReasonIn(_In):
    reason: Line = ""


class LockIn(ReasonIn):
    locked: bool


class MoveIn(ReasonIn):
    board_id: Annotated[str, Field(max_length=32)]


class HiddenOut(_Out):
    """A post as moderators see it: its text even if it is hidden, and who hid it."""

    post: PostOut
    versions: tuple[str, ...] = Field(description="earlier versions, oldest first")
    hidden_by: str


class AuditOut(_Out):
    id: str
    at: Time
    actor: str
    action: str
    target: str
    detail: dict[str, Any]


# -------------------------------------------------------------------- records to models
def token_out(t: management.Token) -> TokenOut:
    revoked = time_out(t.revoked_at) if t.revoked_at else None
    return TokenOut(
        id=t.id,
        account=t.account,
        label=t.label,
        scopes=t.scopes,
        created_at=time_out(t.created_at),
        revoked_at=revoked,
    )


def invite_out(i: management.Invite) -> InviteOut:
    return InviteOut(
        id=i.id, role=i.role, commands_simulated=i.commands_simulated, left=i.left, expires_at=time_out(i.expires_at)
    )


def board_rights(b: records.Board) -> BoardRights:
    roles = {"read_role": b.read_role, "post_role": b.post_role, "command_role": b.command_role}
    return BoardRights(id=b.id, name=b.name, description=b.description, **roles)


def robot_settings_out(name: str, kept: RobotSettings) -> RobotSettingsOut:
    return RobotSettingsOut(
        name=name,
        owner=kept.owner,
        command=dict(kept.command),
        approve=kept.approve,
        release=kept.release,
        approval=kept.approval,
        approve_own=kept.approve_own,
        camera_role=kept.camera_role,
        camera_days=kept.camera_days,
        closed=tuple(map(closed_out, kept.closed)),
    )


def audit_out(e: audit.Entry) -> AuditOut:
    return AuditOut(id=e.id, at=time_out(e.at), actor=e.actor, action=e.action, target=e.target, detail=e.detail)
