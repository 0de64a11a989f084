"""Routes of grammars: learn, show, generate sequences, edit and save them."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter
from pydantic import Field

from motiondb.database import MotionDB
from motiondb.database.grammars.grammar_facts import derives_new
from motiondb.database.grammars.grammar_sequences import Edit
from motiondb.errors import QueryError
from motiondb.page.answers import Answer, PageError, unknown
from motiondb.page.facts.made_facts import sequence_facts
from motiondb.page.parameters import LONGEST_TEXT, Body, Name, Seed, Text
from motiondb.page.routes.catalogue import find_row
from motiondb.page.routes.generating import SaveBody
from motiondb.page.schemas import grammar_schemas, shared_schemas
from motiondb.page.session.state import MadeSequence, Page

if TYPE_CHECKING:
    from motiondb.store import GrammarSize

LONGEST_SEQUENCE = 200
"""Largest number of terminals of a sequence. Chosen by hand: some minutes of motion."""


class LearnBody(Body):
    """The captures of a grammar, and the settings of learning."""

    captures: Annotated[list[Text], Field(min_length=1, max_length=1000)]
    name: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    terminals: Annotated[int, Field(ge=1, le=1000)] | None = None
    sentences: Literal["auto", "captures", "captions"] = "auto"
    from_symbols: bool = False
    shortest: Annotated[int, Field(ge=1, le=1000)] = 3
    longest: Annotated[int, Field(ge=1, le=1000)] = 20
    seed: Seed = 0


class SequenceBody(Body):
    """A grammar, and what to derive: any sentence, one of a length, or one that fits a pattern."""

    grammar: Text
    seed: Seed = 0
    length: Annotated[int, Field(ge=1, le=LONGEST_SEQUENCE)] | None = None
    like: Annotated[str, Field(min_length=1, max_length=LONGEST_TEXT)] | None = None


class OpenBody(Body):
    """A saved sequence."""

    capture: Text


class AlternativesBody(Body):
    """A region of a sequence: a position, and by how many levels it is widened and narrowed."""

    id: Text
    at: Annotated[int, Field(ge=0, le=100_000)]
    wider: Annotated[int, Field(ge=0, le=10_000)] = 0
    narrower: Annotated[int, Field(ge=0, le=10_000)] = 0
    number: Annotated[int, Field(ge=1, le=12)] = 4
    seed: Seed = 0


def router(page: Page) -> APIRouter:
    """Return the routes of grammars."""
    routes = APIRouter(tags=["grammars"])

    @routes.get("/api/grammars", response_model=grammar_schemas.GrammarRows)
    def grammars() -> Answer:
        """The grammars of the database."""
        with page.held.use() as db:
            rows = db.session.kept(
                "grammars of the page", lambda: [_row(db, size) for size in db.grammars.sizes()]
            )
        return Answer({"grammars": rows})

    @routes.get("/api/grammar", response_model=grammar_schemas.GrammarFacts)
    def grammar(name: Name) -> Answer:
        """Everything about a grammar, with its saved sequences."""
        with page.held.use() as db, db.session.reading():
            check_grammar(db, name)
            facts = db.grammars.show(name)
            facts["sequences"] = db.grammars.saved(name)
        return Answer(facts)

    @routes.delete("/api/grammar", response_model=grammar_schemas.GrammarRemoved)
    def remove(name: Name) -> Answer:
        """Remove a grammar."""
        page.check_writable()
        with page.held.use() as db:
            check_grammar(db, name)
            return Answer({"removed": name, "lost": db.grammars.remove(name)})

    @routes.post("/api/grammars", response_model=shared_schemas.JobFacts, status_code=202)
    def learn(body: LearnBody) -> Answer:
        """Learn a grammar from captures, as a job."""
        page.check_writable()
        if body.from_symbols and body.terminals is not None:
            raise PageError("terminals: expected no number beside from_symbols, found one.")
        settings: dict[str, Any] = {
            key: getattr(body, key)
            for key in ("from_symbols", "sentences", "seed", "shortest", "longest")
        }
        settings["n_terminals"] = body.terminals
        parameters = {"captures": body.captures, "name": body.name, "settings": settings}
        job = page.jobs.start("grammar", f"grammar {body.name or body.captures[0]}", parameters)
        return Answer(job.facts(), 202)

    _sequence_routes(routes, page)
    return routes


def _sequence_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes of sequences."""

    @routes.post("/api/sequences", response_model=grammar_schemas.SequenceFacts)
    def generate(body: SequenceBody) -> Answer:
        """A new sequence that a grammar derives."""
        with page.held.use() as db:
            check_grammar(db, body.grammar)
            made = db.grammars.generate(body.grammar, body.seed, body.length, body.like)
            return Answer(_put(page, db, MadeSequence(made, body.seed)))

    @routes.post("/api/sequences/open", response_model=grammar_schemas.SequenceFacts)
    def open_saved(body: OpenBody) -> Answer:
        """A saved sequence, ready to be edited."""
        with page.held.use() as db, db.session.reading():
            name = find_row(db, body.capture).info.name
            return Answer(_put(page, db, MadeSequence(db.grammars.open(name), 0)))

    @routes.get("/api/sequence", response_model=grammar_schemas.SequenceFacts)
    def sequence(id: Name) -> Answer:
        """A sequence that was made earlier."""
        kept = page.sequences.get(id)
        with page.held.use() as db:
            return Answer(_facts(db, id, kept))

    @routes.post("/api/sequences/alternatives", response_model=grammar_schemas.Alternatives)
    def alternatives(body: AlternativesBody) -> Answer:
        """Other derivations of a region, each as a whole sequence."""
        kept = page.sequences.get(body.id)
        _keep_line(page, kept)
        with page.held.use() as db, db.session.reading():
            edited = db.grammars.edit(
                kept.sequence.grammar,
                kept.sequence,
                body.at,
                (body.wider, body.narrower),
                body.number,
                body.seed,
            )
            rows = [
                _alternative(page, db, body, edited, n) for n in range(len(edited.alternatives))
            ]
        up, down = db_levels(edited)
        return Answer(
            {
                "region": asdict(edited.region),
                "can_widen": up > 0,
                "can_narrow": down > 0,
                "alternatives": rows,
            }
        )

    @routes.post("/api/sequences/save", response_model=shared_schemas.Saved)
    def save(body: SaveBody) -> Answer:
        """Save a sequence as a capture with its derivation."""
        page.check_writable()
        kept = page.sequences.get(body.id)
        with page.held.use() as db:
            info = db.grammars.save(body.name, kept.sequence, kept.seed, kept.how)
        page.sequences.replace(body.id, kept.saved_as(info.name))
        return Answer({"capture": info.name, "ref": f"capture:{info.name}"})


