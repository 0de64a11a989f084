"""Every command of motiondb: those that write, which are killed, and those that only ask.

``tests/robustness/test_commands.py`` compares both lists with ``motiondb --help``, so that a new
command has to be put into one of them; and it runs the commands that only ask, and finds the
folder as it was.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE, Popen
from types import MappingProxyType

import motiondb
from robustness_tasks.databases import GRAMMAR, SAMPLES, copy_captures

DB = "motions.duckdb"
KEPT = "kept"
"""The selection that commands change; it is made when the folder is prepared."""
SITE = "SITE"
"""Stands for the address of the site that ``fetch cmu`` downloads from."""
MARK = ("words", "set", "ana/jump_1", "a marked jump", "--db", DB)
NEXT = ("words", "set", "ana/walk_1", "a later walk", "--db", DB)
SCENE = (
    "scene", "make", "stroll.tactics", "-o", "kept", "--rounds", "2", "--no-pictures",
    "--name", "kept_scene", "--db", DB,
)  # fmt: skip
"""Makes the scene that commands change; run when the folder is prepared."""

COMMANDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "add": ("add", "more", "--words", "more/captions.tsv"),
        "add one": ("add", "more/ana/wave_1.bvh"),
        "backup": ("backup", "copy.duckdb"),
        "compact": ("compact",),
        "compare": ("compare", "ana/walk_1", "boris/walk_1", "--png", "compared.png"),
        "coverage": ("coverage", "--png", "coverage.png"),
        "curate": ("curate", "--share", "30%", "-o", "chosen"),
        "describe": ("describe", "ana/walk_1", "-o", "told.csv"),
        "events import": ("events", "import", "events.tsv"),
        "export": ("export", "boris/long_2", "-o", "out.glb"),
        "fetch cmu": ("fetch", "cmu", "--subjects", "90", "--yes", "--base-url", SITE,
                      "--dir", "cmu"),
        "generate": ("generate", "walk", "-o", "made.bvh", "--save", "made", "--png", "made.png"),
        "grammar edit": (
            "grammar", "edit", GRAMMAR, "kept", "--at", "2", "--choose", "1", "--save", "edited",
            "-o", "edited.bvh", "--png", "edited.png",
        ),
        "grammar generate": (
            "grammar", "generate", GRAMMAR, "-o", "new.glb", "--length", "10", "--save", "new",
            "--png", "new.png",
        ),
        "grammar learn": (
            "grammar", "learn", "boris/long_2", "chidi/long_3", "--terminals", "4",
            "--name", "other",
        ),
        "grammar parse": ("grammar", "parse", GRAMMAR, "kept", "--png", "tree.png"),
        "grammar remove": ("grammar", "remove", GRAMMAR),
        "grammar ask": ("grammar", "ask", GRAMMAR, "--answer", "a b unknown", "--author", "Ana"),
        "grammar rename": ("grammar", "rename", GRAMMAR, "b", "second"),
        "grammar show": ("grammar", "show", GRAMMAR, "--png", "grammar.png"),
        "grammar undo": ("grammar", "undo", GRAMMAR),
        "join": (
            "join", "ana/walk_1:0-1", "boris/kick_1:0-1", "-o", "joined.bvh", "--png", "joined.png",
        ),
        "joints": ("joints", "ana/walk_1", "-o", "walk.map"),
        "knowledge export": ("knowledge", "export", "known.knowledge"),
        "learn": ("learn", "--symbols", "3"),
        "like": ("like", "boris/kick_1", "--png", "like.png"),
        "along": ("along", "0,0 0,2 -1,2", "--words", "walk"),
        "rhythm": ("rhythm", "0 .5 1 1.5", "--words", "walk", "--limit", "3"),
        "merge": ("merge", "other.duckdb"),
        "quality": ("quality", "ana/walk_1", "--png", "lacks.png", "--boxes", "needs.json"),
        "remove": ("remove", "ana/bow_1", "boris/kick_1"),
        "rename": ("rename", "ana/bow_1", "ana/bowing"),
        "rescue": ("rescue", DB, "-o", "rescued.duckdb"),
        "scene draw": ("scene", "draw", "stroll.tactics", "-o", "drawn.png"),
        "scene make": (
            "scene", "make", "stroll.tactics", "-o", "new_scene", "--rounds", "2",
            "--no-pictures", "--name", "new_scene", "--seed", "1",
        ),
        "scene make pictures": (
            "scene", "make", "stroll.tactics", "-o", "new_scene", "--rounds", "2",
        ),
        "scene remove": ("scene", "remove", "kept_scene"),
        "scene report": ("scene", "report", "kept", "--png", "paths.png"),
        "scene update": (
            "scene", "update", "kept", "further.tactics", "--no-pictures", "--name", "other_scene",
            "--seed", "2",
        ),
        "search": ("search", "walk", "--png", "hits.png"),
        "selections add": ("selections", "add", KEPT, "ana/walk_1:0-1", "boris/kick_1"),
        "selections export": ("selections", "export", KEPT, "-o", "pack"),
        "selections remove": ("selections", "remove", KEPT),
        "selections take": ("selections", "take", KEPT, "ana/bow_1"),
        "show": ("show", "ana/walk_1", "--png", "shown.png"),
        "symbols": ("symbols", "--png", "symbols.png"),
        "tags set": ("tags", "set", "ana/bow_1", "mood=calm"),
        "undo": ("undo",),
        "words export": ("words", "export", "sheet.tsv"),
        "words import": ("words", "import", "words.tsv"),
        "words set": ("words", "set", "ana/bow_1", "bow to the audience", "--keep"),
        "words synonyms": ("words", "synonyms", "synonyms.txt"),
    }
)  # fmt: skip
"""Kind -> words of each command that writes; ``--db`` is added, but to ``rescue``. A kind is the
command's name, where one command writes in several ways with a word more."""
ASKING: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "batch": ("batch", "questions.txt"),
        "check": ("check",),
        "diff": ("diff", "other.duckdb"),
        "events show": ("events", "show", "ana/walk_1"),
        "grammar compare": ("grammar", "compare", GRAMMAR),
        "grammar list": ("grammar", "list"),
        "grammar rules": ("grammar", "rules", GRAMMAR),
        "grammar suggest": ("grammar", "suggest", GRAMMAR),
        "info": ("info",),
        "judge": ("judge", "ana/walk_1", "walk"),
        "knowledge show": ("knowledge", "show", "cmu"),
        "list": ("list",),
        "scene grammar check": ("scene", "grammar", "check", "basketball"),
        "scene list": ("scene", "list"),
        "scene suggest": ("scene", "suggest", "basketball", "hold"),
        "sql": ("sql", "SELECT 1"),
        "scene validate": ("scene", "validate", "basketball", "hold pass run catch layup"),
        "selections show": ("selections", "show", KEPT),
        "words history": ("words", "history", "ana/bow_1"),
    }
)
"""Command -> words with which it asks. They take no option that writes a file."""
NOT_ATTACKED = ("serve", "mcp", "evaluate", "demo")
"""``serve`` and ``mcp`` do not end by themselves, and tests of their own attack them; ``evaluate``
only asks, of a database that has learned from a part of its captures; ``demo`` is ``add`` and
``learn``, which are attacked."""
WITHOUT_DATABASE = ("rescue", "scene grammar check", "scene report", "scene suggest",
                    "scene validate")  # fmt: skip
