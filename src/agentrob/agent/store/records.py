"""Keep a record of each command on disk: the reasons of the decision, the measurements, and the pictures (law 19)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from agentrob.agent.media.recorder import prune, safe_name
from agentrob.agent.store.rows import ApprovalRequest
from agentrob.agent.understanding.extract import Assessment
from agentrob.model import ActionResult, Report, ScheduledRun


class Records:
    """Files under one agent's data folder: `records/<post>.json` and `pictures/<post>-<step>.jpg`."""

    def __init__(self, folder: Path) -> None:
        self._records = folder / "records"
        self._pictures = folder / "pictures"

    def keep_pictures(
        self, post_id: str, results: Sequence[ActionResult]
    ) -> tuple[tuple[ActionResult, ...], tuple[str, ...]]:
        """Write the pictures of the steps; returns the results without them, and per step the path or ""."""
        self._pictures.mkdir(parents=True, exist_ok=True, mode=0o700)
        paths = []
        for number, result in enumerate(results, 1):
            path = ""
            if result.image:
                path = str(self._pictures / f"{safe_name(post_id)}-{number}.jpg")
                Path(path).write_bytes(result.image)
            paths.append(path)
        return tuple(replace(r, image=None) for r in results), tuple(paths)

    def with_pictures(self, results: Sequence[ActionResult], paths: Sequence[str]) -> tuple[ActionResult, ...]:
        """The results with their pictures again, as far as the files are still there."""
        pictures = (Path(p).read_bytes() if p and Path(p).exists() else None for p in paths)
        return tuple(replace(r, image=image) for r, image in zip(results, pictures, strict=True))

    def prune(self, days: float, mb: float, commands: int) -> None:
        """Delete what is older than `days`, the oldest beyond `mb` of each kind, and the oldest of too many records."""
        for folder, most in ((self._records, commands), (self._pictures, None)):
            if folder.is_dir():
                prune(folder, days, mb, most)

    def read(self, post_id: str) -> dict[str, Any] | None:
        """The record of a finished command; None when there is none."""
        try:
            facts = json.loads((self._records / f"{safe_name(post_id)}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return facts if isinstance(facts, dict) and facts.get("post") == post_id else None

    def write(self, report: Report, assessment: Assessment | None = None, **more: Any) -> dict[str, Any]:
        """The record of a finished command, readable by people and programs, and given back. `mind` is who read it in
        the end."""
        command = report.command
        facts = {
            "post": command.post_id,
            "topic": command.topic_id,
            "robot": command.robot,
            "author": {"id": command.author.id, "name": command.author.name, "role": str(command.author.role)},
            "text": command.text,
            "content_hash": command.content_hash,
            "posted_at": command.posted_at.isoformat(),
            "trace_id": command.trace_id,
            "status": report.status,
            "message": report.message,
            "plan": report.plan.as_data(),
            "notes": list(report.plan.notes),
            "verdict": asdict(report.verdict) if report.verdict else None,
            "steps": [result.as_data() for result in report.results],
            "findings": list(report.findings),
            "stop": asdict(report.stop) if report.stop else None,
            "timings_ms": {k: round(v, 1) for k, v in report.timings_ms.items()},
            **({"run": _run(command.run)} if command.run else {}),
            **_minds(assessment),
            **more,
        }
        self._records.mkdir(parents=True, exist_ok=True, mode=0o700)
        path = self._records / f"{safe_name(command.key)}.json"
        part = path.with_suffix(".part")
        part.write_text(json.dumps(facts, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
        part.replace(path)
        return facts


def approval(asked: ApprovalRequest | None) -> dict[str, Any] | None:
    """Until when an approval was asked for, and who said what by which post; None where none was needed."""
    if asked is None:
        return None
    until = {"until": asked.until_at.isoformat()}
    if (decision := asked.decided) is None:
        return until
    return until | {
        "approved": decision.approved, "by": decision.by.name, "role": str(decision.by.role),
        "post": decision.post_id, "at": decision.at.isoformat(), "preview": decision.preview,
    }  # fmt: skip


def _minds(assessment: Assessment | None) -> dict[str, Any]:
    """Who read and looked at a command, why not who should have, and what models took for it."""
    if assessment is None:
        return {"mind": "", "fallback": "", "models": [], "screened": None}
    screened = assessment.screened
    looked = screened and {
        "mind": screened.mind,
        "refusal": asdict(screened.refusal) if screened.refusal else None,
        "why": screened.why,
        "failed": screened.failed,
    }
    models = [usage.as_data() for usage in assessment.usage]
    return {"mind": assessment.mind, "fallback": assessment.fallback, "models": models, "screened": looked}


def _run(run: ScheduledRun) -> dict[str, Any]:
    """Which run of a schedule a command is."""
    return {"at": run.at.isoformat(), "zone": run.tz, "number": run.number, "of": run.of, "limited": run.limited}
