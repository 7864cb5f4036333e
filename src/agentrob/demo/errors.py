"""The error of the demo."""

from agentrob.errors import AgentRobError


class DemoError(AgentRobError):
    """The demo cannot start or continue."""