"""Commands that take no ``--db``, or not needed."""
FILE_OPTIONS = ("-o", "--out", "--output", "--png", "--dir")
SAVE_OPTIONS = ("--save", "--name")


def words_of(kind: str) -> tuple[str, ...]:
    """The words of a command that writes, or asks."""
    words = COMMANDS[kind] if kind in COMMANDS else ASKING[kind]
    return words if kind in WITHOUT_DATABASE else (*words, "--db", DB)


def again_of(kind: str) -> tuple[str, ...]:
    """The words that write the same files once more, and keep nothing; () where none is written."""
    words = words_of(kind)
    if not set(words) & set(FILE_OPTIONS):
        return ()
    dropped = {n + k for n, word in enumerate(words) if word in SAVE_OPTIONS for k in (0, 1)}
    return tuple(word for n, word in enumerate(words) if n not in dropped)


def prepare(base: Path, database: Path) -> None:
    """Make a folder with the database and everything that commands read."""
    base.mkdir()
    shutil.copy(database, base / DB)
    with motiondb.open(base / DB) as db:
        db.selections.add(KEPT, ["ana/bow_1", "ana/jump_1:0-1"])
    if Path(f"{database}.cache").is_dir():
        shutil.copytree(f"{database}.cache", base / f"{DB}.cache")
    names = ("ana/wave_1", "boris/punch_1", "dora/idle_1", "emil/jump_1", "fatou/run_1")
    copy_captures(names, base / "more")
    (base / "words.tsv").write_text(
        "file\twords\tperformer\nana/bow_1\tbow low\tann\nboris/kick_1\tkick high\tbob\n"
    )
    shutil.copy(database, base / "other.duckdb")
    (base / "questions.txt").write_text("walk\nkick or punch\n")
    (base / "synonyms.txt").write_text("stroll = walk\nleap = jump\n")
    (base / "stroll.grammar").write_text(
        'grammar stroll\nstart S\nS -> walk | walk S\nwalk := "walk"\n'
    )
    diagram = 'diagram "Stroll"\ngrammar stroll\ncourt half\n\nattack A1 at 0.0 8.4\n\n'
    (base / "stroll.tactics").write_text(f"{diagram}1 walk A1 to 0.0 4.0\n")
    (base / "further.tactics").write_text(f"{diagram}1 walk A1 to 2.0 2.0\n")
    head, *rows = (SAMPLES / "events.tsv").read_text(encoding="utf-8").splitlines()
    kept = [row for row in rows if row.startswith(("ana/walk_1", "boris/kick_1"))]
    (base / "events.tsv").write_text("\n".join([head, *kept]) + "\n")


def with_site(words: tuple[str, ...], url: str) -> tuple[str, ...]:
    """The words with the address of the site."""
    return tuple(url if word == SITE else word for word in words)


@contextmanager
def site() -> Iterator[str]:
    """A site in the layout of the CMU database, in a process of its own; gives its address."""
    program = [sys.executable, "-c", _SITE.format(path=sys.path)]
    with Popen(program, stdin=PIPE, stdout=PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdin is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.stdin.close()  # it ends


_SITE = """
import sys
sys.path[:0] = {path!r}
from cmu_site import Site, page, serve
from odd_captures import AMC, ASF

ASKED = "/search.php?subjectnumber=90"
files = {{"/subjects/90/90.asf": ASF.encode()}}
for trial in range(1, 9):
    files[f"/subjects/90/90_{{trial:02d}}.amc"] = AMC.replace("17 2", f"17 {{trial}}").encode()
files[ASKED] = page(90, [(trial, f"walk {{trial}}", 120) for trial in range(1, 9)]).encode()
with serve(Site(files)) as found:
    print(found.url, flush=True)
    sys.stdin.read()
"""


def leaves(command: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, object]]:
    """All commands of a Typer command line with their names, groups gone through."""
    below: Mapping[str, object] | None = getattr(command, "commands", None)
    if below is None:
        yield " ".join(path), command
        return
    for name, each in below.items():
        yield from leaves(each, (*path, name))
