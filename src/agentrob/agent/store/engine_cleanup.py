"""What the journal's engine leaves behind: dropped at a start when it is unfinished, else some time after its end."""

from __future__ import annotations

import time
from collections.abc import Collection
from datetime import datetime

from dbos import DBOS, DBOSClient, DBOSPortableJSONSerializer

#: What is finished is kept so long. Only a command that is still open needs it, and that one keeps it.
KEEP_S = 3600.0
#: So many workflows are dropped in one write, so that a motion's row need not wait for long.
AT_ONCE = 200


def forget_unfinished(url: str, exists: bool) -> None:
    """Drop workflows that were left unfinished, of this version or another."""
    if not exists:
        return
    client = DBOSClient(system_database_url=url, serializer=DBOSPortableJSONSerializer())
    try:
        left = client.list_workflows(status=["PENDING", "ENQUEUED", "DELAYED", "ERROR"], load_input=False)
        if left:
            client.delete_workflows([w.workflow_id for w in left])
    finally:
        client.destroy()


def forget_finished(needed: Collection[str]) -> None:
    """Drop workflows that ended and were begun more than `KEEP_S` ago, but for those `needed`. The engine runs."""
    before = datetime.fromtimestamp(time.time() - KEEP_S).astimezone().isoformat()
    done = DBOS.list_workflows(status=["SUCCESS", "ERROR"], end_time=before, load_input=False, load_output=False)
    ids = [w.workflow_id for w in done if w.workflow_id not in needed]
    for some in (ids[n : n + AT_ONCE] for n in range(0, len(ids), AT_ONCE)):
        DBOS.delete_workflows(some)
