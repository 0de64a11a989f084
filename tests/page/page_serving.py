"""What the tests of the page share."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from starlette.testclient import TestClient

ADDRESS = "http://127.0.0.1:8765"
INDEX = (
    "<!doctype html><html><head><title>motiondb</title>"
    '<link rel="stylesheet" href="app.css"></head><body><main></main>'
    '<script defer src="app.js"></script></body></html>\n'
)


class CheckedClient(TestClient):
    """A client that checks every answer against the description of the interface.

    Attributes
    ----------
    checked : set of (str, str)
        Methods and routes whose JSON answers were checked.
    description : dict
        The description of the interface.
    """

    def __init__(self, application: Any, **options: Any) -> None:
        super().__init__(application, **options)
        self.checked: set[tuple[str, str]] = set()
        self.description = application.openapi()

    def request(self, method: str, url: Any, **options: Any) -> Any:
        answer = super().request(method, url, **options)
        path = str(answer.request.url.path)
        if path == "/api/openapi.json":
            return answer
        if answer.is_success and answer.headers["content-type"] == "application/json":
            route, schema = self.schema_of(method.lower(), path, str(answer.status_code))
            assert faults(schema, answer.json()) == [], (method, path)
            self.checked.add((method.lower(), route))
        return answer

    def schema_of(self, method: str, path: str, status: str) -> tuple[str, dict[str, Any]]:
        """The route of a path, and the schema of its answer."""
        for route, methods in self.description["paths"].items():
            pattern = re.sub(r"\{\w+\}", "[^/]+", route)
            if method in methods and re.fullmatch(pattern, path):
                answer = methods[method]["responses"][status]
                schema = answer["content"]["application/json"]["schema"]
                return route, schema | {"components": self.description["components"]}
        raise AssertionError(f"{method} {path} is not described")


def faults(schema: dict[str, Any], answer: Any) -> list[str]:
    """Where an answer does not fit a schema."""
    import jsonschema_rs

    validator = jsonschema_rs.Draft202012Validator(schema)
    return [
        f"{'/'.join(map(str, e.instance_path))}: {e.message}" for e in validator.iter_errors(answer)
    ]


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
