"""Delete the workflows of the journal's engine: unfinished ones at the start, finished ones some time after their
end."""

from __future__ import annotations

import time
from collections.abc import Collection
from datetime import datetime

from dbos import DBOS, DBOSClient, DBOSPortableJSONSerializer

#: How long a finished workflow is kept. Only an open command needs it, and an open command keeps it.
KEEP_S = 3600.0
#: How many workflows are deleted in one write, so that the row of a motion does not wait for long.
AT_ONCE = 200


def forget_unfinished(url: str, exists: bool) -> None:
    """Delete unfinished workflows, of this version or another."""
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
    """Delete finished workflows that began more than `KEEP_S` ago, except those `needed`. The engine must run."""
    before = datetime.fromtimestamp(time.time() - KEEP_S).astimezone().isoformat()
    done = DBOS.list_workflows(status=["SUCCESS", "ERROR"], end_time=before, load_input=False, load_output=False)
    ids = [w.workflow_id for w in done if w.workflow_id not in needed]
    for some in (ids[n : n + AT_ONCE] for n in range(0, len(ids), AT_ONCE)):
        DBOS.delete_workflows(some)
