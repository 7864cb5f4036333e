"""Every error that AgentRob raises on purpose.

    AgentRobError
    ├── ConfigError          a setting is wrong; the message says what would be valid
    ├── ForumError           a forum could not be read or written
    │   ├── ForumUnreachable     no answer, try again later
    │   ├── ForumDenied          signed out, or not allowed
    │   ├── ForumLimited         too fast; `retry_after_s` says when again
    │   ├── ForumNotFound        no such board, topic or post
    │   ├── ForumMalformed       an answer that is not as its API says
    │   └── ForumUnoffered       this forum does not have that at all
    ├── McpError             an MCP server could not be used
    ├── MindError            a mind could not answer
    ├── RobotError           a robot or its driver could not be used
    │   ├── RobotUnreachable     no driver, no state, no answer
    │   ├── RobotBusy            somebody else holds the robot or its driver
    │   └── LeaseLost            the holder's lease lapsed or was never given
    ├── ImageStoreError      a picture could not be kept where the configuration says
    ├── SimError             the simulated world cannot be built or run
    ├── BoardError           the embedded forum cannot do this; carries an HTTP status
    ├── ServiceError         the agent's HTTP service cannot do this; carries an HTTP status
    └── JournalError         the journal cannot be opened or trusted
        └── IllegalTransition    a command would enter a state that cannot follow its own

A refusal, a failed step, a post that is not understood are results (see `model`), not errors.
"""

from __future__ import annotations


class AgentRobError(Exception):
    """Root of all. The text is one sentence that a user can act on."""


class ConfigError(AgentRobError):
    """A setting is wrong."""


class ForumError(AgentRobError):
    """A forum could not be read or written."""


class ForumUnreachable(ForumError):
    """The forum gave no answer."""


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
    """The forum answered what is not in its API."""


class ForumUnoffered(ForumError):
    """Not offered by this forum: asking again does not help."""


class McpError(AgentRobError):
    """An MCP server could not be started, reached or understood."""


class MindError(AgentRobError):
    """A mind could not answer."""


class ImageStoreError(AgentRobError):
    """A picture could not be kept in the image store."""


class RobotError(AgentRobError):
    """A robot or its driver could not be used."""


class RobotUnreachable(RobotError):
    """No driver, no state or no answer."""


class RobotBusy(RobotError):
    """Somebody else holds the robot or its driver."""


class LeaseLost(RobotError):
    """The lease that allows motion lapsed or was never given.

    `why` is a stable word (`stop`, `halt`, `shutdown`, `lease_lapsed`). `by` is who stopped or halted, as they called
    themselves: at most 100 characters of untrusted text in one line, empty when nobody did.
    """

    def __init__(self, message: str, why: str = "lease_lapsed", by: str = "") -> None:
        super().__init__(message)
        self.why = why
        self.by = by


class SimError(AgentRobError):
    """The simulated world cannot be built or run."""


class BoardError(AgentRobError):
    """The embedded forum cannot do this.

    `status` is the HTTP status, `code` a stable word for programs, `hint` what would be valid.
    """

    def __init__(
        self, status: int, code: str, message: str, hint: str = "", retry_after_s: float | None = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.code = code
        self.hint = hint
        self.retry_after_s = retry_after_s


class ServiceError(AgentRobError):
    """The agent's HTTP service cannot do this; fields as those of `BoardError`."""

    def __init__(
        self, status: int, code: str, message: str, hint: str = "", retry_after_s: float | None = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.code = code
        self.hint = hint
        self.retry_after_s = retry_after_s


class JournalError(AgentRobError):
    """The journal cannot be opened or trusted."""


class IllegalTransition(JournalError):
    """A command would enter a state that cannot follow the one it is in (`model.lifecycle.TRANSITIONS`)."""
