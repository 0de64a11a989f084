"""The interface tried with what its own description allows: it never fails, it refuses."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from page_serving import ADDRESS
from starlette.testclient import TestClient

from motiondb.page.app import make_application
from motiondb.page.jobs import Job, Jobs
from motiondb.page.settings import PageSettings

schemathesis = pytest.importorskip("schemathesis")
requests = pytest.importorskip("requests")

EXAMPLES = int(os.environ.get("MOTIONDB_TEST_REQUESTS", "2"))
"""Requests of each kind."""
ENDLESS = ("/api/events",)


@pytest.fixture(scope="module")
def asked(
    tmp_path_factory: pytest.TempPathFactory, learned_file: Path
) -> Iterator[tuple[Any, TestClient]]:
    """The description of a server over a copy of the sample data, and a client.

    Jobs are not started: their routes are tried, not their work.
    """
    folder = tmp_path_factory.mktemp("fuzzed")
    copy = Path(shutil.copy(learned_file, folder / "motions.duckdb"))
    for name in ("private", "allowed"):
        (folder / name).mkdir()
    chosen = PageSettings(copy, folders=(folder / "allowed",), warm=False)
    application = make_application(chosen, folder / "private", folder)
    with (
        pytest.MonkeyPatch.context() as patch,
        TestClient(application, base_url=ADDRESS, raise_server_exceptions=False) as client,
    ):
        patch.setattr(Jobs, "start", lambda _self, kind, title, _parameters: Job(kind, title))
        yield schemathesis.openapi.from_dict(application.openapi()), client


def send(client: TestClient, case: Any) -> Any:
    """Send a generated request as a browser's library would."""
    given_ = case.as_transport_kwargs(base_url=ADDRESS)
    prepared = requests.Request(**given_).prepare()
    body = prepared.body.encode() if isinstance(prepared.body, str) else prepared.body
    headers = {
        name: value
        for name, value in prepared.headers.items()
        if name.lower() not in ("content-length", "cookie", "host")
    }
    method, address = prepared.method or "GET", prepared.url or ""
    return client.request(method, address, content=body, headers=headers)


def test_nothing_that_the_description_allows_fails(asked: tuple[Any, TestClient]) -> None:
    schema, client = asked
    tried, failures = 0, []
    for actual in schema.get_all_operations():
        operation = actual.ok()
        if operation.path in ENDLESS:
            continue

        @settings(
            max_examples=EXAMPLES,
            derandomize=True,
            database=None,
            deadline=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(case=operation.as_strategy())
        def try_one(case: Any) -> None:
            nonlocal tried
            answer = send(client, case)
            tried += 1
            if answer.status_code >= 500:
                failures.append((case.method, case.path, answer.status_code, answer.text[:200]))
            elif answer.status_code >= 400:
                assert set(answer.json()["error"]) == {"kind", "message", "status"}

        try_one()
    assert failures == []
    assert tried >= 100
    print(f"{tried} requests")


def test_every_route_says_what_it_does(asked: tuple[Any, TestClient]) -> None:
    _, client = asked
    description = client.get("/api/openapi.json").json()
    assert description["info"]["title"] == "motiondb"
    for path, methods in description["paths"].items():
        for method, facts in methods.items():
            assert facts["description"].endswith("."), (method, path)
            assert {"400", "404", "503"} <= set(facts["responses"])


def test_unknown_routes_and_methods_have_the_form_of_all_errors(
    asked: tuple[Any, TestClient],
) -> None:
    _, client = asked
    for method, path, status in (
        ("GET", "/api/nothing/here", 404),
        ("PATCH", "/api/words", 405),
        ("GET", "/docs", 404),
    ):
        answer = client.request(method, path)
        assert answer.status_code == status
        assert answer.json()["error"]["status"] == status


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"null", b'{"words": "\\ud800"}', b"\xff\xfe", b'{"seed": NaN}']
)
def test_broken_json_is_refused(asked: tuple[Any, TestClient], content: bytes) -> None:
    _, client = asked
    headers = {"content-type": "application/json"}
    answer = client.post("/api/generate", content=content, headers=headers)
    assert answer.status_code == 422
    assert answer.json()["error"]["kind"] == "RequestError"


def test_deeply_nested_json_is_refused(asked: tuple[Any, TestClient]) -> None:
    _, client = asked
    headers = {"content-type": "application/json"}
    content = b'{"words": ' + b"[" * 100_000 + b"]" * 100_000 + b"}"
    assert client.post("/api/generate", content=content, headers=headers).status_code in (400, 422)
