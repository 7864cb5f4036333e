"""What the journal's engine left behind and is dropped at a start."""

from __future__ import annotations

import time
from datetime import datetime

from dbos import DBOSClient, DBOSPortableJSONSerializer

#: What is finished is kept so long.
KEEP_S = 30 * 86400.0


def forget_unfinished(url: str, exists: bool) -> None:
    """Drop workflows that were left unfinished, of this version or another, and those long finished."""
    if not exists:
        return
    client = DBOSClient(system_database_url=url, serializer=DBOSPortableJSONSerializer())
    try:
        left = client.list_workflows(status=["PENDING", "ENQUEUED", "DELAYED", "ERROR"], load_input=False)
        before = datetime.fromtimestamp(time.time() - KEEP_S).astimezone().isoformat()
        done = client.list_workflows(status=["SUCCESS"], end_time=before, load_input=False, load_output=False)
        if ids := [w.workflow_id for w in (*left, *done)]:
            client.delete_workflows(ids)
    finally:
        client.destroy()
