"""README and the guide are tests: their commands say what they show, their Python is true."""

from __future__ import annotations

import doctest
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import readme_blocks as readme
import typer

from motiondb.body import body, joint_names
from motiondb.files.folder import CAPTURE_ENDINGS
from motiondb.files.formats import capture_format

TEXT = readme.README.read_text(encoding="utf-8")
FORMATS = (readme.ROOT / "docs" / "guide" / "formats.md").read_text(encoding="utf-8")
EXAMPLES = readme.every_example()
STARTING = [e for e in EXAMPLES if "--db mine.duckdb" in e.command]
MAKING = [
    e for e in EXAMPLES if re.match(r"motiondb (add|learn)\b", e.command) and e not in STARTING
]
LEARNED = [e for e in EXAMPLES if e.command.startswith("motiondb grammar ")]
"""They build on one another: the first learns the grammar that the others ask."""
SCENES = [e for e in EXAMPLES if e.command.startswith(("motiondb scene ", "motiondb events "))]
"""The first makes the scene that the others report."""
ALONE = [e for e in EXAMPLES if e not in [*STARTING, *MAKING, *LEARNED, *SCENES]]


@pytest.fixture(scope="module")
def place(learned_file: Path) -> Iterator[Path]:
    """A folder to work in, with a copy of the database that the first examples make."""
    with readme.workplace() as folder:
        shutil.copy(learned_file, folder / "motions.duckdb")
        yield folder


DECIMAL = re.compile(r"[-+]?\d+\.\d+")
SECONDS = re.compile(r"(sampling|polishing) [\d.]+ s")  # other on every machine


def _differences(expected: str, actual: str) -> list[str]:
    """Lines in which an output differs from the page's, the whole of it, word by word.

    Decimals may differ by 0.02 or by 2 %: sums of floating point numbers do between processors.
    Everything else is the same: names, whole numbers, the number of lines and columns.
    """
    shown, came = (SECONDS.sub("", text).splitlines() for text in (expected, actual))
    if shown and shown[-1] == "...":
        shown = shown[:-1]
        came = came[: len(shown)]
    wrong = [f"expected {len(shown)} lines, found {len(came)}"] if len(shown) != len(came) else []
    for one, other in zip(shown, came):
        a, b = (re.sub(r" +", " ", DECIMAL.sub("#", line)).strip() for line in (one, other))
        pairs = zip(map(float, DECIMAL.findall(one)), map(float, DECIMAL.findall(other)))
        if a != b or any(abs(x - y) > max(0.02, 0.02 * abs(x)) for x, y in pairs):
            wrong.append(f"expected {one!r}, found {other!r}")
    return wrong


def _check(example: Any, place: Path) -> None:
    code, out, err = readme.run(example.command)
    assert code == 0, err
    unknown = [line for line in err.splitlines() if "; left out" in line]
    assert _differences(example.output, "\n".join([*unknown, out])) == []
    for written in re.findall(r"(?:-o|--png|--strings) (\S+)", example.command):
        assert (place / written).stat().st_size > 1000


def test_the_first_commands_make_the_database(learned_file: Path) -> None:
    """The database of all tests is made by them, with events besides; here is what they said."""
    said = json.loads(learned_file.with_name("said.json").read_text())
    assert [example.command for example in MAKING] == list(said)
    for example in MAKING:
        told = said[example.command].replace("  1592 events added with them\n", "")
        assert _differences(example.output, told) == []


def test_a_folder_without_words_is_searched_with_a_start() -> None:
    with readme.workplace() as place:
        for example in STARTING:
            _check(example, place)


@pytest.mark.parametrize("example", ALONE, ids=[e.command for e in ALONE])
def test_commands_say_what_readme_shows(place: Path, example: Any) -> None:
    _check(example, place)


def test_commands_of_grammars_say_what_readme_shows(place: Path) -> None:
    for example in LEARNED:
        _check(example, place)


def test_commands_of_scenes_say_what_the_guide_shows(place: Path) -> None:
    for example in SCENES:
        _check(example, place)


def test_python_is_true(place: Path) -> None:
    text = "\n".join(readme.blocks("pycon", TEXT))
    case = doctest.DocTestParser().get_doctest(text, {}, "README.md", "README.md", 0)
    runner = doctest.DocTestRunner(verbose=False)
    runner.run(case)
    assert runner.tries > 5
    assert runner.failures == 0


def test_the_joint_map_of_the_guide_fits_a_strange_skeleton(tmp_path: Path) -> None:
    """A sample capture whose legs are named as in the guide's map is refused without the map."""
    (text,) = readme.blocks("ini", FORMATS)
    pairs = dict(line.split(" = ") for line in text.splitlines() if " = " in line)
    names = {"hip": "UpLeg", "knee": "Leg", "ankle": "Foot", "toe": "ToeBase"}
    source = (readme.ROOT / "sample_data/captures/ana/walk_1.bvh").read_text()
    for role, strange in pairs.items():
        usual = ("Left" if role[0] == "l" else "Right") + names[role[2:]]
        assert f"JOINT {usual}\n" in source
        source = source.replace(f"JOINT {usual}\n", f"JOINT {strange}\n")
    (tmp_path / "studio.map").write_text(text)
    (tmp_path / "takes").mkdir()
    (tmp_path / "takes" / "walk.bvh").write_text(source)
    add = f"motiondb add {tmp_path}/takes --db {tmp_path}/strange.duckdb"
    code, _, err = readme.run(add)
    assert code == 1
    assert "expected joints for l_hip, l_knee, l_ankle, r_hip, r_knee, r_ankle" in err
    code, out, err = readme.run(f"{add} --joint-map {tmp_path}/studio.map")
    assert code == 0, err
    assert out.startswith("1 capture added")


def test_every_command_stands_in_the_table() -> None:
    from motiondb.cli.main import make_app

    commands = (readme.ROOT / "docs" / "guide" / "commands.md").read_text(encoding="utf-8")
    rows = "\n".join(line.split("|")[1] for line in commands.splitlines() if line.startswith("| `"))
    told = set(re.findall(r"`([a-z]+(?: [a-z]+)?)", rows))
    known: set[str] = set()
    for name, command in typer.main.get_command(make_app()).commands.items():
        known |= {f"{name} {sub}" for sub in getattr(command, "commands", {})} or {name}
    assert known - told == set()


def test_every_format_and_convention_stands_in_the_guide() -> None:
    for ending in CAPTURE_ENDINGS:
        assert f"`{ending}`" in FORMATS, capture_format(f"x{ending}")
    special = {
        "MotionBuilder without toes and hands": "without toes and hands",
        "MotionBuilder with two spines": "with two spines",
        "motiondb": "motiondb",
    }
    for name in joint_names.CONVENTIONS:
        assert special.get(name, name) in FORMATS
    for role in body.JOINTS:
        assert role.removeprefix("l_").removeprefix("r_") in FORMATS


def test_links_lead_somewhere() -> None:
    pages = [*readme.ROOT.glob("*.md"), *readme.ROOT.glob("docs/**/*.md")]
    links = [
        (page, target)
        for page in pages
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    ]
    assert [f"{p.name}: {t}" for p, t in links if not (p.parent / t).exists()] == []
