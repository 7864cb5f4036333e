"""The arguments of each tool: one model per tool, whose docstring is the tool's description."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from agentrob.model import AccountKind, Role

#: No NUL, which not every forum can store, and at least one visible character.
_SAFE = r"^[^\x00]*[^\x00\s][^\x00]*$"
Id = Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"^[^\x00-\x20\x7f]+$")]
Cursor = Annotated[str | None, Field(max_length=2_000, description="next or more of an answer")]
Body = Annotated[str, StringConstraints(pattern=_SAFE, max_length=60_000), Field(description="Markdown")]
Title = Annotated[
    str, StringConstraints(pattern=r"^[^\x00-\x1f\x7f]*[^\s\x00-\x1f\x7f][^\x00-\x1f\x7f]*$", max_length=200)
]
Key = Annotated[
    str | None,
    Field(pattern=r"^[!-~]{1,150}$", description="idempotency key"),
]
Status = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,31}$", description="e.g. asking, working, done, failed")]
Images = Annotated[list[Id], Field(max_length=8, description="media_id from upload_media")]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]{0,63}$")]


class Arguments(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, hide_input_in_errors=True)


class GetManual(Arguments):
    """How these tools work together, with examples; or about one tool, if named."""

    tool: Annotated[str | None, Field(max_length=64)] = None


class ListBoards(Arguments):
    """The boards (categories) of the forum."""

    cursor: Cursor = None
    limit: Annotated[int, Field(ge=1, le=100)] = 20


class ListPosts(Arguments):
    """The topics of a board, latest activity first."""

    board_id: Id
    cursor: Cursor = None
    limit: Annotated[int, Field(ge=1, le=100)] = 10


class GetTopic(Arguments):
    """The posts of a topic, oldest first. Long bodies are cut: `more` of a post continues it."""

    topic_id: Id
    cursor: Cursor = None
    limit: Annotated[int, Field(ge=1, le=100)] = 10
    max_chars: Annotated[int, Field(ge=100, le=70_000, description="of each body")] = 1_500


class CreateTopic(Arguments):
    """Start a topic. Mention a robot (@name) on its board to ask it for something."""

    board_id: Id
    title: Title
    body: Body
    status: Status = "posted"
    images: Images = []
    key: Key = None


class ReplyToTopic(Arguments):
    """Reply in a topic; reply_to is the post that you answer."""

    topic_id: Id
    body: Body
    reply_to: Id | None = None
    status: Status = "posted"
    images: Images = []
    card: Annotated[dict[str, Any] | None, Field(description="state of a command; robot agents only")] = None
    key: Key = None


class EditPost(Arguments):
    """Replace the text of your own post; images are added."""

    post_id: Id
    body: Body
    status: Status = "edited"
    images: Images = []
    card: dict[str, Any] | None = None
    key: Key = None


class LoginAccount(Arguments):
    """Act as another account from now on: a configured one, one registered here, or any other with its token."""

    account: Name
    token: Annotated[str | None, Field(max_length=500, description="forum token; never put it into a post")] = None


class RegisterAccount(Arguments):
    """Create an account; login_account can then switch to it."""

    account: Name
    kind: Annotated[AccountKind, Field(strict=False)] = AccountKind.HUMAN
    display_name: Annotated[str, Field(max_length=64)] = ""


class SearchPosts(Arguments):
    """Posts that contain all words, newest first."""

    query: Annotated[str, StringConstraints(pattern=_SAFE, max_length=200)]
    board_id: Id | None = None
    cursor: Cursor = None
    limit: Annotated[int, Field(ge=1, le=50)] = 10
    max_chars: Annotated[int, Field(ge=100, le=70_000)] = 400


class SearchPostsByMeaning(SearchPosts):
    """Posts that contain all words, newest first; with mode `meaning`: posts that say something similar, in any
    language, best match first."""

    mode: Literal["words", "meaning"] = "words"


class UploadMedia(Arguments):
    """Upload a picture (JPEG, PNG, WebP, GIF; at most 8 MiB) for `images` of a later write."""

    data: Annotated[str, Field(max_length=11_500_000, description="base64")]


class SubscribeTopic(Arguments):
    """Get new posts of a topic: pushed as updates of its resource, and returned here after waiting up to wait_s."""

    topic_id: Id
    after: Annotated[str | None, Field(max_length=100, description="`after` of the answer before")] = None
    wait_s: Annotated[float, Field(ge=0, le=60, allow_inf_nan=False)] = 0.0


class ListNotifications(Arguments):
    """Posts that mention this account or reply to it, newest first."""

    cursor: Cursor = None
    limit: Annotated[int, Field(ge=1, le=50)] = 10


class ManagePermissions(Arguments):
    """Change what an account may do: its role, or suspend it. For admins."""

    account: Name
    role: Annotated[Role | None, Field(strict=False)] = None
    suspended: bool | None = None


def input_schema(model: type[Arguments]) -> dict[str, Any]:
    """The JSON Schema of a tool's arguments, without parts that only cost tokens."""
    return _lean(model.model_json_schema(), model.model_json_schema().get("$defs", {}), top=True)


def _lean(schema: dict[str, Any], definitions: dict[str, Any], top: bool = False) -> dict[str, Any]:
    if "$ref" in schema:
        named = definitions[schema["$ref"].rpartition("/")[2]]
        schema = {**{k: v for k, v in named.items() if k != "description"}, **schema}
    if choices := [c for c in schema.get("anyOf", ()) if c.get("type") != "null"]:
        schema = {**schema, **choices[0]} if len(choices) == 1 else schema
        return _lean({k: v for k, v in schema.items() if k != "anyOf"}, definitions)
    out: dict[str, Any] = {}
    for name, value in schema.items():
        if name in ("title", "$defs", "$ref") or (name == "default" and value in (None, "", [])):
            continue
        if name == "description" and top:
            continue
        if name in ("minLength", "maxLength") or (name == "pattern" and ("x00" in value or "!-~" in value)):
            continue  # ordinary calls respect these bounds; others get them in the error message
        if (name, value) in (("minimum", 1), ("additionalProperties", True)):
            continue
        if name == "properties":
            out[name] = {k: _lean(v, definitions) for k, v in value.items()}
        elif name == "items":
            out[name] = _lean(value, definitions)
        else:
            out[name] = value
    return out
