"""Agents of several robots, as they decide by what the forum shows them: late, in any order, twice, and with crashes.

Each agent sees its own view of one thread, and decides by the pure rules of `evidence`, as `PartWaits` does with them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from agentrob.agent.joint import evidence
from agentrob.agent.joint.evidence import Bidding, Ended, LeftTo, Released, Turn, Waiting
from agentrob.language.joint.parts import Choice, JointCommand, JointPart
from agentrob.language.joint.reading import joint_command
from agentrob.model import Account, AccountKind, Command, Post, StatusCard
from tests.sizes import size

ROBOTS = ("rex", "bot", "cat")
POSTS = (
    "@rex wave, then @bot wave",
    "@rex wave. Meanwhile @bot sit. Then both of you wave.",
    "@rex wave, then @bot sit, then @cat wave",
    "@rex @bot @cat one of you wave",
    "@rex or @bot wave",
    "@cat wave, then @rex or @bot wave",
    "@rex wave, then @bot or @cat sit, then @rex stretch",
    "@bot wave when @rex is done. @rex sit. @cat wave when @bot is done.",
)
POSTED_AT = datetime(2030, 1, 1, tzinfo=UTC)
FAILURES = ("failed", "refused", "stopped", "interrupted", "expired", "asks_back")


@dataclass
class Agent:
    """One robot's agent: its view of the thread, and what its journal keeps."""

    robot: str
    seen: dict[str, Post] = field(default_factory=dict)
    alive: bool = True
    claimed: bool = False
    bid_at: dict[int, datetime] = field(default_factory=dict)
    released: set[int] = field(default_factory=set)
    begun: set[int] = field(default_factory=set)
    ended: dict[int, str] = field(default_factory=dict)


