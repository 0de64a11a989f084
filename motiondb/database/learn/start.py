"""Knowledge to start from: found by name or file, exported, and its share in a database.

Knowledge that is shipped with motiondb lies in ``motiondb/files/NAME.knowledge``.
"""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from motiondb import answers, store
from motiondb.database.session import Session
from motiondb.errors import KnowledgeError, QueryError, suggestion
from motiondb.files import knowledge_file
from motiondb.learn.codec import from_values
from motiondb.learn.joining import fits, start_weight, strange_share
from motiondb.learn.knowledge import Knowledge, Started
from motiondb.learn.knowledge_making import make_knowledge
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import LearnSettings

NONE = "none"  # Name that means no start
ENDING = ".knowledge"
_RUN = ("kind", "seed", "version")  # of a run, what does not depend on the machine or the day


def shipped_names() -> list[str]:
    """Names of the knowledge that is shipped with motiondb, sorted."""
    files = resources.files("motiondb.files").iterdir()
    return sorted(f.name.removesuffix(ENDING) for f in files if f.name.endswith(ENDING))


def shipped_starts() -> list[dict[str, Any]]:
    """Facts of the knowledge that is shipped with motiondb: its origin, and number of words."""
    facts = []
    for name in shipped_names():
        file = resources.files("motiondb.files").joinpath(f"{name}{ENDING}")
        origin, words = knowledge_file.read_summary(file.read_bytes(), file.name)
        facts.append({**origin.facts(), "name": name, "words": len(words)})
    return facts


def load_knowledge(what: str | Path) -> Knowledge:
    """Knowledge by the name of a shipped file, or from another file.

    Parameters
    ----------
    what : str or Path
        A shipped name, or the path of a file.

    Raises
    ------
    KnowledgeError
        When there is neither, or the file is not sound.
    """
    names = shipped_names()
    if str(what) in names:
        file = resources.files("motiondb.files").joinpath(f"{what}{ENDING}")
        return knowledge_file.from_bytes(file.read_bytes(), file.name)
    if not _is_there(Path(what)):
        raise KnowledgeError(
            f"{what}: expected a file of knowledge or one of {', '.join([*names, NONE])}, found "
            f"neither.{suggestion(str(what), names)} motiondb knowledge export FILE writes one."
        )
    return knowledge_file.read_knowledge(what)


def _is_there(path: Path) -> bool:
    """Whether there is a file, or something that may not be looked at."""
    try:
        return path.exists()
    except PermissionError:
        return True
    except OSError:  # a name that is too long
        return False


def find_start(
    opened: store.Store, start: str | Path | Knowledge | None, settings: LearnSettings
) -> Knowledge | None:
    """What ``learn`` starts from; None if it starts from nothing.

    `start`: A shipped name, a file, knowledge itself or "none"; None means the start that the
    database used before.
    """
    if isinstance(start, Knowledge):
        knowledge: Knowledge | None = start
    elif start is not None:
        knowledge = None if str(start) == NONE else load_knowledge(start)
    else:
        knowledge = _former_start(opened)
    if knowledge is not None and settings.n_symbols is not None:
        raise QueryError(
            f"learn: expected a number of symbols or the start {knowledge.origin.name!r}, found "
            f"both. A start brings its own symbols; --start {NONE} learns symbols from the "
            f"captures."
        )
    return knowledge


def _former_start(opened: store.Store) -> Knowledge | None:
    with store.reading(opened):
        values = store.load_parameters(opened, "started") if store.is_learned(opened) else {}
    return from_values(Started, values, "started").knowledge if values else None


def export(
    opened: store.Store, learned: Learned, path: str | Path, name: str, credit: str
) -> Knowledge:
    """Write what was learned from own captions as knowledge; parameters as ``export_knowledge``."""
    runs = [run for run in store.load_runs(opened) if run.kind == "learn"][-1:]
    facts = [{key: getattr(run, key) for key in _RUN} for run in runs]
    label = name or Path(path).name.removesuffix(ENDING)
    knowledge = make_knowledge(learned, label, facts, credit, runs[-1].version)
    knowledge_file.write_knowledge(knowledge, path)
    return knowledge_file.read_knowledge(path)


def start_facts(session: Session) -> answers.StartAnswer | None:
    """The origin of the start of a database and its share in the database; None without a start."""
    if not store.is_learned(session.store) or not store.has_parameter(session.store, "started"):
        return None  # nothing else need be loaded
    from motiondb.search.asked_words import learned_words
    from motiondb.search.chances import why_unchecked

    learned = session.without_rows
    started = learned.started
    if started is None:
        return None
    counts = learned.counted.counts
    captioned = {w for w, n in zip(learned.association.words, counts.said.tolist()) if n > 0}
    alone, own = set(started.names) - captioned, captioned - set(started.names)
    return answers.extended(
        answers.StartAnswer,
        answers.knowledge_answer(started.knowledge),
        weight=round(start_weight(counts.moments.n), 4),
        own_captions=int(counts.moments.n),
        unchecked=why_unchecked(learned_words(learned), ()),
        strange_motion=round(strange_share(learned.segments), 4),
        fits=fits(learned.segments),
        words_of_start_alone=len(alone),
        words_of_both=len(set(started.names) & captioned),
        words_of_own_captions_alone=len(own),
    )
