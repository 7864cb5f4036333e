"""Laws 4 to 6, 13 and 14 under any order of events.

A state machine posts, edits, stops, suspends and restarts at random while commands are held at gates, and a ledger
outside the agent records what moved.
"""

from __future__ import annotations

import asyncio
import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from agentrob.agent import agent as turn
from agentrob.agent.agent import RobotAgent
from agentrob.agent.intake import event_stream
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import Account, AccountKind, EventKind, Post, Primitive, Role
from agentrob.robots.driver.fencing import FencingNumbers
from tests.agent.agent_scene import FINAL, ROBOT, robot_settings
from tests.agent.laws.machine_scene import TIME_SCALE, GatedClient, GatedMind, Gates, Stand, robot_stand
from tests.agent.store.journal_store import JournalStore, open_journal
from tests.sizes import size

pytestmark = pytest.mark.usefixtures("database")

#: How often and at most how many times to poll whether the agent has come to rest. Polls are counted, not seconds, so
#: that a busy machine, which runs the process rarely, does not fail the test.
LOOK_S, MOST_LOOKS = 0.005, 3000
#: The age limit of law 5, and a clock step that exceeds it.
FRESH_S, LATER_S = 120.0, 130.0
#: More would exceed the ten minutes in which an agent without a journal looks for its claims.
MOST_LATER = 3
WIDE_DEG, NARROW_DEG = 360.0, 90.0
ACCOUNTS = {
    "alice": (AccountKind.HUMAN, Role.OPERATOR),
    "carol": (AccountKind.HUMAN, Role.OPERATOR),
    "pilot": (AccountKind.COMMANDING_AGENT, Role.OPERATOR),
    "bob": (AccountKind.HUMAN, Role.MEMBER),
    "rover": (AccountKind.ROBOT_AGENT, Role.OPERATOR),
    "watcher": (AccountKind.MONITORING_AGENT, Role.OPERATOR),
}
OBEYED = frozenset({AccountKind.HUMAN, AccountKind.COMMANDING_AGENT})
Step = tuple[str, float]
#: Who posts commands: mostly accounts that may, so that robots move.
askers = st.sampled_from(["alice", "alice", "carol", "carol", "pilot", *ACCOUNTS])
numbers = st.integers(0, 5)
changes = st.sampled_from(
    ["edit", "edit into a stop", "remove", "suspend", "right", "limit", "kept", "deleted", "mention", "bare", "button"]
)
rarely = st.sampled_from([False, False, False, True])
#: Who may approve, where every command needs an approval.
MODERATOR = "mod"


@dataclass
class LedgerEntry:
    """The ledger's entry for one post: the steps of its first text, and why none of them may begin any more."""

    post_id: str
    author: str
    steps: tuple[Step, ...]
    posted_at: datetime
    never: set[str] = field(default_factory=set)
    heard: bool = False
    due: bool = False
    approved: bool = False


