"""The exceptions of AgentRob.

    AgentRobError
    ├── ConfigError          a setting is invalid; the message says what is valid
    ├── ForumError           a forum could not be read or written
    │   ├── ForumUnreachable     the forum did not answer; retry later
    │   ├── ForumDenied          not signed in, or not allowed
    │   ├── ForumLimited         rate limit; `retry_after_s` says how long to wait
    │   ├── ForumNotFound        no such board, topic or post
    │   ├── ForumMalformed       the response does not match the forum's API
    │   └── ForumUnoffered       the forum does not have this feature
    ├── McpError             an MCP server could not be used
    ├── MindError            a mind could not answer
    ├── RobotError           a robot or its driver could not be used
    │   ├── RobotUnreachable     no driver, no state, or no answer
    │   ├── RobotBusy            another client or process holds the robot
    │   ├── LeaseLost            the lease lapsed or was never granted
    │   └── Fenced               another worker has taken the robot
    ├── ImageStoreError      a picture could not be stored
    ├── SimError             the simulated world cannot be built or run
    ├── HttpError            an HTTP server rejects the request; carries the status
    │   ├── BoardError           the embedded forum rejects it
    │   └── ServiceError         the agent's HTTP service rejects it
    └── JournalError         the journal cannot be opened or trusted
        └── IllegalTransition    a command would enter a state that cannot follow its own

Refusals, failed steps and posts that are not understood are results (see `model`), not errors.
"""

from __future__ import annotations


class AgentRobError(Exception):
    """Base class of all errors. The message is one sentence that a user can act on."""


class ConfigError(AgentRobError):
    """A setting is invalid."""


class ForumError(AgentRobError):
    """A forum could not be read or written."""


class ForumUnreachable(ForumError):
    """The forum did not answer."""


class ForumDenied(ForumError):
    """Not signed in, or not allowed."""


class ForumLimited(ForumError):
    """Too many requests."""

    def __init__(self, message: str, retry_after_s: float) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s


class ForumNotFound(ForumError):
    """No such board, topic or post."""


class ForumMalformed(ForumError):
    """The response does not match the forum's API."""


class ForumUnoffered(ForumError):
    """The forum does not have this feature; retrying does not help."""


class McpError(AgentRobError):
    """An MCP server could not be started, reached or understood."""


class MindError(AgentRobError):
    """A mind could not answer."""


class ImageStoreError(AgentRobError):
    """A picture could not be stored in the image store."""


class RobotError(AgentRobError):
    """A robot or its driver could not be used."""


class RobotUnreachable(RobotError):
    """No driver, no state or no answer."""


class RobotBusy(RobotError):
    """Another client or process holds the robot."""


class LeaseLost(RobotError):
    """The lease that allows motion lapsed or was never granted.

    `why` is a stable word (`stop`, `halt`, `shutdown`, `fenced`, `lease_lapsed`). `by` is the name that the client who
    stopped the robot gave: one line of at most 100 characters of untrusted text, or empty.
    """

    def __init__(self, message: str, why: str = "lease_lapsed", by: str = "") -> None:
        super().__init__(message)
        self.why = why
        self.by = by


class Fenced(RobotError):
    """Another worker has taken the robot, with a larger fencing number; this one may not move it any more."""


class SimError(AgentRobError):
    """The simulated world cannot be built or run."""


class HttpError(AgentRobError):
    """An HTTP server rejects the request.

    `status` is the HTTP status, `code` a stable word for programs; `hint` says what is valid.
    """

    def __init__(
        self, status: int, code: str, message: str, hint: str = "", retry_after_s: float | None = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.code = code
        self.hint = hint
        self.retry_after_s = retry_after_s


class BoardError(HttpError):
    """The embedded forum rejects the request."""


class ServiceError(HttpError):
    """The agent's HTTP service rejects the request."""


class JournalError(AgentRobError):
    """The journal cannot be opened or trusted."""


class JournalHeld(JournalError):
    """Another agent of this robot holds its journal; it can be taken when that one has ended."""


class IllegalTransition(JournalError):
    """A command would enter a state that cannot follow the one it is in (`model.lifecycle.TRANSITIONS`)."""
