"""Questions far larger than people ask: each is answered or refused, within 10 s and 1 GB.

Each is asked in a separate process; importing motiondb and opening the database are included.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from motiondb import MotionDB
from robustness_tasks import fuzz
from robustness_tasks.odd_texts import whole_text
from robustness_tasks.reading import READS, Case, Place, writable

_WORDS = ("walk", "jump", "bow", "kick", "turn", "left", "a", "person", "then", "wave")
LONG = 300
"""Characters of a long name: more than file systems allow."""


@dataclass(frozen=True)
class Outcome:
    """A large question: ``answer`` is "answered", "refused" or "failed"; cost as in ``fuzz``."""

    kind: str
    answer: str
    message: str
    seconds: float
    megabytes: float

    @property
    def is_failure(self) -> bool:
        """Whether it failed or cost too much."""
        costly = self.seconds > fuzz.MOST_SECONDS or self.megabytes > fuzz.MOST_MEGABYTES
        return self.answer == "failed" or costly


def sentence(n_words: int) -> str:
    """So many words, in sentences of ten."""
    rng = np.random.default_rng(n_words)
    drawn = rng.choice(_WORDS, n_words).tolist()
    return ". ".join(" ".join(drawn[n : n + 10]) for n in range(0, n_words, 10))


def alternatives(count: int) -> str:
    """A motion grammar whose start symbol has so many alternatives, each of its own terminal."""
    names = [f"act{n}" for n in range(count)]
    lines = ["grammar wide", "start S", f"S -> {' | '.join(f'{name} S' for name in names)} | last"]
    lines += [f'{name} := "walk"' for name in (*names, "last")]
    return "\n".join(lines) + "\n"


def rules(count: int) -> str:
    """A context-free grammar of so many nonterminals with ten alternatives each."""
    lines = [
        f"N{n} -> {' | '.join(f'a{n * 10 + m} N{(n + m + 1) % count}' for m in range(9))} | b"
        for n in range(count)
    ]
    return "\n".join(lines) + "\n"


def _ask(question: Callable[[MotionDB], object], place: Place) -> object:
    with MotionDB(place.database, read_only=True, wait=60.0) as db:
        return question(db)


def _change(change: Callable[[MotionDB], object], place: Place) -> object:
    with writable(place) as db:
        return change(db)


def _sheet(data: bytes, verb: str, place: Place) -> object:
    path = place.folder / "sheet.tsv"
    path.write_bytes(data)
    return _change(lambda db: getattr(db, verb)(path), place)


def _text(kind: str, text: str) -> Callable[[Place], object]:
    return partial(READS[kind], text.encode())


def _letters(number: int) -> str:
    """A number as letters: words hold no digits."""
    return "x" + "".join(chr(ord("a") + int(digit)) for digit in str(number))


def _save(db: MotionDB) -> object:
    made = db.generate("walk")
    return db.captures.save_generated("n" * LONG, "walk", made, 0)


QUESTIONS: Mapping[str, Callable[[Place], object]] = MappingProxyType(
    {
        "search, 2,000 words": partial(_ask, lambda db: db.search(sentence(2_000))),
        "search, 20,000 words": partial(_ask, lambda db: db.search(sentence(20_000))),
        "search by symbols, 2,000 words": partial(
            _ask, lambda db: db.search(sentence(2_000), by_symbols=True)
        ),
        "search, one word of a million letters": partial(_ask, lambda db: db.search("w" * 10**6)),
        "search, a thousand commas": partial(_ask, lambda db: db.search("walk," * 1_000)),
        "search, limit of a billion": partial(_ask, lambda db: db.search("walk", limit=10**9)),
        "generate, 2,000 words": partial(_ask, lambda db: db.generate(sentence(2_000))),
        "generate, 100 words": partial(_ask, lambda db: db.generate(sentence(100))),
        "words set, 20,000 words": partial(
            _change, lambda db: db.words.set("ana/bow_1", sentence(20_000))
        ),
        "filter of 2,000 conditions": partial(
            _ask, lambda db: db.captures(" and ".join(["fps>1"] * 2_000))
        ),
        "motion grammar of 1,000 alternatives": _text("motion grammar", alternatives(1_000)),
        "grammar of 1,000 alternatives": _text("grammar", rules(100)),
        "grammar of 10,000 alternatives": _text("grammar", rules(1_000)),
        "actions, 5,000": _text("actions", "run " * 5_000),
        "actions, 400": _text("actions", "hold " + "dribble " * 200 + "pass " + "run " * 198),
        "terminals, 5,000": _text("terminals", "a b " * 2_500),
        "tactics of 2,000 steps": _text(
            "tactics",
            whole_text("screen.tactics")
            + "".join(f"{n} run A2 to {n % 7} {n % 11}\n" for n in range(5, 2_005)),
        ),
        "a kept name of 300 characters": partial(_change, _save),
        "a capture's name of 300 characters": partial(
            _ask, lambda db: db.captures.show("n" * LONG)
        ),
        "an example's name of 300 characters": partial(_ask, lambda db: db.like("n" * LONG)),
        "a grammar's name of 300 characters": partial(
            _change, lambda db: db.grammars.learn(["boris/long_2"], "n" * LONG)
        ),
        "a sheet's name of 300 characters": partial(
            _change, lambda db: db.words.import_sheet("n" * LONG)
        ),
        "a sheet that is a lone quote": partial(_sheet, b'"', "import_words"),
        "events that are a lone quote": partial(_sheet, b'"', "import_events"),
        "synonyms, a chain of 20,000": partial(
            _sheet, "".join(f"{_letters(n)} = {_letters(n + 1)}\n" for n in range(20_000)).encode(),
            "set_synonyms",
        ),
        "a sheet of 100,000 rows": partial(
            _sheet, ("file\twords\n" + "ana/bow_1\tbow\n" * 100_000).encode(), "import_words"
        ),
    }
)  # fmt: skip


def run(database: Path) -> Iterator[Outcome]:
    """Ask all, one after the other."""
    for kind, question in QUESTIONS.items():
        with tempfile.TemporaryDirectory() as folder:
            place = Place(Path(folder), database)
            outcomes = fuzz.read_beside(Case(kind, question), place)
        answer = "answered" if outcomes.result == "read" else outcomes.result
        yield Outcome(kind, answer, outcomes.message, outcomes.seconds, outcomes.megabytes)