class Laws(RuleBasedStateMachine):
    """One forum, one robot, one agent at a time.

    Every step of every text is a turn by a different angle, so that the robot's motion identifies the text. With
    `approval` each command needs one.
    """

    def __init__(self, stand: Stand, folder: Path, approval: bool = False) -> None:
        super().__init__()
        self.stand, self.folder, self.approval = stand, folder, approval
        folder.mkdir()
        # On PostgreSQL each run has a database of its own, and a driver remembers the workers of 32.
        stand.driver.leases.numbers = FencingNumbers()
        self.runner = asyncio.Runner()
        self.world = MemoryForum.world()
        self.world.sign_in(MODERATOR, role=Role.MODERATOR)
        for name, (kind, role) in {**ACCOUNTS, ROBOT: (AccountKind.ROBOT_AGENT, Role.MEMBER)}.items():
            self.world.sign_in(name, kind=kind, role=role)
        self.gates = Gates()
        stand.robot.gate, stand.robot.time_scale = self.gates.body, TIME_SCALE
        stand.robot.on_step, stand.robot.on_motion = self._passed_the_guard, self._moved
        self.limit_deg, self.halted, self.later = WIDE_DEG, False, 0
        stand.limit(WIDE_DEG)
        self.entry: list[LedgerEntry] = []
        self.of_step: dict[Step, LedgerEntry] = {}
        self.forbidden_text: dict[Step, str] = {}
        self.moved: Counter[Step] = Counter()
        self.wrong: list[str] = []
        self.stopped_when_sent = 0
        self.small, self.large = iter(range(11, 90)), iter(range(100, 140))
        self.keys = (f"k{n}" for n in itertools.count())
        self.missed: list[tuple[str, datetime]] = []
        self.copies: list[dict[str, Any]] = []
        self.agent: RobotAgent | None = None
        self.serving: asyncio.Task[None] | None = None
        forum = self.world.sign_in("bob")
        for title in ("One", "Two"):
            self._run(forum.create_topic("robots", title, "Here we talk.", key=next(self.keys)))
        self._begin()

    # ---------------------------------------------------------------- rules: something between a post and its motion
    @initialize(rounds=st.lists(st.tuples(st.sampled_from([0, 1, 1, 2, 3]), changes), min_size=4, max_size=4))
    def change_things_on_the_way(self, rounds: list[tuple[int, str]]) -> None:
        for times, change in rounds:
            self.post("alice", "1", change == "limit", 1, 1 if self.approval else times)
            if self.approval:
                self.say(MODERATOR, "approve", 0)
                self.go_on(times)
            self._change(change)
            self.go_on(4)
            self.world.suspend("alice", False)
            self.world.set_role("alice", Role.OPERATOR)
            self.change_the_limit(WIDE_DEG)

    def _change(self, what: str) -> None:
        match what:
            case "edit":
                self.edit(0)
            case "edit into a stop":
                self.edit_into_a_stop(0)
            case "remove":
                self.remove(0)
            case "suspend":
                self.suspend("alice", True)
            case "right":
                self.change_the_right("alice", Role.MEMBER)
            case "limit":
                self.change_the_limit(NARROW_DEG)
            case "kept" | "deleted":
                self.restart(what, 0)
            case _:
                self.stop("bob", what, 0)

    # ---------------------------------------------------------------- rules: what people write
    @rule(author=askers, topic=st.sampled_from("12"), large=rarely, steps=st.integers(1, 2), times=st.integers(0, 4))
    def post(self, author: str, topic: str, large: bool, steps: int, times: int) -> None:
        if (new := self._steps(steps, large)) is not None:
            self._ask(author, topic, new)
            self.go_on(times)

    @precondition(lambda self: self.entry)
    @rule(n=numbers)
    def edit(self, n: int) -> None:
        new, entry = self._steps(1, False), self._pick(n)
        if new is not None and self._may_write(entry):
            self.forbidden_text.update(dict.fromkeys(new, f"the text into which {entry.post_id} was edited"))
            self._amend(entry, "edited", lambda: self._edit(entry, _words(new)))

    @precondition(lambda self: self.entry)
    @rule(n=numbers)
    def edit_into_a_stop(self, n: int) -> None:
        entry = self._pick(n)
        if self._may_write(entry):
            self._amend(entry, "edited", lambda: self._edit(entry, f"@{ROBOT} stop"))
            if self.world.accounts[entry.author].kind in OBEYED:
                self._stopped(entry.post_id)

    @precondition(lambda self: self.entry)
    @rule(n=numbers)
    def remove(self, n: int) -> None:
        entry = self._pick(n)
        if not self.world.posts[entry.post_id].removed:
            self._amend(entry, "removed", lambda: self.world.remove(entry.post_id))

    @rule(
        by=st.sampled_from(list(ACCOUNTS)),
        how=st.sampled_from(["mention", "bare", "button", "mention", "bare", "halt"]),
        n=numbers,
    )
    def stop(self, by: str, how: str, n: int) -> None:
        account = self.world.accounts[by]
        topic = self.world.posts[self._pick(n).post_id].topic_id if self.entry else "1"
        counts = account.kind in OBEYED and not account.suspended
        if how == "bare":
            counts = counts and self.agent is not None and topic in self.agent.queue.topics()
        post_id = ""
        if how == "button":
            self.world.emit(EventKind.ROBOT_STOP, robot=ROBOT, account=account)
        else:
            text = {"mention": f"@{ROBOT} stop", "bare": "stop", "halt": f"@{ROBOT} emergency stop"}[how]
            post_id = self._write(by, topic, text).id
        if counts:
            self._stopped(post_id)
        self._settle()
        if counts and how == "halt" and self.agent is not None:
            self.halted = True

    @precondition(lambda self: self.approval and self.entry)
    @rule(
        by=st.sampled_from([MODERATOR, MODERATOR, MODERATOR, *ACCOUNTS]),
        word=st.sampled_from(["approve", "approve", "approve", "deny"]),
        n=numbers,
    )
    def say(self, by: str, word: str, n: int) -> None:
        """Approve or deny a command, whether it waits for that or not."""
        entry = self._pick(n)
        topic = self.world.topics[self.world.posts[entry.post_id].topic_id]
        waits = self.agent is not None and entry in self._waiting()
        text = f"@{ROBOT} {word}"
        self.world.add_post(topic, by, text, next(self.keys), (), reply_to=entry.post_id)
        if by == MODERATOR:
            entry.approved = entry.approved or word == "approve"
            entry.never |= {"denied"} if waits and word == "deny" else set()
        self._settle()

    def _waiting(self) -> list[LedgerEntry]:
        """Return the post that shows that it waits for an approval."""
        shown = {p.reply_to for p in self.world.posts.values() if p.card is not None and p.card.state == "waiting"}
        return [entry for entry in self.entry if entry.post_id in shown]

    # ---------------------------------------------------------------- rules: what moderators and owners do
    @rule(name=st.sampled_from(["alice", "pilot"]), suspended=rarely)
    def suspend(self, name: str, suspended: bool) -> None:
        self.world.suspend(name, suspended)

    @rule(name=st.sampled_from(["alice", "pilot"]), role=st.sampled_from([Role.OPERATOR, Role.OPERATOR, Role.MEMBER]))
    def change_the_right(self, name: str, role: Role) -> None:
        self.world.set_role(name, role)

    @rule(limit_deg=st.sampled_from([NARROW_DEG, WIDE_DEG]))
    def change_the_limit(self, limit_deg: float) -> None:
        self.limit_deg = limit_deg
        self.stand.limit(limit_deg)

    @precondition(lambda self: self.halted)
    @rule()
    def release(self) -> None:
        self.halted = False
        self.stand.driver.release("the owner")

    @precondition(lambda self: self.later < MOST_LATER)
    @rule()
    def let_the_clock_pass(self) -> None:
        self.later += 1
        self.world.clock_offset_s += LATER_S
        if self.agent is not None:
            self._run(self.agent.event_stream.set_clock())

    # ---------------------------------------------------------------- rules: how far commands get
    @rule(times=st.integers(0, 6))
    def go_on(self, times: int) -> None:
        for _ in range(times):
            self._settle()
            self.gates.let_all()
            self._settle()

    @rule(gate=st.sampled_from(["mind", "lease", "step", "body"]))
    def let(self, gate: str) -> None:
        getattr(self.gates, gate).let()
        self._settle()

    # ---------------------------------------------------------------- rules: how the agent lives
    @precondition(lambda self: self.agent is not None)
    @rule()
    def end(self) -> None:
        self._end()

    @precondition(lambda self: self.agent is None)
    @rule(journal=st.sampled_from(["kept", "kept", "deleted", "restored"]), n=numbers)
    def start(self, journal: str, n: int) -> None:
        self._start(journal, n)

    @rule(journal=st.sampled_from(["kept", "kept", "deleted", "restored"]), n=numbers)
    def restart(self, journal: str, n: int) -> None:
        self._end()
        self._start(journal, n)

    @rule()
    def copy_the_journal(self) -> None:
        self.copies.append(self._journal.copy())

    # ---------------------------------------------------------------- invariants
    @invariant()
    def nothing_moved_that_must_not(self) -> None:
        assert not self.wrong, self.wrong

    @invariant()
    def no_command_has_two_ends(self) -> None:
        for entry in self.entry:
            assert len(self._replies(entry)) <= 1
            assert len(self._ends(entry)) <= 1, self._ends(entry)

    def teardown(self) -> None:
        try:
            self._run_out()
            self.nothing_moved_that_must_not()
            self.no_command_has_two_ends()
            for entry in self.entry:
                if entry.due:
                    assert len(self._ends(entry)) == 1, (entry, [p.card for p in self._replies(entry)])
            self._only_a_later_post_moves_it()
        finally:
            self.gates.open()
            self._end()
            if self.halted:
                self.release()
            self.runner.close()

    def _run_out(self) -> None:
        """Release everybody until nothing is left to do."""
        if self.agent is None:
            self._start("kept", 0)
        self.gates.open()
        self._settle()
        for entry in self._waiting():
            self.world.add_post(
                self.world.topics[self.world.posts[entry.post_id].topic_id], MODERATOR, f"@{ROBOT} deny",
                next(self.keys), (), reply_to=entry.post_id,
            )  # fmt: skip
        self._run(self._until(lambda: self.agent is not None and not self.agent.queue and self._quiet()))

    def _only_a_later_post_moves_it(self) -> None:
        """At the end a command without objections moves, so the machine does detect motions."""
        if self.halted:
            self.release()
        self.change_the_limit(WIDE_DEG)
        self.stand.robot.time_scale = math.inf  # so that a busy machine cannot invalidate the turn
        late = self._ask("carol", "1", (("left", 91.0),))
        if self.approval:
            self.say(MODERATOR, "approve", 0)
        self._run(self._until(lambda: self._ends(late)))
        assert self._ends(late) == ["done"], [post.raw for post in self._replies(late)]
        assert self.moved["left", 91.0] == 1
        self.nothing_moved_that_must_not()

    # ---------------------------------------------------------------- the ledger
    def _sent(self, primitive: Primitive) -> None:
        """The agent starts a step: all conditions of law 4 must hold on the forum at this moment."""
        self.stopped_when_sent = self.stand.robot.stopped
        step = _step(primitive)
        if why := self._objections(step):
            self.wrong.append(f"{step} was sent: {why}")

    def _passed_the_guard(self, primitive: Primitive) -> None:
        """The driver passes a step to the robot: the limits have been checked for the last time."""
        if (step := _step(primitive))[1] > self.limit_deg:
            self.wrong.append(f"{step} passed the guard beyond the limit")

    def _moved(self, primitive: Primitive) -> None:
        """The body starts to move (in a thread of the driver)."""
        step = _step(primitive)
        self.moved[step] += 1
        why = self._violations(step)
        why += ["halted"] if self.halted else []
        if self.moved[step] > 1:
            why.append("it had moved before")
        if why:
            self.wrong.append(f"{step} moved: {why}")

    def _violations(self, step: Step) -> list[str]:
        """Check what must hold until the body moves."""
        if step not in self.of_step:
            return [self.forbidden_text.get(step, "nobody asked for it")]
        entry = self.of_step[step]
        return sorted(entry.never)

    def _objections(self, step: Step) -> list[str]:
        why = self._violations(step)
        if (entry := self.of_step.get(step)) is None:
            return why
        post, author = self.world.posts[entry.post_id], self.world.accounts[entry.author]
        why += ["beyond the limit"] if step[1] > self.limit_deg else []
        why += ["removed"] if post.removed else []
        why += ["edited"] if post.version > 1 else []
        why += ["suspended"] if author.suspended else []
        why += [] if author.kind in OBEYED else [f"by a {author.kind}"]
        why += ["not approved"] if self.approval and not entry.approved else []
        return why + (["no right"] if author.role is Role.MEMBER else [])

    def _stopped(self, post_id: str = "") -> None:
        """Law 14: a stop ends every earlier command once the agent gets it."""
        if self.agent is None:
            self.missed.append((post_id, self.world.now()))
            return
        for entry in self.entry:
            entry.never.add("stopped")

    def _stopped_while_away(self) -> None:
        """Apply the stops that the agent missed, except those that are invalid when it is back (edited, removed, author
        suspended)."""
        for post_id, at in self.missed:
            post = self.world.fresh(post_id) if post_id else None
            if post is None or (post.raw.endswith("stop") and _listened_to(post.author) and not post.removed):
                for entry in self.entry:
                    entry.never |= {"stopped"} if entry.posted_at <= at else set()
        self.missed.clear()

    def _amend(self, entry: LedgerEntry, why: str, apply_change: Callable[[], Any]) -> None:
        """Change a post.

        A motion that has passed the last check may finish its step; a removed post may not start one.
        """
        on_its_way = bool(self.gates.step.held or self.gates.body.held)
        apply_change()
        self._settle()
        if why == "removed" or not on_its_way:
            entry.never.add(why)

    # ---------------------------------------------------------------- posts
    def _steps(self, count: int, large: bool) -> tuple[Step, ...] | None:
        degrees = list(itertools.islice(self.large if large else self.small, count))
        if len(degrees) < count:
            return None
        return tuple((("left", "right")[n % 2], float(d)) for n, d in enumerate(degrees))

    def _ask(self, author: str, topic: str, steps: tuple[Step, ...]) -> LedgerEntry:
        post = self._write(author, topic, _words(steps))
        entry = LedgerEntry(post.id, author, steps, post.created_at)
        self.entry.append(entry)
        self.of_step.update(dict.fromkeys(steps, entry))
        self._settle()
        if self.agent is not None:
            self._note_receipt(entry)
        return entry

    def _write(self, author: str, topic: str, text: str) -> Post:
        """Return a post by any account, also one that may no longer write: it wrote just before."""
        return self.world.add_post(self.world.topics[topic], author, text, next(self.keys), ())

    def _edit(self, entry: LedgerEntry, text: str) -> None:
        self._run(self.world.sign_in(entry.author).edit(entry.post_id, text))

    def _pick(self, n: int) -> LedgerEntry:
        """Prefer the newest posts, because their commands are in progress."""
        return self.entry[-1 - n % len(self.entry)]

    def _may_write(self, entry: LedgerEntry) -> bool:
        return not self.world.posts[entry.post_id].removed and not self.world.accounts[entry.author].suspended

    def _note_receipt(self, entry: LedgerEntry) -> None:
        """Record that the agent gets this post for the first time."""
        entry.heard = True
        if (self.world.now() - entry.posted_at).total_seconds() > FRESH_S:
            entry.never.add("stale")
        entry.due = entry.due or self._reaches_the_agent(entry)

    def _reaches_the_agent(self, entry: LedgerEntry) -> bool:
        """Return whether it is a command that the agent gets, also if it may not be obeyed."""
        post, author = self.world.posts[entry.post_id], self.world.accounts[entry.author]
        return _listened_to(author) and not post.removed and not post.raw.endswith("stop")

    def _replies(self, entry: LedgerEntry) -> list[Post]:
        return [
            p for p in self.world.posts.values() if p.reply_to == entry.post_id and p.author.name == ROBOT and p.card
        ]

    def _ends(self, entry: LedgerEntry) -> list[str]:
        """Return every end of this command that was written, in the order of the forum's events."""
        ours = {p.id for p in self._replies(entry)}
        own_posts = (e.post for e in self.world.events if e.post is not None and e.post.id in ours)
        return [p.card.state for p in own_posts if p.card is not None and p.card.state in FINAL]

    # ---------------------------------------------------------------- the agent
    @property
    def _journal(self) -> JournalStore:
        return JournalStore(self.folder, ROBOT)

    def _begin(self) -> None:
        forum, client = self.world.sign_in(ROBOT), GatedClient(self.stand.socket, self.gates, self._sent)
        mind = GatedMind(self.gates)
        options = robot_settings(approval={"classes": ["move"]} if self.approval else {})

        async def begin() -> None:
            opened = partial(open_journal, self.folder, ROBOT)
            self.agent = RobotAgent(ROBOT, options, forum, client, mind, self.folder, open_journal=opened)
            self.serving = asyncio.create_task(self.agent.run())
            await self._until(self.agent.ready.is_set)

        self._run(begin())
        self._settle()
        self.halted = self.halted or self.stand.driver.state().halted  # by a post that was missed

    def _start(self, journal: str, n: int) -> None:
        if journal == "restored" and not self.copies:
            journal = "kept"
        if journal != "kept":
            self._journal.delete()
        if journal == "restored":
            self._journal.restore(self.copies[n % len(self.copies)])
        for entry in self.entry:
            age_s = (self.world.now() - entry.posted_at).total_seconds()
            entry.never |= {"before the first start"} if journal == "deleted" else set()
            entry.never |= {"stale"} if age_s > FRESH_S else set()
            # An account without read access is ignored by an agent that has never heard of it.
            entry.due = entry.due and (journal == "kept" or bool(self._ends(entry)) or self._reaches_the_agent(entry))
        self._stopped_while_away()
        self._begin()
        for entry in self.entry:
            if not entry.heard:
                self._note_receipt(entry)

    def _end(self) -> None:
        async def end() -> None:
            if self.agent is not None and self.serving is not None:
                self.serving.cancel()
                await asyncio.gather(self.serving, return_exceptions=True)
                await self.agent.close()
            self.agent = self.serving = None

        self._run(end())

    def _run(self, work: Any) -> Any:
        return self.runner.run(work)

    def _settle(self) -> None:
        """Wait until the agent got all events, did all that the gates allow, and stored its watermark."""

        async def settle() -> None:
            await self._until(lambda: self.agent is None or self._quiet())
            if self.agent is not None:
                await self.agent.journal.get("cursor")  # rows are written in order

        self._run(settle())

    async def _until(self, condition: Callable[[], Any]) -> None:
        for _ in range(MOST_LOOKS):
            if condition():
                return
            if self.serving is not None and self.serving.done():
                self.serving.result()
            await asyncio.sleep(LOOK_S)
        raise TimeoutError(
            f"not at rest: {[(job.command.text, job.ended) for job in (self.agent.queue if self.agent else ())]}"
        )

    def _quiet(self) -> bool:
        agent = self.agent
        assert agent is not None
        if agent.event_stream.cursor != str(len(self.world.events)) or not agent.inbox.empty:
            return False
        waiting = {job.task for job in agent.queue if self._waits(job)}
        return all(task.done() or task in waiting for task in agent.tasks.running)

    def _waits(self, job: QueuedCommand) -> bool:
        """Return whether the agent cannot continue without the test."""
        if job.command.text in self.gates.mind.held:
            return job.ended is None  # the agent does not wait for the mind of a command that was ended
        assert self.agent is not None
        if job.task in self.agent.queue.asking():
            return job.ended is None
        if not job.moving:
            return self.agent.queue.place(job) > 0 and job.ended is None
        if self.gates.lease.held:
            return True
        stopped = self.stand.robot.stopped > self.stopped_when_sent
        if self.gates.step.held:
            return job.ended is None or stopped
        return bool(self.gates.body.held) and job.ended is None and not stopped


