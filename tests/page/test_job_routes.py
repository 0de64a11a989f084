"""Long work in processes of its own: progress, results, cancelling."""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path
from typing import Any

from page_serving import Serve, get, post, refused
from starlette.testclient import TestClient

import motiondb
from motiondb.page.jobs import Job, Worker


def ended(client: TestClient, job: dict[str, Any]) -> dict[str, Any]:
    """The job when it is over, followed by its events as a browser does."""
    with client.stream("GET", f"/api/jobs/{job['id']}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        lines = [line for line in stream.iter_lines() if line]
    names = [line.removeprefix("event: ") for line in lines if line.startswith("event: ")]
    facts = [json.loads(line.removeprefix("data: ")) for line in lines if line.startswith("data: ")]
    assert names[0] == "job"
    assert set(names[1:-1]) <= {"progress"}
    assert names[-1] == "job"
    last: dict[str, Any] = facts[-1]
    assert last["state"] in ("done", "failed", "cancelled")
    assert get(client, f"/api/jobs/{job['id']}")["state"] == last["state"]
    return last


def uploaded(client: TestClient, *files: tuple[str, bytes]) -> str:
    answer = client.post("/api/uploads", files=[("files", file) for file in files])
    upload: str = answer.json()["upload"]
    return upload


def test_uploaded_captures_are_added_with_their_words(
    tmp_path: Path, serve: Serve, samples_folder: Path
) -> None:
    client = serve(tmp_path / "new.duckdb")
    data = (samples_folder / "ana" / "walk_1.bvh").read_bytes()
    sheet = b"file\twords\tperformer\nana/walk\ta person walks\tana\n"
    upload = uploaded(
        client, ("ana/walk.bvh", data), ("words.tsv", sheet), ("bad.bvh", b"HIERARCHY\nrubbish")
    )
    job = ended(client, post(client, "/api/add", {"upload": upload, "words": "words.tsv"}))
    assert job["state"] == "done", job
    assert (job["result"]["added"], job["result"]["captures"]) == (1, ["ana/walk"])
    assert any("bad.bvh" in problem for problem in job["result"]["problems"])
    assert "/uploads/" not in json.dumps(job)
    facts = get(client, "/api/capture", name="ana/walk")
    assert facts["words"][0]["words"] == "a person walks"
    again = ended(client, post(client, "/api/add", {"upload": upload, "words": None}))
    assert (again["result"]["added"], again["result"]["known"]) == (0, 1)


def test_a_folder_that_the_user_allowed_is_added(tmp_path: Path, serve: Serve, some: Path) -> None:
    client = serve(tmp_path / "new.duckdb", folders=(some,))
    (some / "out").symlink_to(tmp_path)
    listed = get(client, "/api/folders", root=0)
    assert (listed["folders"], listed["captures"]) == (["ana", "boris"], 0)
    for path in ("..", "out", "ana/../..", "/etc", "\0"):
        assert client.get("/api/folders", params={"root": 0, "path": path}).status_code == 404
    body = {"folder": {"root": 0, "path": "ana"}}
    job = ended(client, post(client, "/api/add", body))
    assert job["result"]["captures"] == ["bow_1", "jump_1"]
    assert client.post("/api/add", json={"folder": {"root": 1}}).status_code == 403
    assert client.post("/api/add", json={}).status_code == 400


def test_links_out_of_an_allowed_folder_are_named_and_not_read(
    tmp_path: Path, serve: Serve, some: Path
) -> None:
    shutil.rmtree(some / "boris")  # few enough to be read by the process of the job itself
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "secret.bvh").write_text("SECRET words")
    (outside / "take.json").write_text('{"Frames": "SECRET"}')
    (some / "a.bvh").symlink_to(outside / "secret.bvh")
    (some / "b.json").symlink_to(outside / "take.json")
    (some / "words.tsv").symlink_to(outside / "secret.bvh")
    (some / "deep").symlink_to(outside)
    (some / "loop.bvh").symlink_to("loop.bvh")
    client = serve(tmp_path / "new.duckdb", folders=(some,))
    for path in ("words.tsv", "loop.bvh"):
        body = {"folder": {"root": 0}, "words": path}
        assert client.post("/api/add", json=body).status_code == 404
    result = ended(client, post(client, "/api/add", {"folder": {"root": 0}}))["result"]
    why = "expected a file inside the folder, found a link that leads out of it."
    assert result["problems"] == [
        f"{name}: {why} Copy the file into the folder." for name in ("a.bvh", "b.json")
    ]
    assert result["captures"] == ["ana/bow_1", "ana/jump_1"]
    assert "SECRET" not in json.dumps(result)
    assert {note.partition(":")[0] for note in result["notes"]} >= {"deep", "loop.bvh"}


def test_a_job_that_fails_says_why(tmp_path: Path, serve: Serve) -> None:
    client = serve(tmp_path / "new.duckdb")
    job = ended(client, post(client, "/api/learn", {}))
    assert (job["state"], job["error_kind"]) == ("failed", "MotionDBError")
    assert "captures" in job["message"]


