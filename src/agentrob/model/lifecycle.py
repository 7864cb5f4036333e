"""The life of a command: its states, which state may follow which, and why a command ends before it is done.

Status cards, records, command pages, the journal, the service and its metrics all use these words; their values are
written to databases and sent to other processes, so a value never changes.
"""

from __future__ import annotations

from enum import StrEnum

from agentrob.errors import IllegalTransition


class CommandState(StrEnum):
    """How far a command is, or how it ended."""

    POSTED = "posted"  # on the forum; the robot's agent has not read it yet
    SEEN = "seen"  # claimed by the robot's agent
    WAITING = "waiting"  # for somebody's approval
    QUEUED = "queued"  # for its turn
    RUNNING = "running"  # its motion has begun
    # final states of a command
    DONE = "done"
    FAILED = "failed"
    REFUSED = "refused"
    ASKS_BACK = "asks_back"  # the reply is a question
    STOPPED = "stopped"  # by a person
    INTERRUPTED = "interrupted"  # begun, and how far it went may not be known
    CANCELLED = "cancelled"  # before it was done, by something other than a stop
    EXPIRED = "expired"
    ANSWERED = "answered"  # it asked for nothing that moves
    HANDLED_ELSEWHERE = "handled_elsewhere"  # another agent of the same account reported its end
    # final states of a post that is not a command
    STOP = "stop"
    NOTHING = "nothing"

    @property
    def is_final(self) -> bool:
        """Whether no other state follows."""
        return not TRANSITIONS[self]

    @property
    def label(self) -> str:
        """The state as English words for people."""
        return _LABELS.get(self, self.value.replace("_", " "))


_S = CommandState
_LABELS = {_S.WAITING: "waits for approval"}
#: A claimed command can end in each of these states at any moment; a stop must never wait for the right state.
_ENDS = frozenset({_S.FAILED, _S.REFUSED, _S.STOPPED, _S.INTERRUPTED, _S.CANCELLED, _S.HANDLED_ELSEWHERE})
#: The states that may follow each state. A command that waits for approval cannot run: it must leave `WAITING` first.
#: A post has a place in the queue while the mind still reads it, so the ends of `SEEN` can also follow `QUEUED`.
TRANSITIONS: dict[CommandState, frozenset[CommandState]] = {
    _S.POSTED: frozenset({_S.SEEN, _S.FAILED, _S.STOP, _S.NOTHING}),
    _S.SEEN: _ENDS | {_S.WAITING, _S.QUEUED, _S.RUNNING, _S.ASKS_BACK, _S.ANSWERED, _S.EXPIRED, _S.NOTHING},
    _S.WAITING: _ENDS | {_S.QUEUED, _S.EXPIRED},
    _S.QUEUED: _ENDS | {_S.WAITING, _S.RUNNING, _S.ASKS_BACK, _S.ANSWERED, _S.EXPIRED},
    _S.RUNNING: _ENDS | {_S.DONE},
} | {
    state: frozenset()
    for state in (*_ENDS, _S.DONE, _S.ASKS_BACK, _S.EXPIRED, _S.ANSWERED, _S.STOP, _S.NOTHING)
}  # fmt: skip
#: The states after which no other follows.
FINAL_STATES = frozenset(state for state, following in TRANSITIONS.items() if not following)
#: The states of a command that its robot's agent works on.
ACTIVE_STATES = frozenset(TRANSITIONS) - FINAL_STATES - {_S.POSTED}
#: The states that a status card can show.
CARD_STATES = frozenset(TRANSITIONS) - {_S.POSTED, _S.STOP, _S.NOTHING, _S.HANDLED_ELSEWHERE}
#: Words of earlier versions that a database may still hold.
_EARLIER = {"answered before": _S.HANDLED_ELSEWHERE, "replaced": _S.CANCELLED}


def check_transition(before: CommandState, after: CommandState) -> None:
    """Raise `IllegalTransition` unless `after` may follow `before`. Entering the same state again is allowed."""
    if after is not before and after not in TRANSITIONS[before]:
        valid = ", ".join(sorted(TRANSITIONS[before])) or "none, it is final"
        raise IllegalTransition(f"a command cannot go from '{before}' to '{after}'; valid: {valid}")


def stored_state(text: str) -> CommandState:
    """The state that a database or record holds, also one of an earlier version. `ValueError` for any other word."""
    return _EARLIER.get(text) or CommandState(text)


def is_final_word(text: str) -> bool:
    """Whether a word, perhaps written by somebody else, is a final state."""
    return text in FINAL_STATES


class EndReason(StrEnum):
    """Why a command was ended from outside, before its motion or during it."""

    STOP = "stop"
    SHUTDOWN = "shutdown"  # the agent is being ended
    STALE = "stale"  # the post was too old when the agent read it
    EXPIRED = "expired"  # it waited for its turn for too long
    LAPSED = "lapsed"  # it was not approved in time
    DENIED = "denied"  # its approval was denied
    TAKEN_BACK = "taken_back"  # by its author
    EDITED = "edited"
    REMOVED = "removed"
    THREAD = "thread"  # its post was moved to another thread
    RELEASE = "release"  # posted before its robot was released
    CLOCK = "clock"  # the forum's clock was set: it may have been posted before a stop
    REPLACED = "replaced"  # the forum was replaced by another
    MISSED = "missed"  # a run of a schedule that could not begin in time
    OVERLAP = "overlap"  # a run of a schedule, before the one before it had ended
    DEPENDENCY = "dependency"  # a part of the same post for which it waited was not done, or was stopped
    LEFT = "left"  # another robot does this part of the post
    BEFORE = "before"  # cancelled before it began; the reason is not known

    @property
    def state_before_motion(self) -> CommandState:
        """The final state of a command that this ended before its motion began."""
        return _BEFORE_MOTION.get(self, _S.CANCELLED)

    @property
    def state_in_motion(self) -> CommandState:
        """The final state of a command that this ended when its motion had begun."""
        return _IN_MOTION.get(self, _S.CANCELLED)


_BEFORE_MOTION = {
    EndReason.STALE: _S.EXPIRED,
    EndReason.EXPIRED: _S.EXPIRED,
    EndReason.LAPSED: _S.EXPIRED,
    EndReason.MISSED: _S.EXPIRED,
    EndReason.DENIED: _S.REFUSED,
}
_IN_MOTION = {EndReason.STOP: _S.STOPPED, EndReason.SHUTDOWN: _S.INTERRUPTED}


def stored_reason(text: str) -> EndReason:
    """The reason that a database holds; `BEFORE` for a word of a newer version: the command stays ended."""
    return EndReason(text) if text in frozenset(EndReason) else EndReason.BEFORE