def _words(steps: tuple[Step, ...]) -> str:
    return f"@{ROBOT} " + ", then ".join(f"turn {way} {degrees:g} degrees" for way, degrees in steps)


def _step(primitive: Primitive) -> Step:
    return str(primitive.direction), float(primitive.degrees or 0.0)


def _listened_to(account: Account) -> bool:
    return account.kind in OBEYED and not account.suspended


@pytest.fixture
def stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stand]:
    """Waits last zero seconds or longer than any busy machine needs: timing laws have other tests, and the same events
    must give the same result at any speed."""
    monkeypatch.setattr(event_stream, "SILENCE_S", 60.0)
    monkeypatch.setattr(turn, "SHUTDOWN_REPLY_S", 0.5)
    with robot_stand(tmp_path) as made:
        made.driver.leases.ttl_s = 60.0
        yield made


def prove(stand: Stand, folder: Path, approval: bool = False, **how: Any) -> None:
    numbers = itertools.count()
    run_state_machine_as_test(
        lambda: Laws(stand, folder / f"example-{next(numbers)}", approval),
        settings=settings(database=None, suppress_health_check=list(HealthCheck), report_multiple_bugs=False, **how),
    )


def test_laws_4_5_6_13_14_hold_under_any_order_of_events(stand: Stand, tmp_path: Path) -> None:
    prove(stand, tmp_path, max_examples=8, stateful_step_count=8, derandomize=True, phases=[Phase.generate])


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_laws_4_5_6_13_14_hold_under_many_orders_of_events(stand: Stand, tmp_path: Path) -> None:
    prove(stand, tmp_path, max_examples=size(30, 150), stateful_step_count=40, print_blob=True)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_laws_4_5_6_and_7_hold_under_any_order_of_events_where_each_command_needs_an_approval(
    stand: Stand, tmp_path: Path
) -> None:
    prove(stand, tmp_path, True, max_examples=10, stateful_step_count=20, print_blob=True)
