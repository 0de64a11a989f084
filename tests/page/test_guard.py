"""Who may ask: host, origin, token, size, kind of content; nothing outside the store."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from page_serving import Serve
from starlette.testclient import TestClient

from motiondb.page.guard import POLICY
from motiondb.page.settings import UploadLimits

CHANGES = [
    ("POST", "/api/words", {"capture": "ana/walk_1", "words": "walk"}),
    ("PUT", "/api/captions", {"capture": "ana/walk_1", "words": []}),
    ("POST", "/api/undo", {}),
    ("DELETE", "/api/capture?name=ana/walk_1", None),
    ("POST", "/api/add", {"upload": "u1"}),
    ("POST", "/api/learn", {}),
    ("POST", "/api/made/save", {"id": "m1", "name": "x"}),
    ("POST", "/api/sequences/save", {"id": "q1", "name": "x"}),
    ("POST", "/api/grammars", {"captures": ["ana/walk_1"]}),
    ("DELETE", "/api/grammar?name=g", None),
    ("PUT", "/api/board", {"name": "mine", "text": "x"}),
    ("DELETE", "/api/board?name=mine", None),
    ("POST", "/api/scenes/keep", {"ref": "scene:s1", "name": "x"}),
    ("DELETE", "/api/scene?ref=kept:x", None),
    ("POST", "/api/captures/tags", {"captures": ["ana/walk_1"], "tags": {"mood": "glad"}}),
    ("POST", "/api/selection/add", {"name": "x", "items": [{"ref": "capture:ana/walk_1"}]}),
    ("POST", "/api/selection/take", {"name": "x", "items": [{"ref": "capture:ana/walk_1"}]}),
    ("DELETE", "/api/selection?name=x", None),
    ("POST", "/api/captures/words", {"captures": ["ana/walk_1"], "words": "walk"}),
    ("POST", "/api/captures/remove", {"captures": ["ana/walk_1"]}),
    ("POST", "/api/captures/rename", {"old": "ana/walk_1", "new": "x"}),
    ("PUT", "/api/grammar/rules", {"grammar": "g", "run": 1, "text": "x"}),
    ("PUT", "/api/grammar/terminal", {"grammar": "g", "run": 1, "terminal": "a", "to": "b"}),
    ("POST", "/api/grammar/undo", {"grammar": "g", "run": 1}),
    (
        "POST",
        "/api/grammar/answers",
        {"grammar": "g", "run": 1, "first": "a", "then": "b", "said": "no", "author": "Ana"},
    ),
]


def error_of(answer: object) -> str:
    return answer.json()["error"]["kind"]  # type: ignore[attr-defined]


@pytest.mark.parametrize("host", ["127.0.0.1:8765", "localhost", "[::1]:8765", "LOCALHOST:1"])
def test_the_names_of_this_computer_are_answered(client: TestClient, host: str) -> None:
    assert client.get("/api/jobs", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8765", "127.0.0.1.evil.example", "192.168.1.5", "", "[::"],
)
def test_other_names_are_refused(client: TestClient, host: str) -> None:
    answer = client.get("/api/jobs", headers={"host": host})
    assert (answer.status_code, error_of(answer)) == (403, "HostError")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9999", "file://", "http://[::"]
)
def test_pages_of_other_sites_are_refused(client: TestClient, origin: str) -> None:
    for ask in (client.get, client.post):
        answer = ask("/api/undo", headers={"origin": origin})
        assert (answer.status_code, error_of(answer)) == (403, "OriginError")


def test_the_page_itself_is_answered(client: TestClient) -> None:
    headers = {"origin": "http://127.0.0.1:8765", "sec-fetch-site": "same-origin"}
    assert client.get("/api/jobs", headers=headers).status_code == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_picture_or_a_script_of_another_site_gets_nothing(client: TestClient, site: str) -> None:
    answer = client.get("/api/status", headers={"sec-fetch-site": site})
    assert (answer.status_code, error_of(answer)) == (403, "OriginError")


def test_a_link_of_another_site_may_open_the_page(learned_file: Path, serve: Serve) -> None:
    page = serve(learned_file, read_only=True)
    assert page.get("/", headers={"sec-fetch-site": "cross-site"}).status_code == 200


def test_other_computers_need_the_token(learned_file: Path, serve: Serve) -> None:
    page = serve(learned_file, read_only=True, host="0.0.0.0", token="secret")
    for headers in ({}, {"authorization": "Bearer wrong"}, {"cookie": "motiondb_token=wrong"}):
        for path in ("/api/status", "/", "/?token=wrong", "/api/openapi.json"):
            answer = page.get(path, headers=headers)
            assert (answer.status_code, error_of(answer)) == (401, "TokenError")
    given = {"authorization": "Bearer secret"}
    assert page.get("/api/jobs", headers=given).status_code == 200


def test_the_first_visit_keeps_the_token_in_a_cookie(learned_file: Path, serve: Serve) -> None:
    page = serve(learned_file, read_only=True, host="0.0.0.0", token="secret")
    answer = page.get("/?token=secret", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert page.get("/").status_code == 200
    # a file of the user leads there: browsers send no such cookie along a redirection then
    answer = page.get("/?token=secret", headers={"sec-fetch-site": "cross-site"})
    assert (answer.status_code, answer.headers["refresh"]) == (200, "0; url=/")
    assert answer.headers["set-cookie"].lower() == cookie


def test_a_name_of_the_server_must_be_named_by_the_user(learned_file: Path, serve: Serve) -> None:
    page = serve(
        learned_file, read_only=True, host="0.0.0.0", token="t", allowed_hosts=("lab.local",)
    )
    given = {"authorization": "Bearer t"}
    assert page.get("/api/jobs", headers={"host": "lab.local:1", **given}).status_code == 200
    assert page.get("/api/jobs", headers={"host": "192.168.0.7:1", **given}).status_code == 200
    assert page.get("/api/jobs", headers={"host": "other.local", **given}).status_code == 403


@pytest.mark.parametrize("path", ["/api/jobs", "/api/nothing", "/api/capture"])
def test_every_answer_says_who_may_use_it(client: TestClient, path: str) -> None:
    headers = client.get(path).headers
    assert headers["content-security-policy"] == POLICY
    assert "unsafe-inline" not in POLICY
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert headers["cache-control"] == "no-store"
    assert "access-control-allow-origin" not in headers


def test_refused_requests_have_the_headers_too(client: TestClient) -> None:
    headers = client.get("/api/jobs", headers={"host": "evil.example"}).headers
    assert headers["content-security-policy"] == POLICY


def test_a_form_of_another_site_is_no_change(client: TestClient) -> None:
    answer = client.post("/api/undo", data={"a": "b"})
    assert (answer.status_code, error_of(answer)) == (415, "KindError")
    plain = client.post("/api/undo", content="{}", headers={"content-type": "text/plain"})
    assert plain.status_code == 415


@pytest.mark.parametrize(("method", "path", "body"), CHANGES)
def test_a_read_only_page_changes_nothing(
    client: TestClient, method: str, path: str, body: object
) -> None:
    answer = client.request(method, path, json=body)
    assert (answer.status_code, error_of(answer)) == (403, "ReadOnlyError")


def test_the_routes_that_change_are_all_tried_read_only(client: TestClient) -> None:
    tried = {(method, path.partition("?")[0]) for method, path, _ in CHANGES}
    asks = {
        "/api/search", "/api/generate", "/api/sequences", "/api/sequences/open",
        "/api/sequences/alternatives", "/api/motions", "/api/download", "/api/board/check",
        "/api/scenes", "/api/scenes/update", "/api/uploads", "/api/jobs/{job_id}",
        "/api/grammar/parse",
    }  # fmt: skip
    for path, methods in client.get("/api/openapi.json").json()["paths"].items():
        for method in methods:
            if method != "get" and path not in asks:
                assert (method.upper(), path) in tried


def test_a_large_request_is_refused_by_what_it_says_and_by_what_it_sends(
    learned_file: Path, serve: Serve
) -> None:
    page = serve(learned_file, read_only=True, limits=UploadLimits(body_bytes=1000))
    said = page.post("/api/board/check", json={"text": "x" * 2000})
    assert (said.status_code, error_of(said)) == (413, "TooLargeError")

    def pieces() -> object:
        yield b'{"text": "'
        for _ in range(20):
            yield b"x" * 100
        yield b'"}'

    headers = {"content-type": "application/json"}
    sent = page.post("/api/board/check", content=pieces(), headers=headers)
    assert (sent.status_code, error_of(sent)) == (413, "TooLargeError")


def test_a_large_upload_is_refused(learned_file: Path, serve: Serve) -> None:
    limits = UploadLimits(file_bytes=1000, request_bytes=5000)
    page = serve(learned_file, read_only=True, limits=limits)
    whole = page.post("/api/uploads", files=[("files", ("a.bvh", io.BytesIO(b"x" * 6000)))])
    assert (whole.status_code, error_of(whole)) == (413, "TooLargeError")
    one = page.post(
        "/api/uploads",
        files=[("files", ("a.bvh", b"x" * 2000)), ("files", ("b.bvh", b"x" * 10))],
    )
    assert [file["name"] for file in one.json()["files"]] == ["b.bvh"]
    assert one.json()["refused"][0]["name"] == "a.bvh"


OUTSIDE = [
    "/api/motion?ref=capture:../../../etc/passwd",
    "/api/motion?ref=capture:/etc/passwd",
    "/api/motion?ref=upload:../../etc/passwd",
    "/api/motion?ref=upload:u1/../../../etc/passwd",
    "/api/motion?ref=scene:../..",
    "/api/motion?ref=kept:/etc/passwd",
    "/api/like?ref=capture:/etc/hostname",
    "/api/describe?ref=capture:{own}",
    "/api/download?ref=capture:{own}&format=source",
    "/api/capture?name=/etc/passwd",
    "/api/board?name=../../etc/passwd",
    "/api/board?name=/etc/passwd",
    "/api/folders?root=0&path=/etc",
    "/api/folders?root=-1&path=",
    "/..%2f..%2fetc%2fpasswd",
    "/%2e%2e/settings.py",
    "/app.js%00.html",
    "/../application.py",
]


@pytest.mark.parametrize("path", OUTSIDE)
def test_no_request_reads_a_file_outside_the_store(
    client: TestClient, samples_folder: Path, path: str
) -> None:
    file = samples_folder / "ana" / "walk_1.bvh"
    answer = client.get(path.replace("{own}", str(file)))
    assert answer.status_code in (400, 403, 404)
    assert answer.headers["content-type"] == "application/json"


def test_a_board_reads_no_grammar_of_the_folder_it_runs_in(
    client: TestClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "secret").write_text("this is private")
    (tmp_path / "basketball").write_text("this is private")
    for grammar in ("secret", "basketball"):
        text = f'diagram "D"\ngrammar {grammar}\nattack A1 at 0 8\n1 layup A1\n'
        assert "private" not in client.post("/api/board/check", json={"text": text}).text
    assert client.get("/api/board?name=give-and-go").json()["feasible"]


def test_only_files_of_the_page_are_served(learned_file: Path, serve: Serve, bundle: Path) -> None:
    (bundle / "secret.txt").symlink_to(learned_file)
    (bundle / ".hidden.js").write_text("x")
    page = serve(learned_file, read_only=True)
    assert page.get("/app.css").text == "body { margin: 0 }"
    for name in ("secret.txt", ".hidden.js", "nothing.js", "bundle"):
        assert page.get(f"/{name}").status_code == 404


def test_a_page_that_was_not_built_says_what_to_do(client: TestClient) -> None:
    answer = client.get("/")
    assert answer.status_code == 503
    assert "python build_backend.py" in answer.text