def test_a_job_whose_process_dies_does_not_say_that_nothing_was_saved(tmp_path: Path) -> None:
    worker, job = Worker(tmp_path / "new.duckdb", True, tmp_path), Job("add", "add captures")
    worker._process.kill()
    worker.run(job, {})
    worker.stop()
    assert job.message == (
        "add captures: expected the work to end, found that its process ended with code -9. What "
        "was saved before stays, nothing is half saved. Try again; there may be too little memory."
    )


def test_a_job_that_is_cancelled_before_it_begins_stays_so(tmp_path: Path) -> None:
    """Its worker was stopped, which must not be told as a failure."""
    job, worker = Job("learn", "learn"), Worker(tmp_path / "m.duckdb", False, tmp_path)
    job.end("cancelled", "cancelled")
    worker.stop()
    worker.run(job, {})
    assert (job.state, job.message) == ("cancelled", "cancelled")


def test_learning_starts_from_shipped_knowledge_and_from_no_file(
    learned_copy: Path, serve: Serve
) -> None:
    client = serve(learned_copy)
    starts = client.get("/api/status").json()["starts"]
    assert [(one["name"], one["words"]) for one in starts] == [("cmu", 167)]
    assert "mocap.cs.cmu.edu" in starts[0]["credit"]
    refused = client.post("/api/learn", json={"start": str(learned_copy)})
    assert refused.status_code == 400
    assert refused.json()["error"]["message"].startswith(
        "learn: expected a start of cmu, none, found "
    )


def test_a_cancelled_job_leaves_the_database_as_it_was(learned_copy: Path, serve: Serve) -> None:
    client = serve(learned_copy)
    before = get(client, "/api/status")
    job = post(client, "/api/learn", {"seed": 5})
    deadline = time.monotonic() + 60.0
    while get(client, f"/api/jobs/{job['id']}")["state"] == "waiting":
        assert time.monotonic() < deadline
        time.sleep(0.02)
    gone = client.delete(f"/api/jobs/{job['id']}").json()
    assert gone["state"] == "cancelled"
    assert client.delete(f"/api/jobs/{job['id']}").json()["state"] == "cancelled"
    after = get(client, "/api/status")
    assert (after["revision"], after["symbols"]) == (before["revision"], before["symbols"])
    with motiondb.open(learned_copy, wait=30.0) as db:
        assert db.check() == []


def test_jobs_are_listed_newest_first_for_a_page_that_is_loaded_again(
    tmp_path: Path, serve: Serve
) -> None:
    client = serve(tmp_path / "new.duckdb")
    first = ended(client, post(client, "/api/learn", {}))
    second = ended(client, post(client, "/api/learn", {"seed": 1}))
    assert [job["id"] for job in get(client, "/api/jobs")["jobs"]] == [second["id"], first["id"]]
    refused(client, "/api/jobs/j0", 404)


def reached(client: TestClient, job: dict[str, Any], *steps: str) -> None:
    """Wait until a job is at one of some steps."""
    deadline = time.monotonic() + 300.0
    while not (now := get(client, f"/api/jobs/{job['id']}"))["what"].startswith(steps):
        assert now["state"] in ("waiting", "running"), now
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_words_are_kept_and_captures_added_while_a_scene_is_made(
    learned_copy: Path, serve: Serve, samples_folder: Path
) -> None:
    """And jobs that change the database wait for each other, and say so."""
    client = serve(learned_copy)
    drawn = 'diagram "Two"\ngrammar basketball\nattack A1 at 0 7\n1 shoot A1\n'
    scene = post(client, "/api/scenes", {"text": drawn, "rounds": 10_000, "chains": 1})
    second = post(client, "/api/scenes", {"text": drawn})
    reached(client, second, "waits for: scene of Two")
    reached(client, scene, "sampling")
    preview = get(client, f"/api/jobs/{scene['id']}")["preview"]
    assert client.get("/api/motion", params={"ref": preview}).content.startswith(b"MDBM")
    post(client, "/api/captures/words", {"captures": ["ana/bow_1"], "words": "bow deeply"})
    assert get(client, f"/api/jobs/{scene['id']}")["state"] == "running"
    new = (samples_folder / "ana" / "walk_1.bvh").read_bytes() + b"\n"
    upload = uploaded(client, ("new/walk.bvh", new))
    learning = post(client, "/api/learn", {})
    adding = post(client, "/api/add", {"upload": upload})
    reached(client, adding, "waits for: learn")
    client.delete(f"/api/jobs/{learning['id']}")
    assert ended(client, adding)["result"]["added"] == 1


def test_a_worker_that_dies_is_told(tmp_path: Path) -> None:
    from motiondb.page.jobs import Jobs

    (tmp_path / "work").mkdir()
    jobs = Jobs(tmp_path / "new.duckdb", False, tmp_path / "work")
    job = jobs.start("nonsense", "nonsense", {})
    deadline = time.monotonic() + 60.0
    while not job.is_over:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert job.state == "failed"
    assert job.error_kind == "ProgramError"
    jobs.close()
