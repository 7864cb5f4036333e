"""The states of a command: the table of transitions is sound, and everything that shows a state is derived from it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.board.content.writes import PROGRESS
from agentrob.board.web.templating import HERE, STATES
from agentrob.errors import IllegalTransition
from agentrob.forums.cards import card_of, facts_of
from agentrob.language.messages.catalog import can_say, say
from agentrob.model import CommandState, EndReason, StatusCard
from agentrob.model.lifecycle import (
    ACTIVE_STATES,
    CARD_STATES,
    FINAL_STATES,
    TRANSITIONS,
    check_transition,
    is_final_word,
    stored_reason,
    stored_state,
)
from agentrob.service.models import Command
from tests.agent.agent_scene import FINAL, reachable

DOCS = Path(__file__).parents[2] / "docs"
STATE = st.sampled_from(CommandState)


def test_every_state_has_a_row_and_is_reachable() -> None:
    assert set(TRANSITIONS) == set(CommandState)
    assert reachable(CommandState.POSTED) == set(CommandState) - {CommandState.POSTED}


def test_final_states_have_no_exits_and_every_other_state_leads_to_one() -> None:
    assert {state for state in CommandState if state.is_final} == FINAL_STATES
    for state in CommandState:
        assert bool(TRANSITIONS[state]) is not state.is_final
        assert state.is_final or reachable(state) & FINAL_STATES


def test_a_state_is_never_left_for_itself_or_for_the_one_before_the_agent() -> None:
    assert all(state not in following for state, following in TRANSITIONS.items())
    assert not any(CommandState.POSTED in following for following in TRANSITIONS.values())


def test_law_13_a_stop_can_end_a_command_in_every_state_in_which_the_agent_has_it() -> None:
    for state in ACTIVE_STATES:
        for end in (*(r.state_in_motion for r in EndReason), CommandState.INTERRUPTED, CommandState.FAILED):
            check_transition(state, end)
    for state in ACTIVE_STATES - {CommandState.RUNNING}:
        for reason in EndReason:
            check_transition(state, reason.state_before_motion)


def test_law_7_a_command_that_waits_for_approval_cannot_run() -> None:
    with pytest.raises(IllegalTransition, match=r"from 'waiting' to 'running'; valid: .*queued"):
        check_transition(CommandState.WAITING, CommandState.RUNNING)


def test_a_motion_is_the_only_way_to_done() -> None:
    assert [s for s, following in TRANSITIONS.items() if CommandState.DONE in following] == [CommandState.RUNNING]


@given(STATE, STATE)
def test_the_check_and_the_table_say_the_same(before: CommandState, after: CommandState) -> None:
    if after is before or after in TRANSITIONS[before]:
        check_transition(before, after)
    else:
        with pytest.raises(IllegalTransition):
            check_transition(before, after)


@given(st.lists(STATE, max_size=12))
def test_no_walk_through_the_table_leaves_a_final_state(walk: list[CommandState]) -> None:
    state, ended = CommandState.POSTED, None
    for wanted in walk:
        try:
            check_transition(state, wanted)
        except IllegalTransition:
            continue
        state = wanted
        if ended is not None:
            assert state is ended
        ended = state if state.is_final else None


def test_words_of_earlier_versions_are_read() -> None:
    earlier = FINAL | {"seen", "waiting", "queued", "running", "posted", "stop", "nothing"}
    assert {word for word in earlier if stored_state(word) != word} == set()
    assert stored_state("answered before") is CommandState.HANDLED_ELSEWHERE
    assert stored_state("replaced") is CommandState.CANCELLED
    with pytest.raises(ValueError, match="fetched"):
        stored_state("fetched")
    assert {stored_reason(reason.value) for reason in EndReason} == set(EndReason)
    assert stored_reason("a word of a newer version") is EndReason.BEFORE


def test_cards_of_earlier_and_of_newer_versions_are_read() -> None:
    old = {"robot": "quadruped", "state": "running", "step": 1, "steps": 2, "trace_id": "t1"}
    card = card_of(old)
    assert card is not None
    assert (card.state, card.is_final) == (CommandState.RUNNING, False)
    assert facts_of(StatusCard("quadruped", CommandState.RUNNING, 1, 2, trace_id="t1")) == old
    newer = card_of({"robot": "quadruped", "state": "levitating"})
    assert newer is not None
    assert not newer.is_final


def test_what_is_derived_covers_the_states() -> None:
    assert CARD_STATES & FINAL_STATES == FINAL
    assert set(STATES) == CARD_STATES
    assert PROGRESS < ACTIVE_STATES < CARD_STATES
    assert all(is_final_word(word) for word in FINAL)
    assert set(Command.model_json_schema()["$defs"]["CommandState"]["enum"]) == set(CommandState)


def test_each_state_of_a_card_has_a_colour() -> None:
    css = (HERE / "static" / "board.css").read_text()
    neutral = {CommandState.ANSWERED}
    assert {state for state in CARD_STATES if not re.search(rf"\.is-{state}\b", css)} == neutral


@pytest.mark.parametrize("language", ["en", "zh"])
def test_each_end_of_a_command_has_a_sentence(language: str) -> None:
    told_by_the_message = {CommandState.ANSWERED, CommandState.EXPIRED}
    heads = {state: f"agent.{state}" for state in (CARD_STATES & FINAL_STATES) - told_by_the_message}
    assert {state for state, key in heads.items() if not can_say(key)} == set()
    assert say(heads[CommandState.REFUSED], language)
    unmoved = {reason for reason in EndReason if reason.state_before_motion is CommandState.EXPIRED}
    assert {f"agent.{reason}" for reason in unmoved if not can_say(f"agent.{reason}")} == set()
    others = set(EndReason) - unmoved
    assert {reason for reason in others if not can_say(f"agent.because.{reason}")} == set()


def test_the_service_documents_every_state() -> None:
    text = (DOCS / "agents/service.md").read_text()
    assert {state for state in CommandState if f"`{state}`" not in text} == set()
