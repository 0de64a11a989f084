"""``motiondb mcp``: a program does ten tasks over a real process, and nothing that it may not."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb.cli.tools import TOOLS, Tools, shortened

MAIN = "from motiondb.cli.main import main; main()"


class Client:
    """A scripted client: one request after the other."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", MAIN, "mcp", "--db", folder / "motions.duckdb", *words],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self.number = 0

    def line(self, data: bytes) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(data + b"\n")
        self.process.stdin.flush()

    def send(self, method: str, **params: Any) -> int:
        self.number += 1
        asked = {"jsonrpc": "2.0", "id": self.number, "method": method, "params": params}
        self.line(json.dumps(asked).encode())
        return self.number

    def answer(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        told = json.loads(self.process.stdout.readline())
        assert told.pop("jsonrpc") == "2.0"
        return told

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        number = self.send(method, **params)
        told = self.answer()
        assert told["id"] == number
        return told

    def result(self, tool: str, **arguments: Any) -> dict[str, Any]:
        return self.ask("tools/call", name=tool, arguments=arguments)["result"]

    def told(self, tool: str, **arguments: Any) -> Any:
        result = self.result(tool, **arguments)
        assert not result["isError"], result["content"]
        told = json.loads(result["content"][0]["text"])
        assert result["structuredContent"] in (told, {"answer": told})
        return told

    def refused(self, tool: str, **arguments: Any) -> str:
        result = self.result(tool, **arguments)
        assert result["isError"]
        assert "structuredContent" not in result
        return result["content"][0]["text"]

    def end(self) -> tuple[int, bytes]:
        """Exit code, and what was still on standard output."""
        rest, _ = self.process.communicate()
        return self.process.returncode, rest


Start = Callable[..., Client]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    started: list[Client] = []

    def begin(*words: str, version: str = "2025-06-18") -> Client:
        client = Client(tmp_path, *words)
        started.append(client)
        told = client.ask("initialize", protocolVersion=version, capabilities={}, clientInfo={})
        assert told["result"]["protocolVersion"] == version
        client.line(b'{"jsonrpc": "2.0", "method": "notifications/initialized"}')
        return client

    yield begin
    for client in started:
        client.process.kill()
        client.process.communicate()


def test_ten_tasks_of_a_program(
    start: Start, few_copy: Path, tmp_path: Path, samples_folder: Path
) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    shutil.copy(samples_folder / "boris/kick_1.bvh", inside / "theirs.bvh")
    text = (samples_folder / "ana/walk_1.bvh").read_text()
    (inside / "new.bvh").write_text(text.replace("Frame Time: 0.0333", "Frame Time: 0.0400"))
    client = start("--folder", "inside", "--write")

    found = client.told("search", words="kick", limit=3)  # 1 find
    assert found["matches"][0]["capture"] == "boris/kick_1"
    with motiondb.open(few_copy, read_only=True) as db:  # the file is free between calls
        told = motiondb.to_json(motiondb.search_answer(db.search("kick", limit=3), False))
    assert found == told
    assert client.told("show", name="boris/kick_1")["segments"]  # 2 look
    cut = client.told("export", name="boris/kick_1", output="cut.bvh", start=0.5, end=2)  # 3 cut
    assert (cut["frames"], (inside / "cut.bvh").is_file()) == (45, True)
    client.told("export", name="ana/walk_1", output=str(inside / "walk.glb"))  # 4 export
    like = client.told("like", example="theirs.bvh", limit=2)  # 5 like
    assert like["matches"][0]["capture"] == "boris/kick_1"
    words = client.told("describe", example="boris/kick_1")  # 6 describe
    assert any(each["word"] == "kick" for part in words for each in part["words"])
    made = client.told("generate", words="walk, then kick", output="made.bvh")  # 7 generate
    assert made["shown"] is True
    judged = client.told("judge", example="made.bvh", sentence="kick, then walk")
    assert judged["in_order"] is False
    added = client.told("add", folders=["new.bvh"])  # 8 add
    assert added["added"] == ["new"]
    client.told("words_set", name="new", text="a calm walk")  # 9 words
    assert client.told("words_history", name="new")[-1]["words"][0]["words"] == "a calm walk"
    assert client.told("undo")["changed"] == ["new"]  # 10 undo
    assert client.told("undo")["removed"] == ["new"]
    assert client.told("remove", names=["ana/walk_1"], yes=True)["removed"] == ["ana/walk_1"]
    client.told("undo")
    assert client.told("check") == {"faults": []}
    assert client.told("info")["captures"] == 12
    assert client.told("grammar_list") == []
    assert client.end() == (0, b"")


def test_nothing_outside_the_folders_is_read_or_written(
    start: Start, few_copy: Path, tmp_path: Path, samples_folder: Path
) -> None:
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    inside.mkdir()
    outside.mkdir()
    shutil.copy(samples_folder / "ana/walk_1.bvh", outside / "walk.bvh")
    (inside / "link.bvh").symlink_to(outside / "walk.bvh")
    (inside / "dir").symlink_to(outside)
    (inside / "beside.bvh.provenance.json").symlink_to(outside / "beside.json")
    client = start("--folder", "inside", "--write")
    before = sorted(outside.rglob("*"))
    for name in (outside / "walk.bvh", "link.bvh", "dir/walk.bvh", "../outside/walk.bvh"):
        for tool in ("describe", "like"):
            assert "below the folders" in client.refused(tool, example=str(name))
        assert "below the folders" in client.refused("add", folders=[str(name)])
        assert "below the folders" in client.refused("judge", example=f"{name}#a", sentence="walk")
    for name in (outside / "a.bvh", "dir/a.bvh", "../a.bvh", "link.bvh", "inside/../../a.bvh"):
        said = client.refused("export", name="ana/walk_1", output=str(name))
        assert "below the folders" in said
    assert "provenance" in client.refused("generate", words="walk", output="beside.bvh")
    assert "found '.', with 'dir'" in client.refused("add", folders=["."])
    assert sorted(outside.rglob("*")) == before
    none = start()  # no folder is named
    assert "none: start it with --folder" in none.refused("like", example=str(outside / "walk.bvh"))
    assert none.told("like", example="ana/walk_1", limit=1)["matches"]


def test_nothing_is_changed_without_write(start: Start, few_copy: Path, tmp_path: Path) -> None:
    client = start("--folder", ".")
    listed = client.ask("tools/list")["result"]["tools"]
    assert all(tool["annotations"]["readOnlyHint"] for tool in listed)
    names = {tool["name"] for tool in listed}
    assert names == {name.replace(" ", "_") for name, changes in TOOLS.items() if not changes}
    for tool in listed:
        given = set(tool["inputSchema"]["properties"])
        assert not given & {"png", "gif", "html", "export", "output", "save", "force", "db"}
        assert all(each["description"] for each in tool["inputSchema"]["properties"].values())
    told = client.ask("tools/call", name="remove", arguments={"names": ["ana/walk_1"]})
    assert told["error"]["code"] == -32602
    assert "found 'png'" in client.refused("search", words="walk", png="a.png")
    assert not (tmp_path / "a.png").exists()


def test_wrong_calls_are_told_in_sentences(start: Start, few_copy: Path) -> None:
    client = start()
    assert client.refused("search", words="xylophone", exact=True).startswith("query: expected")
    assert client.refused("show", name="nobody")
    assert "expected a integer, found '3'" in client.refused("search", words="walk", limit="3")
    assert "is not in the range" in client.refused("search", words="walk", limit=0)
    assert "Missing argument" in client.refused("search")
    assert client.told("search", words="--help, then walk")["matches"]  # words, no option
    cases = {
        b"{broken": -32700,
        b"\xff\xfe": -32700,
        b"[" * 100_000: -32700,
        b"[]": -32600,
        b'"walk"': -32600,
        b'{"jsonrpc": "2.0", "id": null, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": 7, "method": "tools/sing"}': -32601,
        b'{"jsonrpc": "2.0", "id": 7, "method": "tools/call", "params": [1]}': -32602,
        b'{"jsonrpc": "2.0", "id": 7, "method": "' + b"a" * 5_000_000 + b'"}': -32600,
    }
    for line, code in cases.items():
        client.line(line)
        assert client.answer()["error"]["code"] == code
    client.line(b'{"jsonrpc": "2.0", "id": 9, "result": {}}')  # an answer to nothing
    client.line(b'{"jsonrpc": "2.0", "method": "notifications/unheard_of"}')
    assert client.ask("ping")["result"] == {}


def test_a_cancelled_call_is_not_answered_and_the_next_one_is(start: Start, few_copy: Path) -> None:
    client = start("--write")
    run = client.told("info")["runs"][-1]["run_id"]
    learning = client.send("tools/call", name="learn", arguments={"seed": 3})
    waiting = client.send("tools/call", name="list", arguments={})
    assert client.ask("ping")["result"] == {}  # answered while a call runs
    for number in (waiting, learning):
        asked = {"method": "notifications/cancelled", "params": {"requestId": number}}
        client.line(json.dumps({"jsonrpc": "2.0"} | asked).encode())
    told = client.told("info")  # the next answer is this one's
    assert told["runs"][-1]["run_id"] == run
    assert client.told("search", words="kick", limit=1)["matches"]


def test_an_older_protocol_has_no_structured_content(start: Start, few_copy: Path) -> None:
    client = start(version="2024-11-05")
    assert "structuredContent" not in client.result("info")
    for asked, agreed in (("2025-03-26", "2024-11-05"), ("2099-01-01", "2025-11-25"), ("", None)):
        told = client.ask("initialize", protocolVersion=asked)["result"]["protocolVersion"]
        assert told == (agreed or "2024-11-05")


def test_a_long_answer_is_cut_and_says_so(start: Start, learned_copy: Path) -> None:
    result = start().result("list")
    listed = json.loads(result["content"][0]["text"])
    assert 1 < len(listed) < 101
    assert f"the first {len(listed)} of 101" in result["content"][1]["text"]
    assert shortened({"a": "b" * 100}, 50) == ({"a": "b" * 100}, [])


def test_every_tool_is_a_command(tmp_path: Path) -> None:
    tools = Tools(tmp_path / "a.duckdb", (), writes=True).listed()
    assert len(tools) == len(TOOLS)
    read_only = {tool["name"] for tool in tools if tool["annotations"]["readOnlyHint"]}
    assert "judge" in read_only
    assert "search" not in read_only  # it may draw a picture
    assert all(tool["description"] for tool in tools)
