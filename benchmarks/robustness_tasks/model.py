"""Chains of random steps, by two processes and a server, compared with a plain model.

A seed is a chain of steps on one database: every verb of the class, in random order and with
random arguments. Some steps are disturbed: the process or the server is killed at a random system
call or right after its answer, the disk is full from a random system call on, the clock jumps by
days or years (with the times of the files), the database, its cache or a folder has other rights
for the length of a step, or both processes change the database at once. After
each step the database is looked into, and must be one of the worlds that
:mod:`robustness_tasks.plain_model` allows: with every change that was acknowledged, and one that
was interrupted wholly or not at all. After each disturbed step, and now and then, ``check`` must
find nothing, and the counts of the learned model must be those of the words that are there. Files
that steps write are the old ones or the new ones. At the end no file and no process is left over.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import shutil
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import numpy as np

from motiondb.errors import MotionDBError
from robustness_tasks.databases import SAMPLES, import_everything
from robustness_tasks.model_processes import CALLS, CLOSED, Answer, Harm, Server, Worker
from robustness_tasks.model_verbs import DB, MATCHES, OTHER, SCENE, Hand
from robustness_tasks.plain_model import DONE, REFUSED, UNKNOWN, Step, futures
from robustness_tasks.plain_world import Change, Kept, Words, World, difference
from robustness_tasks.random_steps import SHORTEST, Chooser, Material, choose

STEPS = 200
"""Steps of a chain."""
CUTS = ("ana/walk_1", "ana/bow_1", "ana/jump_1", "boris/kick_1", "ana/wave_1", "boris/punch_1",
        "dora/idle_1", "emil/jump_1", "fatou/run_1")  # fmt: skip
"""Captures of the sample data of which the material has a piece."""
LEARNED_EVERY = 20
"""Of this many chains, one begins with a database that has learned; its steps take longer."""
SEVERAL_THREADS_EVERY = 4
"""Of this many chains, DuckDB has several threads in one; with one, a step takes half the time."""
HARMS = {"": 0.91, "kill": 0.05, "late kill": 0.01, "full disk": 0.01, "clock": 0.01,
         "rights": 0.01}  # fmt: skip
"""How often what goes wrong."""
UNFORESEEN = ("full disk", "rights")
"""Where the database may refuse what it else would not."""
LOOK_CLOSELY = 0.005
"""How often ``check`` runs after a step that nothing disturbed."""


@dataclass(frozen=True)
class Outcome:
    """What became of a step.

    Attributes
    ----------
    seed, step : the chain, and the number of the step in it.
    kind, by : the verb, and who did it.
    harm : what went wrong meanwhile; "at once" where the other process did something too.
    ended : "done", "refused" or "unknown"; for the latter ``happened`` says what was found.
    happened : whether an interrupted step was found done.
    faults : what did not hold.
    """

    seed: int
    step: int
    kind: str
    by: str
    harm: str
    ended: str
    happened: bool
    faults: tuple[str, ...]

    @property
    def is_failure(self) -> bool:
        """Whether anything did not hold."""
        return bool(self.faults)


def run(seeds: Sequence[int], database: Path, processes: int = 1) -> Iterator[Outcome]:
    """Run a chain for each seed; what all chains use is made once and kept beside the database.

    Processes part from this one, and each runs its share of the chains.
    """
    material = prepared(database.with_name("model"))
    import_everything()
    warm_up(material)
    fork = multiprocessing.get_context("fork")
    running, told = [], []
    for number in range(processes):
        here, there = fork.Pipe(duplex=False)
        share = seeds[number::processes]
        running.append(fork.Process(target=_run_chains, args=(share, material, there)))
        running[-1].start()
        there.close()
        told.append(here)
    try:
        while told:
            for each in wait(told):
                assert isinstance(each, Connection)
                try:
                    yield each.recv()
                except EOFError:
                    told.remove(each)
    finally:
        for process in running:
            process.terminate()


def _run_chains(seeds: Sequence[int], material: Material, told: Connection) -> None:
    """Run a chain for each seed, and tell what becomes of every step."""
    try:
        for seed in seeds:
            for outcome in chain(seed, material):
                told.send(outcome)
    except BaseException:  # the usual end would wait for processes that wait for this one
        traceback.print_exc()
        os._exit(1)


def prepared(folder: Path) -> Material:
    """The material, a learned database and a made scene; after changes of the code, make it anew.

    The scene is a pickle, whose classes may have moved: remove the folder then.
    """
    if not (folder / SCENE).exists():
        new = folder.with_name(f"{folder.name}-{os.getpid()}")
        material = tiny(new)
        _learn(new, material)
        new.rename(folder)
    return tiny(folder)


def tiny(folder: Path) -> Material:
    """Captures of about half a second, cut out of the sample data; made if missing."""
    from motiondb import read_capture, write_bvh
    from motiondb.database.catalogue.parts import cut_clip

    folder.mkdir(exist_ok=True, parents=True)
    seconds = {}
    for number, name in enumerate(CUTS):
        path = folder / f"t{number}.bvh"
        if not path.exists():
            clip = read_capture(SAMPLES / "captures" / f"{name}.bvh")
            write_bvh(cut_clip(clip, 0.2, 0.2 + SHORTEST + 0.1 * (number % 3)), path)
        seconds[path.stem] = read_capture(path).duration
    players = ("A1",) if (folder / SCENE).exists() else ()
    return Material(folder, seconds, players, _other(folder, list(seconds)[:4]))


def _other(folder: Path, names: Sequence[str]) -> dict[str, Kept]:
    """Make a database to merge with some captures, their words, tags and events."""
    import motiondb

    if not (folder / OTHER).exists():
        sheet = folder / "events.tsv"
        rows = [f"{name}\t{number}\tcontact\n" for number, name in enumerate(names)]
        sheet.write_text(f"file\tframe\tevent\n{''.join(rows)}")
        new = folder / f"{os.getpid()}.duckdb"
        with motiondb.open(new) as db:
            for name in names:
                db.add(folder / f"{name}.bvh")
                db.words.set(name, f"from elsewhere, {name}")
            db.captures.import_events(sheet)
            db.captures.set_tags({"performer": "zoe", "studio": "other"}, names[1:])
            shutil.rmtree(db.store.path.with_name(f"{new.name}.cache"), ignore_errors=True)
        new.rename(folder / OTHER)
    with motiondb.open(folder / OTHER, read_only=True) as db:
        infos, captions, events = db.captures(), db.words.all_captions(), db.captures.all_events()
    return {
        i.name: Kept(
            i.kind,
            i.sha256,
            dict(i.tags),
            tuple((c.words, c.start, c.end) for c in captions[i.capture_id]),
            tuple((e.frame, e.name) for e in events[i.capture_id]),
        )
        for i in infos
    }


def _learn(folder: Path, material: Material) -> None:
    """Make the learned database and the scene."""
    import pickle

    import motiondb
    from motiondb import GrammarSettings, LearnSettings, SceneSettings

    (folder / "s.grammar").write_text('grammar s\nstart S\nS -> walk | walk S\nwalk := "walk"\n')
    diagram = 'diagram "S"\ngrammar s\ncourt half\n\nattack A1 at 0.0 8.4\n\n'
    (folder / "s.tactics").write_text(f"{diagram}1 walk A1 to 0.0 6.0\n")
    with motiondb.open(folder / DB) as db:
        for number, name in enumerate(material.seconds):
            db.add(folder / f"{name}.bvh")
            db.words.set(name, ("walk", "bow", "jump", "kick")[number % 4])
        db.learn(LearnSettings(n_symbols=2))
        names = sorted(material.seconds)
        db.grammars.learn(names[:4], "moves", GrammarSettings(n_terminals=2, sentences="captures"))
        settings = SceneSettings(rounds=1, tries=1, chains=1)
        scene = db.scenes.make(folder / "s.tactics", settings)
    (folder / SCENE).write_bytes(pickle.dumps(scene))


def warm_up(material: Material) -> None:
    """Do a few verbs in this process, so that those that part from it need not load."""
    with tempfile.TemporaryDirectory() as folder:
        hand = Hand(Path(folder), material.folder)
        name = next(iter(material.seconds))
        hand.db.add(material.folder / f"{name}.bvh")
        hand.db.words.set(name, "a slow walk")
        hand.db.export(name, Path(folder) / "one.glb")
        hand.look(thorough=True)
        hand.close()
        if not (material.folder / DB).exists():
            return
        shutil.copy(material.folder / DB, hand.path)
        hand.do("ask", {"words": "walk", "name": name})
        hand.do("show", {"name": name})
        hand.db.words.set(name, "a slow walk")
        grammar = hand.db.grammars.names()[0]
        hand.do("save sequence", {"grammar": grammar, "seed": 0, "name": "sung"})
        hand.do("ask grammar", {"name": grammar})
        hand.close()


class Chain:
    """One database, those who use it, and the world that must be in it."""

    def __init__(self, seed: int, material: Material, place: Path) -> None:
        self.rng = np.random.default_rng([seed, 11])
        self.material, self.place = material, place
        threads = 2 if seed % SEVERAL_THREADS_EVERY == 0 else 1
        self.workers = [Worker(name, place, material.folder, threads) for name in ("one", "two")]
        self.server = Server(place, threads)
        self.holder = self.workers[0]
        self.world, self.revision = World(), 0
        self.drafts: set[str] = set()  # left by kills
        self.cut: set[str] = set()  # rescued databases of which a kill left drafts
        self.answers: dict[str, object] = {}
        for name in ("given", "out", "tmp"):
            (place / name).mkdir()
        if seed % LEARNED_EVERY == LEARNED_EVERY - 1 and (material.folder / DB).exists():
            shutil.copy(material.folder / DB, place / DB)
            self._take_over()

    def _take_over(self) -> None:
        """Begin with what is in the database."""
        facts = self.holder.do("look", {"thorough": True}).facts["facts"]
        self.world = World(
            {name: Kept(*values) for name, values in facts["captures"].items()},
            facts["synonyms"], facts["vocabulary"],
            {name: values[0] for name, values in facts["grammars"].items()},
            {}, facts["scenes"],
        )  # fmt: skip
        begun = self.holder.do("begin").facts
        for name, number in begun["numbers"].items():
            self.world.captures[name].number = number
        now = {kept.number: (name, kept) for name, kept in self.world.captures.items()}
        for serial, (kind, edits) in enumerate(begun["runs"], start=1):
            before = {
                number: None
                if edit == "added"
                else (name, replace(now[number][1], captions=_said(captions)))
                for number, edit, name, _, captions in edits
            }
            names = tuple(name for _, _, name, *_ in edits)
            self.world.history.append(Change(serial, kind, names, before, frozenset()))
        self.world.latest = len(begun["runs"])
        self.world.numbers = max(begun["numbers"].values())

    def step(self, number: int) -> tuple[str, str, str, str, bool, list[str]]:
        """One step: verb, by whom, harm, how it ended, whether it happened, faults."""
        by = self._next()
        chooser = Chooser(self.world, self.rng, self.place, self.material, number)
        verb, given = choose(chooser, by.name)
        harm = self._harm()
        if harm.kind == "clock":
            self._age_files(harm.seconds)
        if harm.kind == "" and isinstance(by, Worker) and self.rng.random() < 0.015:
            return self._at_once(verb, given, chooser)
        if isinstance(by, Server):
            self._rest()
            answer = by.do(verb, given, harm)
        else:
            then = str(self.rng.choice(["", "close"])) if harm.kind else ""
            if harm.kind == "rights" and self.rng.random() < 0.7:
                self._rest()
            by.begin(verb, given, then, harm)
            answer = by.end(harm)
        step = Step(verb, given, answer.ended, by.name, answer.message)
        if verb == "rescue" and answer.ended == UNKNOWN:
            self.cut.add(given["file"])  # the next rescue of this name would delete them
        faults = [*answer.faults, *self._told(verb, given, answer)]
        is_gone = harm.kind in ("kill", "late kill") or answer.ended == UNKNOWN
        is_foreseen = harm.kind not in UNFORESEEN
        found, more = self._compared([step], is_foreseen, is_gone or harm.kind != "")
        if is_gone and isinstance(by, Server):
            self.world.edits.clear()
        happened = answer.ended == UNKNOWN and found
        return verb, by.name, harm.kind, answer.ended, happened, faults + more

    def _next(self) -> Worker | Server:
        """Who comes next: mostly the one that holds the database."""
        draw = self.rng.random()
        if draw < 0.88:
            return self.holder
        if draw < 0.94:
            self._rest()
            self.holder = self.workers[1 - self.workers.index(self.holder)]
            return self.holder
        return self.server

    def _rest(self) -> None:
        """Let the one that holds the database give it back."""
        self.holder.do("rest", {}, str(self.rng.choice(["close", "lend"])))

    def _harm(self) -> Harm:
        kind = str(self.rng.choice(list(HARMS), p=list(HARMS.values())))
        call = str(self.rng.choice(list(CALLS)))
        count = int(self.rng.integers(1, (CALLS[call] if kind == "kill" else 4) + 1))
        room = int(np.exp(self.rng.uniform(0.0, np.log(300_000.0))))
        days = float(self.rng.choice([-9000.0, -1.0, 0.02, 1.0, 9000.0]))
        closed = CLOSED[self.rng.integers(len(CLOSED))] if kind == "rights" else ()
        return Harm(kind, call, count, room, 86_400.0 * days, closed) if kind else Harm()

    def _age_files(self, seconds: float) -> None:
        """Let files have been written before, or after, the clock jumped."""
        for path in self.place.rglob("*"):
            if path.is_file():
                status = path.stat()
                os.utime(path, (status.st_atime, max(status.st_mtime + seconds, 0.0)))

    def _at_once(
        self, verb: str, given: dict[str, Any], chooser: Chooser
    ) -> tuple[str, str, str, str, bool, list[str]]:
        """Both processes change the database at the same moment."""
        self._rest()
        again = Chooser(self.world, self.rng, self.place, self.material, chooser.number + 10**6)
        other, others = choose(again, self.workers[1].name)
        for worker, what, with_what in zip(self.workers, (verb, other), (given, others)):
            worker.begin(what, with_what, "close")
        answers = [worker.end() for worker in self.workers]
        steps = [
            Step(what, with_what, answer.ended, worker.name, answer.message)
            for what, with_what, answer, worker in zip(
                (verb, other), (given, others), answers, self.workers
            )
        ]
        faults = [fault for answer in answers for fault in answer.faults]
        _, more = self._compared(steps, True, True)
        return verb, "both", "at once", answers[0].ended, False, faults + more

    def _told(self, verb: str, given: dict[str, Any], answer: Answer) -> list[str]:
        """What is wrong with an answer."""
        expected: dict[str, object] = {}
        facts, world = answer.facts, self.world
        if verb == "list":
            names = sorted(world.captures)
            tags: dict[str, Any] = {name: kept.tags for name, kept in world.captures.items()}
            found = [n for n in names if dict(tags[n]).get("performer") == given["performer"]]
            expected = {"names": names, "found": found, "browsed": names[::-1]}
        elif verb == "remove":
            expected = {"removed": given["names"]}
        elif verb == "show":
            said = world.captures[given["name"]].captions if facts else ()
            counts = [len(world.captures)]
            expected = {"said": said, "counts": counts, "events": [], "found": given["name"]}
        elif verb in ("rescue", "backup") and facts:
            rescued = {n: [k.digest, len(k.captions)] for n, k in world.captures.items()}
            expected = {"rescued": rescued, "wrong": []}
        elif verb in ("edit rules", "export matches"):
            expected = {"wrong": []}
        elif verb.startswith("ask") and "answer" in facts:
            known = self.answers.setdefault(f"{verb} {given}", facts["answer"])
            expected = {"answer": known}
        wrong = [difference(expected[key], facts[key], key) for key in expected if key in facts]
        return [f"answered otherwise: {told[:600]}" for told in wrong if told]

    def _compared(
        self, steps: list[Step], is_undisturbed: bool, closely: bool
    ) -> tuple[bool, list[str]]:
        """Whether anything changed, and how the database differs from what may be in it."""
        closely = closely or self.rng.random() < LOOK_CLOSELY
        if closely:
            self._rest()
            self.holder = self.workers[self.rng.integers(2)]
        looked = self.holder.do("look", {"thorough": closely})
        if looked.ended != DONE:
            return False, [f"looking fails: {looked.message}", *looked.faults]
        files, drafts = self._files()
        seen = {**looked.facts["facts"], "files": files}
        faults = [*looked.faults, *looked.facts["wrong"]]
        worlds = list(futures(self.world, steps, is_undisturbed))
        if not worlds:
            told = "; ".join(
                f"{s.verb} {dict(s.arguments)} {s.ended} {s.message}".strip() for s in steps
            )
            faults.append(f"no world in which this can be: {told}")
        differences = [difference(world.facts(), seen) for world in worlds]
        if worlds and "" not in differences:
            told = "; ".join(f"{s.verb} {dict(s.arguments)} {s.ended}" for s in steps)
            where = " or else ".join(sorted(set(differences)))
            faults.append(f"the database differs: {where}; after {told}")
        revision = looked.facts["revision"]
        if revision < self.revision:
            faults.append(f"the revision went back from {self.revision} to {revision}")
        has_changed = revision != self.revision
        if has_changed:
            self.answers.clear()
        faults += self._left_over(drafts, steps)
        if any(step.verb == "export matches" for step in steps):
            faults += self._torn()
        self.revision = revision
        if "" in differences:
            before = self.world.facts()
            self.world = worlds[differences.index("")]
            self.world.learn_from(seen)
            has_changed = bool(difference(before, self.world.facts())) or has_changed
        return has_changed, faults

    def _files(self) -> tuple[dict[str, str], set[str]]:
        """Digests of the files that steps wrote, but matches, and the names of drafts."""
        out = self.place / "out"
        paths = {p.relative_to(out).as_posix(): p for p in out.rglob("*") if p.is_file()}
        drafts = {name for name, path in paths.items() if path.name.startswith(".")}
        return {
            name: hashlib.sha256(path.read_bytes()).hexdigest()
            for name, path in paths.items()
            if name not in drafts and not name.startswith(MATCHES)
        }, drafts

    def _torn(self) -> list[str]:
        """Matches, and the files beside them, that are not whole."""
        from motiondb import read_capture

        torn = []
        for path in (self.place / "out" / MATCHES).glob("[!.]*"):
            try:
                json.loads(path.read_text()) if path.suffix == ".json" else read_capture(path)
            except (ValueError, MotionDBError) as error:
                torn.append(f"not whole: {path.name}: {error}")
        return torn

    def _left_over(self, drafts: set[str], steps: list[Step]) -> list[str]:
        """Drafts that no kill left, and those that a later writing of the file should remove."""
        cut = any(step.ended == UNKNOWN for step in steps)
        written = [file for s in steps if s.ended == DONE for file in s.arguments.get("files", ())]
        written = [file for file in written if isinstance(file, str)]
        faults = [] if cut else [f"left over: {name}" for name in drafts - self.drafts]
        faults += [
            f"left over: {d}" for d in drafts for file in written if d[1:].startswith(f"{file}.")
        ]
        self.drafts = drafts
        return faults

    def end(self) -> list[str]:
        """End all processes; what is left that should not be."""
        faults = self.server.kill()
        self.holder.do("rest", {}, "close")  # the next opening removes the note of one that waited
        answer = self.holder.do("set synonyms", {"file": self._no_synonyms()}, "close")
        faults += [*answer.faults, *([answer.message] if answer.ended == REFUSED else [])]
        for worker in self.workers:
            worker.do("rest", {}, "close")
            worker.kill()
        usual = {"given", "out", "tmp", DB, f"{DB}.cache", "boards"}
        names = {path.name for path in self.place.iterdir()} - usual
        left = [n for n in sorted(names) if not n.lstrip(".").startswith((*self.cut,))]
        return faults + [f"left over: {name}" for name in left]

    def _no_synonyms(self) -> str:
        (self.place / "given" / "none.txt").write_text("")
        return "given/none.txt"


def _said(captions: Sequence[Any] | None) -> tuple[Words, ...]:
    return tuple((c.words, c.start, c.end) for c in captions or ())


def chain(seed: int, material: Material, steps: int = STEPS) -> Iterator[Outcome]:
    """The steps of a chain; it ends at the first step after which something does not hold."""
    with tempfile.TemporaryDirectory(prefix="motiondb-model-") as folder:
        at = Chain(seed, material, Path(folder))
        for number in range(steps):
            kind, by, harm, ended, happened, faults = at.step(number)
            if faults or number == steps - 1:
                faults += at.end()
            yield Outcome(seed, number, kind, by, harm, ended, happened, tuple(faults))
            if faults:
                break
