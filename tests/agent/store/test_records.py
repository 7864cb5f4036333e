"""The record of a finished command says everything that was decided and measured, and its pictures are beside it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from agentrob.agent.store.records import Records, approval
from agentrob.agent.store.rows import ApprovalDecision, ApprovalRequest
from agentrob.agent.understanding.extract import Assessment
from agentrob.minds.safety_review import SafetyReview
from agentrob.minds.usage import Usage
from agentrob.model import (
    Account,
    AccountKind,
    ActionResult,
    Command,
    CommandState,
    Decision,
    Direction,
    Intent,
    Op,
    Outcome,
    Plan,
    Primitive,
    Report,
    Role,
    ScheduledRun,
    StopResult,
    Understanding,
    Verdict,
)

AT = datetime(2026, 5, 1, 12, tzinfo=UTC)
ALICE = Account("a1", "alice", AccountKind.HUMAN, Role.OPERATOR)
COMMAND = Command("12", "3", "hash", ALICE, "quadruped", "向前走", "zh", AT, "trace")
WALK, PHOTO = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0), Primitive(Op.GET_FRONT_IMAGE)
WALKED = ActionResult(WALK, Outcome.DONE, {"distance_m": 0.98}, "", "", 0.0, 4.0)
PICTURED = ActionResult(PHOTO, Outcome.DONE, {}, "", "", 4.0, 5.0, image=b"jpeg")
PLAN = Plan((WALK, PHOTO), ("a note",))
REPORT = Report(COMMAND, CommandState.DONE, plan=PLAN, results=(WALKED, PICTURED), message="Done.")


def test_pictures_are_kept_beside_the_results_and_given_back(tmp_path: Path) -> None:
    records = Records(tmp_path)
    results, paths = records.keep_pictures("1/2", (WALKED, PICTURED, PICTURED))
    assert results == (WALKED, replace(PICTURED, image=None), replace(PICTURED, image=None))
    assert [Path(path).name for path in paths] == ["", "1_2-2.jpg", "1_2-3.jpg"]
    assert records.with_pictures(results, paths) == (WALKED, PICTURED, PICTURED)
    Path(paths[1]).unlink()
    assert records.with_pictures(results, paths) == (WALKED, replace(PICTURED, image=None), PICTURED)
    assert records.keep_pictures("1/2", (PICTURED,))[1] == (str(tmp_path / "pictures/1_2-1.jpg"),)


def test_each_result_has_one_picture_or_none(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="zip"):
        Records(tmp_path).with_pictures((WALKED, PICTURED), ("",))


def test_law_19_a_record_says_what_was_asked_decided_and_measured(tmp_path: Path) -> None:
    report = replace(
        REPORT,
        verdict=Verdict(Decision.ALLOW, "screen.passed", "It is safe."),
        stop=StopResult(9.0, confirmed=True, was_moving=True),
        timings_ms={"seen": 31.04, "done": 7420.26},
        findings=("a door",),
    )
    records = Records(tmp_path)
    facts = records.write(report, stopped_by="bob")
    assert facts == {
        "post": "12",
        "topic": "3",
        "robot": "quadruped",
        "author": {"id": "a1", "name": "alice", "role": "operator"},
        "text": "向前走",
        "content_hash": "hash",
        "posted_at": "2026-05-01T12:00:00+00:00",
        "trace_id": "trace",
        "status": "done",
        "message": "Done.",
        "plan": PLAN.as_data(),
        "notes": ["a note"],
        "verdict": {"decision": "allow", "rule": "screen.passed", "reason": "It is safe."},
        "steps": [WALKED.as_data(), PICTURED.as_data()],
        "findings": ["a door"],
        "stop": asdict(StopResult(9.0, confirmed=True, was_moving=True)),
        "timings_ms": {"seen": 31.0, "done": 7420.3},
        "mind": "",
        "fallback": "",
        "models": [],
        "screened": None,
        "stopped_by": "bob",
    }
    assert records.read("12") == json.loads(json.dumps(facts))
    text = (tmp_path / "records/12.json").read_text(encoding="utf-8")
    assert "向前走" in text
    assert text.endswith("\n")


def test_what_did_not_happen_is_null(tmp_path: Path) -> None:
    facts = Records(tmp_path).write(REPORT)
    assert (facts["verdict"], facts["stop"], "run" in facts) == (None, None, False)


def test_law_19_a_record_says_who_read_the_command_and_what_a_model_had_against_it(tmp_path: Path) -> None:
    usage = Usage("clever", "vision-large", 10, 2, 12)
    refusal = Verdict(Decision.REFUSE, "screen.model")
    read = Assessment(Understanding(Intent.COMMAND), "plain", usage=(usage,), fallback="timeout")
    records = Records(tmp_path)
    facts = records.write(REPORT, read)
    assert {key: facts[key] for key in ("mind", "fallback", "models", "screened")} == {
        "mind": "plain", "fallback": "timeout", "models": [usage.as_data()], "screened": None,
    }  # fmt: skip
    screened = replace(read, screened=SafetyReview("clever", refusal, why="too near"))
    assert records.write(REPORT, screened)["screened"] == {
        "mind": "clever",
        "refusal": {"decision": "refuse", "rule": "screen.model", "reason": ""},
        "why": "too near",
        "failed": "",
    }
    silent = replace(read, screened=SafetyReview("clever", failed="timeout"))
    assert records.write(REPORT, silent)["screened"] == {
        "mind": "clever", "refusal": None, "why": "", "failed": "timeout",
    }  # fmt: skip


def test_each_run_of_a_schedule_has_its_record(tmp_path: Path) -> None:
    run = ScheduledRun(AT, AT - timedelta(hours=1), "Europe/Berlin", number=2, of=5, limited=True)
    facts = Records(tmp_path).write(replace(REPORT, command=replace(COMMAND, run=run)))
    assert facts["run"] == {
        "at": "2026-05-01T12:00:00+00:00", "zone": "Europe/Berlin", "number": 2, "of": 5, "limited": True,
    }  # fmt: skip
    assert [path.name for path in (tmp_path / "records").iterdir()] == ["12_20260501T120000Z.json"]


def test_a_record_that_is_missing_damaged_or_of_another_post_is_none(tmp_path: Path) -> None:
    records = Records(tmp_path)
    assert records.read("12") is None
    records.write(replace(REPORT, command=replace(COMMAND, post_id="1/2")))
    assert records.read("1/2") is not None
    assert records.read("1_2") is None  # the same name of the file
    for damaged in ('{"post": "1/2"', "[]", "null", "\x00"):
        (tmp_path / "records/1_2.json").write_text(damaged)
        assert records.read("1/2") is None, damaged


def test_only_the_owner_of_the_folder_may_look_into_it(tmp_path: Path) -> None:
    records = Records(tmp_path / "agent")
    records.write(REPORT)
    records.keep_pictures("12", (PICTURED,))
    assert {path.stat().st_mode & 0o777 for path in (tmp_path / "agent").iterdir()} == {0o700}


def test_law_7_a_record_says_until_when_an_approval_was_asked_for_and_who_gave_it() -> None:
    assert approval(None) is None
    asked = ApprovalRequest(AT, AT + timedelta(minutes=5))
    assert approval(asked) == {"until": "2026-05-01T12:05:00+00:00"}
    given = ApprovalDecision(True, ALICE, "13", "hash", AT + timedelta(minutes=1), preview="p")
    assert approval(replace(asked, decided=given)) == {
        "until": "2026-05-01T12:05:00+00:00",
        "approved": True,
        "by": "alice",
        "role": "operator",
        "post": "13",
        "at": "2026-05-01T12:01:00+00:00",
        "preview": "p",
    }
