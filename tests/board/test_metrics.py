"""The board's metrics, on an address of its own."""

from __future__ import annotations

from pathlib import Path

from prometheus_client import generate_latest

from agentrob.board.metrics import BoardMetrics
from agentrob.board.server import create_app
from agentrob.board.settings import BoardSettings


def test_it_counts_requests_and_changes(tmp_path: Path) -> None:
    from starlette.testclient import TestClient  # not in production

    settings = BoardSettings(
        f"sqlite:///{tmp_path}/b.sqlite3", "127.0.0.1", 80, "http://testserver", tmp_path, public_read=True
    )
    metrics = BoardMetrics()
    with TestClient(create_app(settings, metrics)) as client:
        assert client.get("/api/v1/boards").status_code == 200
        assert client.get("/metrics").status_code == 404
        lines = generate_latest(metrics.registry).decode().splitlines()
    assert 'agentrob_http_requests_total{method="GET",status="200"} 1.0' in lines
    assert 'agentrob_http_requests_total{method="GET",status="404"} 1.0' in lines
    assert "agentrob_board_listeners 0.0" in lines
