"""``learn``: load the captures, compute, save all results or none."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryFile
from typing import BinaryIO, cast

from motiondb import store
from motiondb.database.learn.start import find_start, load_knowledge
from motiondb.database.loading import features_in, keep_what_follows
from motiondb.database.session import damage_sentence
from motiondb.database.values import seeded
from motiondb.errors import MotionDBError, QueryError, StoreError
from motiondb.learn import fitting
from motiondb.learn.checking import LEAST_CHECKING
from motiondb.learn.knowledge import Knowledge, begin
from motiondb.learn.learned import performers_of
from motiondb.learn.learned_model import LearnedModel, to_stored
from motiondb.learn.recognition import FeaturePool, LearnSettings, Progress
from motiondb.learn.word_fitting import TaughtWords
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.workers import HERE, Workers

SHIPPED = "cmu"  # The knowledge that comes with motiondb
_ATTEMPTS = 3  # How often to learn from the beginning where captures change meanwhile


def learn(
    opened: store.Store,
    settings: LearnSettings,
    progress: Progress | None = None,
    start: str | Path | Knowledge | None = None,
    where: str = "",
    workers: Workers = HERE,
) -> LearnedModel:
    """Derive everything from the captures that were captured (not generated), and save it.

    `where`: Filter on the catalogue: only these.

    `start`: What to start from (:func:`motiondb.database.learn.start.find_start`). None: the
    start that the database used when it learned before, if any; else the shipped one where few
    captures are described (:func:`is_hardly_described`).
    """
    tell = progress or (lambda _what, _share: None)
    store.check_writable(opened)
    knowledge = find_start(opened, start, settings)
    for _ in range(_ATTEMPTS):
        with _beside(opened.path) as file:
            with store.released(opened) as let_go:
                tell("features", 0.0)
                pool, taught, numbers = _load_taught(opened, where, file, workers)
                let_go()
                rng = seeded(settings.seed)
                as_usual = replace(settings, seed=0) == LearnSettings()  # one's own symbols, else
                if start is knowledge is None and as_usual and is_hardly_described(taught):
                    knowledge = load_knowledge(SHIPPED)
                started = None if knowledge is None else begin(knowledge, taught.synonyms)
                renumbered = fitting.renumber_taught(taught, numbers)
                with one_blas_thread():  # a second one takes a fifth more of the processors
                    model = fitting.fit_model(
                        pool, renumbered, settings, rng, tell, started, workers
                    )
                own_numbers = {number: capture for capture, number in numbers.items()}
                model = fitting.renumber_model(model, own_numbers)
            with store.transaction(opened):
                now = _load_catalogue(opened, where)
                is_same = vars(now) == vars(taught)  # motions never change
                if is_same:
                    model = _save(opened, settings, model, tell, where)
            if is_same:
                keep_what_follows(opened, model, pool, numbers)
                return model
        tell("captures changed, again", 0.0)
    raise MotionDBError(
        f"{opened.path}: expected captures and words to stay as they are while learning, found "
        f"them changed by others in {_ATTEMPTS} attempts. Nothing was changed; run motiondb learn "
        f"again when no other process changes the database."
    )


def _beside(path: Path) -> BinaryIO:
    """A file without a name beside a database, for the features of its captures."""
    try:
        return cast(BinaryIO, TemporaryFile(dir=path.parent))
    except OSError as error:
        raise MotionDBError(
            f"{path.parent}: expected a folder in which learning can write, found: "
            f"{error.strerror}. Some 40 MB an hour of motion are needed while it learns."
        ) from error


def is_hardly_described(taught: TaughtWords) -> bool:
    """Whether a few captures are described, and most are not.

    What these few say, all others would be told to show: with one of eight captures described
    "bow", all eight answered "bow" at .94.
    """
    n = sum(map(bool, taught.captions.values()))
    return 0 < n < LEAST_CHECKING and 2 * n < len(taught.performers)


def _save(
    opened: store.Store, settings: LearnSettings, model: LearnedModel, tell: Progress, where: str
) -> LearnedModel:
    tell("saving", 0.0)
    parameters = {**asdict(settings), **({"where": where} if where else {})}
    if model.started is not None:
        origin = model.started.knowledge.origin
        parameters["start"] = {"name": origin.name, "sha256": origin.digest}
    with store.running(opened, "learn", parameters, settings.seed) as run_id:
        model = replace(model, run_id=run_id)
        store.save_learning(opened, to_stored(model))
    return model


def _load_taught(
    opened: store.Store, where: str, file: BinaryIO, workers: Workers
) -> tuple[FeaturePool, TaughtWords, dict[int, int]]:
    """Features, captions and numbers while learning of the captured captures, of one revision."""
    with store.reading(opened):
        taught = _load_catalogue(opened, where)
        if not taught.performers and where:
            raise QueryError(
                f"learn: expected captures that match {where!r}, found none. Give another filter."
            )
        if not taught.performers:
            raise MotionDBError(
                f"{opened.path}: expected captures to learn from, found none. "
                "Add some first: motiondb add FOLDER."
            )
        names = {i.capture_id: i.name for i in store.load_captures(opened)}
        names = {capture: names[capture] for capture in taught.performers}
        numbers = fitting.numbers_by_name(names)
        pool = features_in(file, opened, numbers, workers)
        if damaged := [names[n] for n, number in numbers.items() if number not in pool.places]:
            raise StoreError(damage_sentence(opened.path, damaged))
        return pool, taught, numbers


def _load_catalogue(opened: store.Store, where: str) -> TaughtWords:
    """Performers and captions of the captured captures that match a filter."""
    infos = store.load_captures(opened, where)
    captured = {i.capture_id: i for i in infos if i.is_captured}
    captions = {c: v for c, v in store.load_captions(opened).items() if c in captured}
    return TaughtWords(captions, store.load_synonyms(opened), performers_of(captured))