class JointMachine(RuleBasedStateMachine):
    """A thread whose posts are in one order; each agent hears of them whenever a rule says so."""

    def __init__(self) -> None:
        super().__init__()
        self.thread: dict[str, Post] = {}  # in order
        self.versions: list[Post] = []  # every version of every post
        self.now = POSTED_AT
        self.motions: dict[int, list[str]] = {}
        self.evidence: list[str] = []

    @initialize(text=st.sampled_from(POSTS), dead=st.sampled_from((*ROBOTS, "", "", "")))
    def a_person_posts(self, text: str, dead: str) -> None:
        self.dead = dead  # in the end its agent does not start again
        found = joint_command(text)
        assert isinstance(found, JointCommand)
        self.joint = found
        alice = Account("1", "alice")
        self.commands = {
            part.number: Command("1", "1", "hash", alice, "", text, "en", POSTED_AT, "t", part=part.number, parts=9)
            for part in found.parts
        }
        self.agents = {robot: Agent(robot) for robot in found.robots}

    # ---------------------------------------------------------------- the forum
    def write(self, agent: Agent, part: JointPart, state: str, **more: Any) -> None:
        """Write or edit the status post of a part; a post that takes a part is one of its own, written once."""
        facts = {"part": part.number, "parts": 9, "post": "1", "content_hash": "hash", **more}
        card = StatusCard(agent.robot, state, **facts)
        key = f"{agent.robot} {part.number} {'take' if card.takes else ''}"
        before = self.thread.get(key)
        if before is not None and card.takes:
            return
        if before is None:
            account = Account(agent.robot, agent.robot, AccountKind.ROBOT_AGENT)
            post = Post(key, "1", "robots", account, "", self.now, reply_to="1", card=card)
        else:
            post = replace(before, card=card, version=before.version + 1, edited_at=self.now)
        self.thread[key] = post
        self.versions.append(post)
        agent.seen[key] = post

    def view(self, agent: Agent, read: bool) -> list[Post]:
        """The posts that an agent knows: all of the thread if it reads it, else those that it received, in their
        order."""
        if read:
            agent.seen = dict(self.thread)
        return evidence.part_posts(agent.seen.values(), next(iter(self.commands.values())))

    # ---------------------------------------------------------------- what happens
    @rule(robot=st.sampled_from(ROBOTS), data=st.data())
    def an_agent_hears_something(self, robot: str, data: st.DataObject) -> None:
        """Any version of any post, also an old one, also again."""
        agent = self.agents.get(robot)
        if agent is None or not agent.alive or not self.versions:
            return
        post = data.draw(st.sampled_from(self.versions))
        before = agent.seen.get(post.id)
        if before is None or before.version <= post.version:
            agent.seen[post.id] = post

    @rule(seconds=st.sampled_from((0.5, 3.0, 11.0, 40.0)))
    def time_passes(self, seconds: float) -> None:
        self.now += timedelta(seconds=seconds)

    @rule(robot=st.sampled_from(ROBOTS), crashes=st.sampled_from((True, False, False)))
    def an_agent_crashes(self, robot: str, crashes: bool) -> None:
        """All state outside of the journal and the forum is lost; a part that moved is interrupted."""
        if (agent := self.agents.get(robot)) is not None and crashes:
            agent.alive, agent.seen = False, {}

    @rule(robot=st.sampled_from(ROBOTS))
    def an_agent_starts(self, robot: str) -> None:
        agent = self.agents.get(robot)
        if agent is None or agent.alive:
            return
        agent.alive = True
        for number in agent.begun - agent.ended.keys():
            self.end(agent, self.joint.part(number), "interrupted")

    @rule(robot=st.sampled_from(ROBOTS), read=st.sampled_from((True, False, False)))
    def an_agent_goes_on(self, robot: str, read: bool) -> None:
        if (agent := self.agents.get(robot)) is not None and agent.alive:
            self.go_on(agent, read)

    @rule(seconds=st.sampled_from((0.5, 3.0, 15.0)))
    def all_agents_go_on_by_what_they_heard(self, seconds: float) -> None:
        for robot in self.agents:
            self.an_agent_goes_on(robot, read=False)
        self.now += timedelta(seconds=seconds)

    @rule(robot=st.sampled_from(ROBOTS), ends=st.sampled_from(("done", "done", "done", *FAILURES)))
    def a_motion_ends(self, robot: str, ends: str) -> None:
        agent = self.agents.get(robot)
        if agent is None or not agent.alive:
            return
        for number in sorted(agent.begun - agent.ended.keys()):
            return self.end(agent, self.joint.part(number), ends)

    # ---------------------------------------------------------------- an agent
    def end(self, agent: Agent, part: JointPart, state: str, **more: Any) -> None:
        agent.ended[part.number] = state
        self.write(agent, part, state, **more)

    def go_on(self, agent: Agent, read: bool) -> None:
        for part in self.joint.of(agent.robot):
            if part.number in agent.ended or part.number in agent.begun:
                continue
            if not agent.claimed:
                agent.claimed = True
                for own in self.joint.of(agent.robot):
                    self.write(agent, own, "seen")
            if part.number not in agent.released and not self.released(agent, part, read):
                continue
            agent.released.add(part.number)
            if part.choice is Choice.NAMED or self.takes(agent, part, read):
                self.begin(agent, part)

    def released(self, agent: Agent, part: JointPart, read: bool) -> bool:
        posts = self.view(agent, read)
        statuses = {n: evidence.status_of(self.joint.part(n), posts) for n in part.after}
        match evidence.look_at(self.joint, part.number, statuses, POSTED_AT, self.now):
            case Released():
                return True
            case Ended():
                self.end(agent, part, "cancelled")
            case Waiting(parts, until):
                assert parts
                self.write(agent, part, "queued", until=until.isoformat())
        return False

    def takes(self, agent: Agent, part: JointPart, read: bool) -> bool:
        since = agent.bid_at.setdefault(part.number, self.now)
        own = StatusCard(agent.robot, "queued", bid_s=5 + len(agent.robot) + ROBOTS.index(agent.robot), battery=80)
        self.write(agent, part, "queued", bid_s=own.bid_s, battery=80)
        match evidence.look_at_bids(part, own, self.view(agent, read), since, self.now):
            case Turn():
                self.write(agent, part, "answered", takes=1)
                if evidence.taker_of(part, self.view(agent, read=True)) == agent.robot:
                    return True
                self.end(agent, part, "cancelled")
            case LeftTo(robot):
                self.end(agent, part, "cancelled", left_to=robot)
            case Ended():
                self.end(agent, part, "cancelled")
            case Bidding():
                pass
        return False

    def begin(self, agent: Agent, part: JointPart) -> None:
        for before in part.after:
            status = evidence.status_of(self.joint.part(before), list(self.thread.values()))
            self.evidence.append(status.state)
        agent.begun.add(part.number)
        self.motions.setdefault(part.number, []).append(agent.robot)
        self.write(agent, part, "running")

    # ---------------------------------------------------------------- what always holds
    @invariant()
    def no_part_begins_before_the_evidence_of_those_for_which_it_waits(self) -> None:
        assert set(self.evidence) <= {"done"}

    @invariant()
    def every_part_moves_one_robot_once_at_most(self) -> None:
        assert all(len(robots) == 1 for robots in self.motions.values())

    def teardown(self) -> None:
        """When agents run and the forum answers, every part of theirs ends, also beside an agent that is dead."""
        if not hasattr(self, "joint"):
            return
        living = [robot for robot in self.agents if robot != self.dead]
        for _ in range(200):
            for robot in living:
                self.an_agent_starts(robot)
                self.go_on(self.agents[robot], read=True)
                self.a_motion_ends(robot, "done")
            self.now += timedelta(seconds=5)
        for robot in living:
            assert self.agents[robot].ended.keys() == {part.number for part in self.joint.of(robot)}
        posts = evidence.part_posts(self.thread.values(), self.commands[1])
        ends = [evidence.status_of(part, posts).has_ended for part in self.joint.parts]
        assert all(ends) or self.dead in self.agents
        self.no_part_begins_before_the_evidence_of_those_for_which_it_waits()
        self.every_part_moves_one_robot_once_at_most()


TestJointMachine = JointMachine.TestCase
TestJointMachine.settings = settings(max_examples=size(60, 2000), stateful_step_count=size(40, 80), deadline=None)
