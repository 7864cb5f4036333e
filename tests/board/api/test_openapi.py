"""The OpenAPI document is accurate: requests generated from it get the responses that it describes, and never a 500."""

from __future__ import annotations

import re
import time

import httpx2
import pytest
import schemathesis
from hypothesis import HealthCheck, assume, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.specs.openapi.checks import positive_data_acceptance

from agentrob.board.events.hub import Hub
from agentrob.board.server import create_app
from tests.board.running_board import LIMIT_S, RunningBoard

#: Endless streams; `test_streams` and `test_robots` test them.
STREAMS = ("/api/v1/events", "/api/v1/robots/{name}/camera.mjpg")


@pytest.fixture(scope="module")
def document(board: RunningBoard) -> schemathesis.BaseSchema:
    """Write some content to the forum, so that requests find it; return the served document."""
    op = board.client("op")
    for n in range(3):
        op.post("/topics", json={"board_id": "talk", "title": "t", "body": f"post {n}"})
    board.client("quadruped").put("/robots/quadruped", json={"card": {"model": "go2"}})
    return schemathesis.openapi.from_dict(op.get("/openapi.json").json())


#: The number of requests to an operation, and to one of administration, whose small forms need fewer.
FEW, MANY = (4, 2), (40, 12)


@pytest.mark.parametrize("examples", [FEW, pytest.param(MANY, marks=pytest.mark.slow)], ids=["few", "many"])
@pytest.mark.parametrize("mode", [GenerationMode.POSITIVE, GenerationMode.NEGATIVE])
def test_responses_to_generated_requests_match_the_document(
    document: schemathesis.BaseSchema, board: RunningBoard, mode: GenerationMode, examples: tuple[int, int]
) -> None:
    """Generate valid and invalid requests to every operation, the same ones in every run."""
    operations = [found.ok() for found in document.exclude(path=list(STREAMS)).get_all_operations()]
    for operation in operations:
        try:
            send_requests(operation, board, mode, examples["/admin/" in operation.path])
        except Unsatisfiable:
            assert mode is GenerationMode.NEGATIVE, f"{operation.label}: no request can be made from the document"
    assert len(operations) > 15


def send_requests(
    operation: schemathesis.APIOperation, board: RunningBoard, mode: GenerationMode, examples: int
) -> None:
    """Send many requests to one operation, and check each response against the document."""
    headers = {"Authorization": f"Bearer {board.tokens['quadruped' if operation.method == 'put' else 'admin']}"}

    # A schema cannot express which bytes are a picture, or which characters of a name are visible.
    named = ("/admin/accounts", "/admin/accounts/{name}", "/admin/boards", "/admin/boards/{board_id}")
    unsaid = operation.path.endswith(("/images", "/frame", *named))
    excluded = [positive_data_acceptance] if unsaid else []

    @settings(max_examples=examples, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(case=operation.as_strategy(generation_mode=mode))
    def gets_what_it_says(case: schemathesis.Case) -> None:
        # Malformed HTTP is refused before the document applies.
        assume(not {name.lower() for name in case.headers or {}} & {"content-length", "transfer-encoding", "host"})
        # An empty list or object in a query is not sent, so that nothing of the request is wrong.
        assume(all(value not in ([], {}) for value in (case.query or {}).values()))
        case.call_and_validate(base_url=board.url, headers=headers, timeout=LIMIT_S, excluded_checks=excluded)

    gets_what_it_says()


def test_the_document_is_public_and_describes_both_ways_to_authenticate(board: RunningBoard) -> None:
    served = board.client().get("/openapi.json").json()
    assert served == create_app(board.settings).openapi()
    assert set(served["components"]["securitySchemes"]) == {"bearer", "cookie"}


def test_every_operation_has_a_readable_id_of_its_own_and_one_documented_tag(board: RunningBoard) -> None:
    served = board.client().get("/openapi.json").json()
    operations = [operation for methods in served["paths"].values() for operation in methods.values()]
    ids = [operation["operationId"] for operation in operations]
    assert len(set(ids)) == len(ids)
    assert {"list_topics", "create_post", "approve_command", "deny_command", "stop_robot"} < set(ids)
    assert all(re.fullmatch(r"[a-z]+(_[a-z]+)+", name) for name in ids)
    described = {tag["name"] for tag in served["tags"] if tag["description"]}
    assert {tuple(operation["tags"]) for operation in operations} == {(name,) for name in described}


def test_a_repeated_query_parameter_is_refused_by_every_operation(board: RunningBoard) -> None:
    """The document describes no parameter as a list, and the framework would use the last value."""
    admin = board.client("admin")
    tried = []
    for path, methods in admin.get("/openapi.json").json()["paths"].items():
        for method, operation in methods.items():
            for parameter in operation.get("parameters", ()):
                if parameter["in"] != "query":
                    continue
                assert method == "get", "only GET is checked for repeated parameters"
                assert parameter["schema"].get("type") != "array"
                name = parameter["name"]
                answer = admin.get(path.removeprefix("/api/v1"), params=[(name, "1"), (name, "2")])
                assert (answer.status_code, answer.json()["code"]) == (422, "not_valid"), (path, name)
                assert answer.json()["detail"] == f"query.{name}: given 2 times; give it once"
                tried.append((path, name))
    assert {("/api/v1/search", "tag"), ("/api/v1/events", "after"), ("/api/v1/admin/audit", "target")} < set(tried)


def test_law_15_a_stop_is_accepted_with_any_query(board: RunningBoard) -> None:
    assert board.client("member").post("/robots/quadruped/stop?a=1&a=2").status_code < 300


def test_healthz_is_public_under_any_host_name(board: RunningBoard) -> None:
    end_s = time.monotonic() + LIMIT_S
    while True:  # on a busy machine a stop may take longer than a second, and the board says so by 503
        answer = httpx2.get(f"{board.url}/healthz", headers={"Host": "10.0.0.7:8000"})
        if answer.status_code != 503 or time.monotonic() > end_s:
            break
    assert (answer.status_code, answer.json()) == (200, {"status": "ok"})


def test_healthz_is_503_when_a_stop_could_not_be_delivered(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Hub, "delivers_stops", False)
    answer = board.browser().get("/healthz")
    assert (answer.status_code, answer.headers["retry-after"]) == (503, "1")


@pytest.mark.parametrize(("method", "path"), [("PUT", "/boards"), ("POST", "/me"), ("DELETE", "/topics")])
def test_other_methods_are_405_and_list_the_allowed_ones(board: RunningBoard, method: str, path: str) -> None:
    answer = board.client("op").request(method, path)
    assert (answer.status_code, answer.json()["code"]) == (405, "method_not_allowed")
    assert answer.headers["allow"]


@pytest.mark.parametrize(
    ("content", "content_type"), [(b"{", "application/json"), (b"a=b", "application/x-www-form-urlencoded"), (b"", "")]
)
def test_an_unreadable_body_is_a_problem_response(board: RunningBoard, content: bytes, content_type: str) -> None:
    answer = board.client("op").post("/topics", content=content, headers={"Content-Type": content_type})
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"


def test_a_wrong_value_is_named_but_not_repeated(board: RunningBoard) -> None:
    answer = board.client("op").post("/topics", json={"board_id": "talk", "title": 5, "body": "x", "secret": "hunter2"})
    assert "body.title" in answer.json()["detail"]
    assert "hunter2" not in answer.text
