"""The service against its own description: whatever a generator makes of it, nothing fails."""

import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.strategies import booleans
from jsonschema_rs import validator_for
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)
from servers import scene


EXAMPLES = 8  # for each call
CHECKS = [not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance]


def test_no_call_fails(server):
    schema = schemathesis.openapi.from_url(f"{server.url}openapi.json")
    # The answer of an event stream has no end.
    calls = [found.ok() for found in schema.exclude(path="/v1/jobs/{job_id}/events").get_all_operations()]
    assert len(calls) > 18
    known = server.submit(scene())["id"]
    try:
        for call in calls:
            hold_to_its_description(call, known)
    finally:
        # What was made up and accepted is not worth rendering.
        for state in ("queued", "running", "paused"):
            for job in server.client.get(f"/v1/jobs?limit=200&state={state}").json()["jobs"]:
                server.client.delete(job["links"]["self"])


def hold_to_its_description(call, known: str) -> None:
    """Generated requests for one call, half of them about a job that is there."""

    @given(case=call.as_strategy(), of_known=booleans())
    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def check(case, of_known):
        if of_known and "job_id" in (case.path_parameters or {}):
            case.path_parameters["job_id"] = known
        case.call_and_validate(checks=CHECKS, timeout=60)

    check()


def test_every_call_is_described(server):
    document = server.client.get("/openapi.json").json()
    calls = {(method.upper(), path) for path, methods in document["paths"].items() for method in methods}
    job = "/v1/jobs/{job_id}"
    assert calls >= {
        ("POST", "/v1/jobs"), ("GET", "/v1/jobs"), ("GET", job), ("PATCH", job), ("DELETE", job),
        ("POST", f"{job}/retry"), ("GET", f"{job}/events"), ("GET", f"{job}/tiles"),
        ("GET", f"{job}/tiles/{{column}}/{{row}}.{{format}}"), ("GET", f"{job}/image.{{format}}"),
        ("GET", f"{job}/thumbnail.png"), ("GET", f"{job}/curve"), ("GET", f"{job}/stats"),
        ("HEAD", "/v1/assets/{digest}"), ("PUT", "/v1/assets/{digest}"), ("GET", "/v1/schema"), ("GET", "/healthz"),
        ("GET", "/readyz"), ("GET", "/metrics"), ("GET", "/v1/scenes"), ("GET", "/v1/scenes/{name}"),
    }


def test_the_scene_is_described_as_it_is_judged(server):
    """The models in the description are those of /v1/schema: what one accepts, the other accepts."""
    document = server.client.get("/openapi.json").json()
    described = validator_for({"$ref": "#/components/schemas/Scene", "components": document["components"]})
    served = validator_for(server.client.get("/v1/schema").json())
    good, bad = scene(), scene() | {"unknown": 1}
    for judge in (described, served):
        assert judge.is_valid(good) and not judge.is_valid(bad)
