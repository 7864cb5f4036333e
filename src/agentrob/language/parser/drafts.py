"""Drafts of steps: the words about each step and the rest of its sentence, collected but not yet judged."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from agentrob.language.parser.lexicon import Token, TokenKind
from agentrob.language.routines import Routine
from agentrob.model import PHOTO, BaseMotion, Direction
from agentrob.model.operations.built_in import named
from agentrob.model.operations.declaration import Value

#: The name of an operation, or a routine.
Action = str | Routine


def actions_of(value: object) -> tuple[Action, ...]:
    """Return what a token of the kind OP names, the best first."""
    routines = frozenset(Routine)
    return tuple(Routine(word) if word in routines else named(word) for word in str(value).split("/"))


@dataclass
class Draft:
    """The words about one step.

    `verb` is MOVE, TURN, OP, AGAIN, BEYOND, or None if only a direction or an amount was said.
    """

    start: int
    end: int
    verb: TokenKind | None = None
    op: Action | None = None
    or_else: tuple[Action, ...] = ()  # alternatives for a robot that lacks this gesture
    direction: Direction | None = None
    amount: Token | None = None
    arguments: dict[str, Value] = field(default_factory=dict)  # of an operation that the robot declares
    speed_mps: float | None = None
    sideways: bool = False  # "strafe": left or right must be said
    gait: bool = False  # "run": says how to walk
    slow: bool = False
    slower: bool = False
    faster: bool = False
    vague: bool = False
    times: int = 1
    counted: bool = False
    more: bool = False  # this many times in addition to the first
    further: bool = False  # "another photo": in addition to the one before
    only: BaseMotion | None = None  # 再转一次: repeats a plan of only this motion
    ahead: bool = False  # "three times: …"
    each: TokenKind | None = None  # a picture after each MOVE, TURN or (END) anything
    bare_picture: bool = False
    scene: bool = False  # "show me what you see": its subject is said
    view: Direction | None = None  # of a picture: the side that it should show, if not ahead
    watched: bool = False  # 让我看看: a picture, or a wish to watch the step
    back: bool = False  # the way back
    beyond: str = ""  # eyes, hands, path, wait: the ability that is missing
    place: bool = False  # the destination is in unknown words
    spun: bool = False  # "spin around": once is half a turn, three times are three turns
    after_and: bool = False  # "and" or "then" stands before it
    paired: bool = False  # only "and" stands between it and the draft before: "sit and stand"
    hesitant: bool = False  # after an "uh"
    fixes: Token | None = None  # replaces the draft before
    unknown: list[tuple[int, int]] = field(default_factory=list)
    odd_number: bool = False
    again: bool = False  # "again" stands after it
    stop_word: bool = False
    waits: bool = False  # a stop word that is only valid at the end
    joined: bool = False  # not separated from the draft before
    closed: bool = False

    @property
    def is_motion(self) -> bool:
        return self.verb in (TokenKind.MOVE, TokenKind.TURN) or (
            self.verb is None and (self.direction is not None or self.amount is not None)
        )

    @property
    def motion(self) -> TokenKind | None:
        """Whether it is a walk or a turn, as far as its words tell."""
        turns = self.amount is not None and self.amount.kind is TokenKind.ANGLE
        return (self.verb or (TokenKind.TURN if turns else TokenKind.MOVE)) if self.is_motion else None

    @property
    def is_picture(self) -> bool:
        return self.bare_picture or self.op is PHOTO

    @property
    def takes_manner(self) -> bool:
        """Whether a speed or an amount can apply to it."""
        return self.is_motion or self.verb is TokenKind.AGAIN or isinstance(self.op, Routine)

    @property
    def lacks_size(self) -> bool:
        """Whether it is a square, a circle or a patrol whose size may follow."""
        return isinstance(self.op, Routine) and self.op.has_size and self.amount is None and not self.counted

    @property
    def vaguely_begun(self) -> bool:
        """Whether it has only words or a direction so far, which may belong to what follows."""
        return self.verb is None and self.amount is None and not (self.bare_picture or self.stop_word)

    @property
    def is_action(self) -> bool:
        """Whether it names an action, and not only words, a place or an amount."""
        return bool(self.verb or self.bare_picture or (self.direction and self.amount))

    @property
    def empty(self) -> bool:
        return not (self.verb or self.direction or self.amount or self.unknown or self.bare_picture or self.stop_word)

    @property
    def bare(self) -> bool:
        """Whether it is only a verb."""
        return not (self.direction or self.amount or self.unknown or self.slow or self.vague or self.counted)


class RemarkKind(StrEnum):
    """The kind of a stretch of a sentence that is not a step."""

    REMARK = "remark"  # "I am bored"
    QUESTION = "question"  # "what do you see"
    WISH = "wish"  # "tell me the temperature", "report", 给他…
    HELP = "help"
    DENIED = "denied"  # "do not wave"


@dataclass
class Remark:
    """A stretch of a sentence that is not a step.

    `actions`: one of its clauses begins with an action, which may be requested ("so that I can see and turn left");
    `beyond`: one begins with words that may be part of a request or are beyond the robots' abilities ("… and sing");
    `unknown`: a denial has words that the grammar does not know ("don't walk past the door").
    """

    kind: RemarkKind
    start: int
    end: int
    actions: bool = False
    beyond: bool = False
    unknown: bool = False


@dataclass
class Sentence:
    """Everything between two sentence ends; each clause is in `drafts`, in `remarks`, or sets a field below."""

    start: int = 0
    end: int = 0
    drafts: list[Draft] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    reported_at: int | None = None  # where the first word of a report stands
    asked: bool = False
    requested: bool = False
    report: bool = False
    condition: Token | None = None
    denial_unclear: Token | None = None  # a "not" whose reach is unclear
    denied_ops: set[Action] = field(default_factory=set)  # gestures and pictures that are denied
    denied_motions: list[Draft] = field(default_factory=list)  # walks and turns that are denied
    denial_joined: bool = False  # … because an "and" stands within it
    stays: Token | None = None  # "stay where you are": no walk at all
    fix_unclear: Token | None = None  # "no wait", and nothing after it
    times_unclear: Token | None = None  # "walk and turn, twice": which of them
    talked: bool = False
    somebody: Token | None = None  # 走在你前面: who is near the robot, not said by name
    somebody_does: bool = False  # … and an action after it, perhaps a command
    question: bool = False
    cancelled: Token | None = None  # "never mind"
    denied: bool = False
    help: bool = False
    status: bool = False
    status_asked: bool = False  # a word of the robot's state, which counts in a question
    greeted: bool = False
    thanked: bool = False
    assents: bool = False  # "yes", "please"
    sent: Token | None = None  # "post it": a picture, when one is taken

    @property
    def wants_status(self) -> bool:
        return self.status or (self.status_asked and (self.asked or self.question))

    @property
    def says_nothing(self) -> bool:
        """Whether it is only politeness."""
        said = self.drafts or self.talked or self.report or self.condition or self.denied or self.cancelled
        return not (said or self.help or self.wants_status)
