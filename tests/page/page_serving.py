"""What the tests of the page share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from starlette.testclient import TestClient

ADDRESS = "http://127.0.0.1:8765"
INDEX = (
    "<!doctype html><html><head><title>motiondb</title>"
    '<link rel="stylesheet" href="app.css"></head><body><main></main>'
    '<script type="module" src="app.js"></script></body></html>\n'
)


Serve = Callable[..., TestClient]


def get(client: TestClient, path: str, **query: Any) -> Any:
    """The JSON of an answer that must be right."""
    answer = client.get(path, params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


def post(client: TestClient, path: str, body: Any, method: str = "POST") -> Any:
    """The JSON of an answer to a body that must be right."""
    answer = client.request(method, path, json=body)
    assert answer.status_code in (200, 202), answer.text
    return answer.json()


def refused(client: TestClient, path: str, status: int, **query: Any) -> str:
    """The message of an answer that must be refused."""
    answer = client.get(path, params=query)
    assert answer.status_code == status, answer.text
    return str(answer.json()["error"]["message"])