def _row(db: MotionDB, size: GrammarSize) -> dict[str, Any]:
    learned = db.grammars.load(size.name)
    return asdict(size) | {
        "seconds": size.seconds,
        "bits": sum(size.bits.values()),
        "derives_new": derives_new(learned.grammar, learned.strings),
    }


def db_levels(edited: Edit) -> tuple[int, int]:
    """Return by how many levels the region of an edit can be widened, and narrowed."""
    from motiondb.grammar.derivation.edit import region_at

    deepest = region_at(edited.before, edited.region.position)
    return len(edited.region.path), len(deepest.path) - len(edited.region.path)


def _keep_line(page: Page, made: MadeSequence | None) -> None:
    """Mark the ancestors of a sequence as used, so that they stay available for undo."""
    while made is not None and made.parent:
        made = page.sequences.find(made.parent)


def check_grammar(db: MotionDB, name: str) -> None:
    """Check that a grammar has this name."""
    if name not in db.grammars.names():
        raise unknown("grammar", name, "It may have been removed.")


def _put(page: Page, db: MotionDB, made: MadeSequence) -> dict[str, Any]:
    return _facts(db, page.sequences.put(made), made)


def _facts(db: MotionDB, sequence_id: str, made: MadeSequence) -> dict[str, Any]:
    edited = None
    if made.edited is not None:
        edited = {"start": made.edited[0], "end": made.edited[1]}
    return sequence_facts(db, made.sequence, made.seed) | {
        "id": sequence_id,
        "ref": f"sequence:{sequence_id}",
        "parent": made.parent or None,
        "edited": edited,
        "saved": made.saved or None,
    }


def _alternative(
    page: Page, db: MotionDB, body: AlternativesBody, edited: Edit, number: int
) -> dict[str, Any]:
    """Return an alternative as a sequence, or the reason why it cannot be played."""
    alternative = edited.alternatives[number]
    facts = {
        "region": list(alternative.string),
        "log_probability": alternative.log_probability,
    }
    grammar = page.sequences.get(body.id).sequence.grammar
    try:
        made = db.grammars.play(grammar, edited, number)
    except QueryError as error:
        string = list(edited.tree(number).leaves())
        return facts | {"string": string, "not_playable": str(error)}
    start = edited.region.start
    how: dict[str, object] = {"edited": body.id, "at": body.at, "choose": number + 1}
    how |= {"wider": body.wider, "narrower": body.narrower, "number": body.number}
    kept = MadeSequence(made, body.seed, body.id, (start, start + len(alternative.string)), how)
    return _put(page, db, kept) | facts
