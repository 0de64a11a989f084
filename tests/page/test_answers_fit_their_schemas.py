"""Every answer of the interface fits the schema that the description gives for it.

The clients of all tests of the page check their answers (``page_serving.CheckedClient``). Here
every route is asked once, and no route may be left out.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from page_serving import ADDRESS, CheckedClient, faults, get, post
from test_job_routes import ended

from motiondb.page.app import make_application
from motiondb.page.motion import read_tracks
from motiondb.page.settings import PageSettings

WALK = 'diagram "A walk"\ngrammar basketball\nattack A1 at 0 8\n1 walk A1 to 0 6\n'
ASKED = (
    ("/api/status", {}),
    ("/api/captures", {"limit": 1000}),
    ("/api/facets", {}),
    ("/api/capture", {"name": "ana/long_1"}),
    ("/api/duplicates", {}),
    ("/api/vocabulary", {}),
    ("/api/undo", {}),
    ("/api/search", {"q": "walk or run but not jump, then kick twice for at least 1 s"}),
    ("/api/search", {"q": '"walk, turn left, then sit down"'}),
    ("/api/search", {"q": "walk, kick", "by_symbols": True}),
    ("/api/search", {"q": "stroll with the left hand slowly"}),
    ("/api/like", {"ref": "capture:ana/long_1", "start": 1, "end": 3}),
    ("/api/describe", {"ref": "capture:ana/long_1"}),
    ("/api/symbols", {}),
    ("/api/symbol", {"symbol": 1}),
    ("/api/grammars", {}),
    ("/api/boards", {}),
    ("/api/board", {"name": "give-and-go"}),
    ("/api/board/kinds", {}),
    ("/api/scenes", {}),
    ("/api/folders", {}),
    ("/api/jobs", {}),
)  # fmt: skip


@pytest.fixture(scope="module")
def everything(
    tmp_path_factory: pytest.TempPathFactory, learned_file: Path, samples_folder: Path
) -> Iterator[CheckedClient]:
    """A server that may change a copy of the sample data."""
    pytest.importorskip("jsonschema_rs")
    folder = tmp_path_factory.mktemp("schemas")
    copy = Path(shutil.copy(learned_file, folder / "motions.duckdb"))
    (folder / "private").mkdir()
    chosen = PageSettings(copy, folders=(samples_folder / "ana",), warm=False)
    application = make_application(chosen, folder / "private", folder)
    with CheckedClient(application, base_url=ADDRESS) as client:
        yield client


def change_words(client: CheckedClient) -> None:
    post(client, "/api/words", {"capture": "ana/bow_1", "words": "bow low"})
    words = [{"words": "bow", "start": 0.0, "end": 1.0}]
    post(client, "/api/captions", {"capture": "ana/bow_1", "words": words}, "PUT")
    post(client, "/api/undo", {})


def generate(client: CheckedClient) -> None:
    made = post(client, "/api/generate", {"words": "a person walks then kicks", "variants": 2})
    first = made["variants"][0]["id"]
    get(client, "/api/made", id=first)
    post(client, "/api/made/save", {"id": first, "name": "made/one"})
    get(client, "/api/capture", name="made/one")
    assert client.delete("/api/capture", params={"name": "made/one"}).json() == {
        "removed": ["made/one"]
    }


def edit_a_sequence(client: CheckedClient) -> None:
    body = {"captures": ["fatou/long_play_2", "chidi/long_play_1"], "name": "play"}
    assert ended(client, post(client, "/api/grammars", body))["state"] == "done"
    get(client, "/api/grammar", name="play")
    made = post(client, "/api/sequences", {"grammar": "play"})
    get(client, "/api/sequence", id=made["id"])
    post(client, "/api/sequences/alternatives", {"id": made["id"], "at": 1})
    post(client, "/api/sequences/save", {"id": made["id"], "name": "played"})
    post(client, "/api/sequences/open", {"capture": "played"})
    assert client.delete("/api/grammar", params={"name": "play"}).json()["removed"] == "play"


def make_a_scene(client: CheckedClient) -> None:
    post(client, "/api/board/check", {"text": WALK})
    post(client, "/api/board/check", {"text": "no diagram"})
    post(client, "/api/board", {"name": "walk", "text": WALK}, "PUT")
    assert client.delete("/api/board", params={"name": "walk"}).json() == {"removed": "walk"}
    job = ended(client, post(client, "/api/scenes", {"text": WALK, "rounds": 2}))
    scene = job["result"]["ref"]
    get(client, "/api/scene", ref=scene)
    moved = {"scene": scene, "text": WALK.replace("0 8", "0.5 8")}
    updated = ended(client, post(client, "/api/scenes/update", moved))
    assert updated["state"] == "done"
    check_first_motion(client, updated["preview"])
    kept = post(client, "/api/scenes/keep", {"ref": scene, "name": "kept"})["ref"]
    get(client, "/api/scene", ref=kept)
    get(client, "/api/scenes")
    assert client.delete("/api/scene", params={"ref": kept}).json()["removed"] == "kept"


def check_first_motion(client: CheckedClient, first: str) -> None:
    """The first motion of an update can be played, and nothing else can be done with it."""
    assert first.startswith("first:s")
    answer = client.get("/api/motion", params={"ref": first})
    (track,) = read_tracks(answer.content)
    assert (track.name, track.ref, track.team) == ("A1", first, "attack")
    assert abs(track.points[0, 0, 0] - 0.5) < 1.5  # near where the changed diagram begins, metres
    assert client.get("/api/motion", params={"ref": "first:s0000000000"}).status_code == 404
    assert client.get("/api/download", params={"ref": first}).status_code == 400


def add_and_learn(client: CheckedClient, some: Path) -> None:
    """Add a file and a folder; what the jobs do is tested elsewhere."""
    files = [("files", ("bow.bvh", (some / "ana" / "bow_1.bvh").read_bytes()))]
    upload = client.post("/api/uploads", files=files).json()["upload"]
    job = post(client, "/api/add", {"upload": upload})
    get(client, f"/api/jobs/{job['id']}")
    assert ended(client, job)["state"] == "done"
    started = post(client, "/api/learn", {})
    assert client.delete(f"/api/jobs/{started['id']}").json()["state"] == "cancelled"


def test_every_route_answers_as_its_schema_says(everything: CheckedClient, some: Path) -> None:
    for path, query in ASKED:
        get(everything, path, **query)
    change_words(everything)
    generate(everything)
    edit_a_sequence(everything)
    make_a_scene(everything)
    add_and_learn(everything, some)
    described = {
        (method, path)
        for path, methods in everything.description["paths"].items()
        for method, facts in methods.items()
        for status, answer in facts["responses"].items()
        if status[0] == "2" and "application/json" in answer.get("content", {})
    }
    assert described - everything.checked == set()


def test_every_route_describes_its_answer(everything: CheckedClient) -> None:
    for path, methods in everything.description["paths"].items():
        for method, facts in methods.items():
            (success,) = [code for code in facts["responses"] if code[0] == "2"]
            content = facts["responses"][success]["content"]
            assert all(each["schema"] for each in content.values()), (method, path)


def test_an_answer_that_does_not_fit_is_noticed(everything: CheckedClient) -> None:
    _, schema = everything.schema_of("get", "/api/undo", "200")
    assert faults(schema, {"left": 1, "capture": None}) == []
    for wrong in ({"left": 1}, {"left": "1", "capture": None}, {"left": 1, "capture": 2, "x": 0}):
        assert faults(schema, wrong)
