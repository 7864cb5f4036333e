"""The service's OpenAPI document is accurate: requests generated from it get the responses that it describes, and
never a 500."""

from __future__ import annotations

import asyncio
from pathlib import Path

import httpx2
import pytest
import schemathesis
from hypothesis import HealthCheck, assume, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.specs.openapi.checks import positive_data_acceptance

from tests.agent.agent_scene import Driver
from tests.service.service_scene import Service, make_service, token

TIME_SCALE = 10
EXAMPLES = 25


@pytest.mark.slow
async def test_responses_to_generated_requests_match_the_document(driver: Driver, tmp_path: Path) -> None:
    """Send valid and invalid requests to every operation while the agent runs."""
    async with make_service(driver, tmp_path, hooks_in={"forum": ("discourse", "s")}) as service:
        document = (await service.http.get(f"{service.url}/api/v1/openapi.json")).json()
        await asyncio.to_thread(send_to_all, document, service.url)
        assert (await service.ready()).status_code == 200


def send_to_all(document: dict[str, object], url: str) -> None:
    operations = [found.ok() for found in schemathesis.openapi.from_dict(document).get_all_operations()]
    assert len(operations) == 14
    for operation in operations:
        for mode in (GenerationMode.POSITIVE, GenerationMode.NEGATIVE):
            try:
                send_requests(operation, url, mode)
            except Unsatisfiable:
                assert mode is GenerationMode.NEGATIVE, f"{operation.label}: no request can be made from the document"


def send_requests(operation: schemathesis.APIOperation, url: str, mode: GenerationMode) -> None:
    headers = {"Authorization": f"Bearer {token('bob')}"}

    @settings(max_examples=EXAMPLES, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(case=operation.as_strategy(generation_mode=mode))
    def gets_what_it_says(case: schemathesis.Case) -> None:
        # Malformed HTTP is refused before the document applies.
        assume(not {name.lower() for name in case.headers or {}} & {"content-length", "transfer-encoding", "host"})
        if "wait_s" in (case.query or {}):
            assume(mode is GenerationMode.NEGATIVE or float(case.query["wait_s"]) < 1)
        if "robot" in (case.path_parameters or {}) and mode is GenerationMode.POSITIVE:
            case.path_parameters["robot"] = "quadruped"  # a schema cannot express which robots are served
        case.call_and_validate(base_url=url, headers=headers, timeout=100, excluded_checks=[positive_data_acceptance])

    gets_what_it_says()


async def test_the_document_is_public_and_marks_operations_that_need_a_token(driver: Driver, tmp_path: Path) -> None:
    async with make_service(driver, tmp_path) as service:
        answer = await service.http.get(f"{service.url}/api/v1/openapi.json")
        document = answer.json()
        assert document["security"] == [{"bearer": []}]
        assert document["paths"]["/healthz"]["get"]["security"] == []


async def test_an_unreadable_body_is_a_problem_response(service: Service) -> None:
    for content in (b"{", b"[" * 60_000, b'{"text": "\\ud800"}', b'{"text": "' + b"\xff" + b'"}', b""):
        for path in ("commands", "preview"):
            answer = await httpx2_post(service.http, f"{service.url}/api/v1/robots/quadruped/{path}", content)
            assert answer.status_code in (400, 422)
            assert answer.headers["content-type"] == "application/problem+json"


async def test_a_repeated_query_parameter_is_refused(service: Service) -> None:
    headers = {"Authorization": f"Bearer {token('alice')}"}
    address = f"{service.url}/api/v1/robots/quadruped/commands/1?wait_s=0&wait_s=1"
    answer = await service.http.get(address, headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (422, "not_valid")
    assert answer.json()["detail"] == "query.wait_s: given 2 times; give it once"


async def httpx2_post(http: httpx2.AsyncClient, url: str, content: bytes) -> httpx2.Response:
    headers = {"Authorization": f"Bearer {token('alice')}", "Content-Type": "application/json"}
    return await http.post(url, content=content, headers=headers)
