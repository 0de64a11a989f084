"""Routes of grammars: learn, show, generate sequences, edit and save them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from fastapi import APIRouter, Query
from pydantic import Field

from motiondb import answers
from motiondb.database import MotionDB
from motiondb.database.grammars.grammar_facts import ComparedGrammar, derives_new, grammar_row
from motiondb.database.grammars.grammar_facts import compare as compare_grammar
from motiondb.database.grammars.grammar_sequences import Edit
from motiondb.errors import QueryError
from motiondb.grammar.derivation.edit import region_at
from motiondb.page.errors import ERRORS, PageError, unknown
from motiondb.page.jobs import JobReply
from motiondb.page.replies import Positions, SequenceReply, sequence_reply
from motiondb.page.routes.parameters import (
    LONGEST_TEXT,
    Body,
    Name,
    SaveBody,
    Saved,
    Seed,
    Text,
)
from motiondb.page.state import MadeSequence, Page, find_row
from motiondb.store import GrammarSize

Beginning = Annotated[str, Query(max_length=LONGEST_TEXT, description="Such as a b c.")]
LONGEST_SEQUENCE = 200  # Largest number of terminals of a sequence: some minutes of motion


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


@dataclass(frozen=True, kw_only=True)
class ListedGrammar(answers.GrammarRow):
    """A grammar in a list."""

    derives_new: bool  # Whether it derives new sentences


@dataclass(frozen=True)
class GrammarsReply:
    """The grammars of the database."""

    grammars: list[ListedGrammar]


@dataclass(frozen=True, kw_only=True)
class GrammarReply(answers.GrammarAnswer):
    """Everything about a grammar."""

    sequences: list[str]  # Names of the captures that hold its sequences
    edits: tuple[str, ...]  # What edits by hand changed that can be taken back, the last first


class EditBody(Body):
    """A grammar with the run of the version that was edited."""

    grammar: Text
    run: Annotated[int, Field(ge=0)]


class RulesBody(EditBody):
    """All rules of a grammar, edited."""

    text: Annotated[str, Field(max_length=100_000)]


class TerminalBody(EditBody):
    """A terminal, and its new name."""

    terminal: Text
    to: Annotated[str, Field(max_length=200)]


class ParseBody(Body):
    """A grammar, and the capture to parse."""

    grammar: Text
    capture: Text


class AnswerBody(EditBody):
    """An answer of a person: whether a terminal can come straight after another."""

    first: Text
    then: Text
    said: Literal["yes", "no", "unknown"]
    author: Annotated[str, Field(min_length=1, max_length=80)]


@dataclass(frozen=True)
class QuestionsReply:
    """Questions to a person, those whose answers say most first."""

    questions: list[answers.GrammarQuestion]


@dataclass(frozen=True)
class AnswerReply:
    """An answer that was kept."""

    said: Literal["yes", "no", "unknown"]
    obeyed: bool  # Whether rules can keep to it: not if the captures show what is ruled out


@dataclass(frozen=True)
class SuggestReply:
    """The terminals that may come next."""

    next: list[answers.NextTerminal]


@dataclass(frozen=True)
class CompareReply:
    """A grammar beside the finite state machine of its sentences."""

    grammars: tuple[ComparedGrammar, ...]


@dataclass(frozen=True, kw_only=True)
class PlayableAlternative(SequenceReply):
    """A sequence with another derivation of a region."""

    region: tuple[str, ...]
    log_probability: float


@dataclass(frozen=True, kw_only=True)
class AlternativesReply(answers.AlternativesAnswer):
    """Other derivations of a region."""

    can_widen: bool
    can_narrow: bool
    alternatives: list[PlayableAlternative | answers.Unplayable]


def router(page: Page) -> APIRouter:
    """Return the routes of grammars."""
    routes = APIRouter(tags=["grammars"], responses=ERRORS)

    @routes.get("/api/grammars")
    def grammars() -> GrammarsReply:
        """The grammars of the database."""
        with page.held.use() as db:
            rows = db.session.kept(
                "grammars of the page", lambda: [_row(db, size) for size in db.grammars.sizes()]
            )
        return GrammarsReply(rows)

    @routes.get("/api/grammar")
    def grammar(name: Name) -> GrammarReply:
        """Everything about a grammar, with its saved sequences."""
        with page.reading() as db:
            check_grammar(db, name)
            saved, edits = db.grammars.saved(name), db.grammars.edits(name)
            facts = db.grammars.show(name)
            return answers.extended(GrammarReply, facts, sequences=saved, edits=edits)

    @routes.delete("/api/grammar", response_model_exclude_none=True)
    def remove(name: Name) -> answers.Removed:
        """Remove a grammar."""
        with page.changing() as db:
            check_grammar(db, name)
            return answers.Removed(name, no_longer_editable=db.grammars.remove(name))

    @routes.post("/api/grammars", status_code=202)
    def learn(body: LearnBody) -> JobReply:
        """Learn a grammar from captures, as a job."""
        page.check_writable()
        same = {"from_symbols", "sentences", "seed", "shortest", "longest"}
        settings = body.model_dump(include=same) | {"n_terminals": body.terminals}
        parameters = {"captures": body.captures, "name": body.name, "settings": settings}
        title = f"grammar {body.name or body.captures[0]}"
        return page.jobs.start("grammar", title, parameters).reply()

    _edit_routes(routes, page)
    _question_routes(routes, page)
    _sequence_routes(routes, page)
    return routes


def _edit_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes that edit a grammar by hand."""

    @routes.put("/api/grammar/rules")
    def rules(body: RulesBody) -> answers.GrammarEdited:
        """Replace the rules of a grammar."""
        with page.changing() as db:
            check_version(db, body)
            return answers.GrammarEdited(
                body.grammar, db.grammars.edit_rules(body.grammar, body.text)
            )

    @routes.put("/api/grammar/terminal")
    def terminal(body: TerminalBody) -> answers.GrammarEdited:
        """Give a terminal another name."""
        with page.changing() as db:
            check_version(db, body)
            lost = db.grammars.rename_terminal(body.grammar, body.terminal, body.to.strip())
            return answers.GrammarEdited(body.grammar, lost)

    @routes.post("/api/grammar/undo")
    def undo(body: EditBody) -> answers.GrammarEdited:
        """Take the last edit of a grammar back."""
        with page.changing() as db:
            check_version(db, body)
            return answers.GrammarEdited(body.grammar, [], db.grammars.undo_edit(body.grammar))


def _question_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes that ask a grammar."""

    @routes.post("/api/grammar/parse")
    def parse(body: ParseBody) -> answers.ParseAnswer:
        """A stored capture as a string of terminals, with its sentences or the fault."""
        with page.reading() as db:
            check_grammar(db, body.grammar)
            name = find_row(db, body.capture).info.name
            return db.grammars.parse(body.grammar, name).facts()

    @routes.get("/api/grammar/suggest")
    def suggest(name: Name, beginning: Beginning = "") -> SuggestReply:
        """The terminals that may come after a beginning."""
        with page.reading() as db:
            check_grammar(db, name)
            found = db.grammars.suggest(name, beginning)
        return SuggestReply([answers.NextTerminal(t, t is None, p) for t, p in found])

    @routes.get("/api/grammar/questions")
    def questions(name: Name) -> QuestionsReply:
        """Pairs of terminals to ask a person about."""
        with page.reading() as db:
            check_grammar(db, name)
            return QuestionsReply(db.grammars.questions(name))

    @routes.post("/api/grammar/answers")
    def answer(body: AnswerBody) -> AnswerReply:
        """Keep an answer with its author."""
        with page.changing() as db:
            check_version(db, body)
            pair = (body.first, body.then)
            return AnswerReply(
                body.said, db.grammars.answer(body.grammar, *pair, body.said, body.author)
            )

    @routes.get("/api/grammar/compare")
    def compare(name: Name) -> CompareReply:
        """The grammar beside the finite state machine of its sentences."""
        with page.reading() as db:
            check_grammar(db, name)
            learned = db.grammars.load(name)
        return CompareReply(compare_grammar(learned))


def _sequence_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes of sequences."""

    @routes.post("/api/sequences")
    def generate(body: SequenceBody) -> SequenceReply:
        """A new sequence that a grammar derives."""
        with page.held.use() as db:
            check_grammar(db, body.grammar)
            made = db.grammars.generate(body.grammar, body.seed, body.length, body.like)
            return _put(page, db, MadeSequence(made, body.seed))

    @routes.post("/api/sequences/open")
    def open_saved(body: OpenBody) -> SequenceReply:
        """A saved sequence, ready to be edited."""
        with page.reading() as db:
            name = find_row(db, body.capture).info.name
            return _put(page, db, MadeSequence(db.grammars.open(name), 0))

    @routes.get("/api/sequence")
    def sequence(id: Name) -> SequenceReply:
        """A sequence that was made earlier."""
        kept = page.sequences.get(id)
        with page.held.use() as db:
            _check_rules(db, kept)
            return _reply(db, id, kept)

    @routes.post("/api/sequences/alternatives")
    def alternatives(body: AlternativesBody) -> AlternativesReply:
        """Other derivations of a region, each as a whole sequence."""
        kept = page.sequences.get(body.id)
        _keep_line(page, kept)
        with page.reading() as db:
            _check_rules(db, kept)
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
        region = edited.region
        deepest = region_at(edited.before, region.position)
        return AlternativesReply(
            region=region,
            can_widen=bool(region.path),
            can_narrow=len(deepest.path) > len(region.path),
            alternatives=rows,
        )

    @routes.post("/api/sequences/save")
    def save(body: SaveBody) -> Saved:
        """Save a sequence as a capture with its derivation."""
        page.check_writable()
        kept = page.sequences.get(body.id)
        with page.held.use() as db:
            _check_rules(db, kept)
            info = db.grammars.save(body.name, kept.sequence, kept.seed, kept.how)
        page.sequences.replace(body.id, replace(kept, saved=info.name))
        return Saved(info.name, f"capture:{info.name}")


def _row(db: MotionDB, size: GrammarSize) -> ListedGrammar:
    learned = db.grammars.load(size.name)
    new = derives_new(learned.grammar, learned.strings)
    return answers.extended(ListedGrammar, grammar_row(size), derives_new=new)


def _keep_line(page: Page, made: MadeSequence | None) -> None:
    """Mark the ancestors of a sequence as used, so that they stay available for undo."""
    while made is not None and made.parent:
        made = page.sequences.find(made.parent)


def check_version(db: MotionDB, body: EditBody) -> None:
    """Refuse an edit of a grammar that was changed since it was shown."""
    check_grammar(db, body.grammar)
    if db.grammars.load(body.grammar).run_id != body.run:
        raise PageError(
            f"{body.grammar}: expected the version that was shown, found a newer one. Nothing was"
            " changed: look at the present rules, and edit these.",
            "ConflictError",
        )


def check_grammar(db: MotionDB, name: str) -> None:
    """Check that a grammar has this name."""
    if name not in db.grammars.names():
        raise unknown("grammar", name, "It may have been removed.")


def _check_rules(db: MotionDB, made: MadeSequence) -> None:
    """Refuse a sequence that was made with other rules than the present ones."""
    name = made.sequence.grammar
    check_grammar(db, name)
    if db.grammars.load(name).run_id != made.run:
        raise PageError(
            f"{name}: expected a sequence of its present rules, found one of earlier rules."
            " Make a new one.",
            "ConflictError",
        )


def _put(page: Page, db: MotionDB, made: MadeSequence) -> SequenceReply:
    made = replace(made, run=db.grammars.load(made.sequence.grammar).run_id)
    return _reply(db, page.sequences.put(made), made)


def _reply(db: MotionDB, sequence_id: str, made: MadeSequence) -> SequenceReply:
    edited = None if made.edited is None else Positions(*made.edited)
    more = {"parent": made.parent or None, "edited": edited, "saved": made.saved or None}
    return sequence_reply(db, made.sequence, made.seed, sequence_id, **more)


def _alternative(
    page: Page, db: MotionDB, body: AlternativesBody, edited: Edit, number: int
) -> PlayableAlternative | answers.Unplayable:
    """Return an alternative as a sequence, or the reason why it cannot be played."""
    alternative = edited.alternatives[number]
    region, log_probability = tuple(alternative.string), float(alternative.log_probability)
    grammar = page.sequences.get(body.id).sequence.grammar
    try:
        made = db.grammars.play(grammar, edited, number)
    except QueryError as error:
        string = tuple(edited.tree(number).leaves())
        return answers.Unplayable(
            string=string, region=region, log_probability=log_probability, not_playable=str(error)
        )
    start = edited.region.start
    how: dict[str, object] = {"edited": body.id, "at": body.at, "choose": number + 1}
    how |= {"wider": body.wider, "narrower": body.narrower, "number": body.number}
    kept = MadeSequence(made, body.seed, body.id, (start, start + len(region)), how)
    more = {"region": region, "log_probability": log_probability}
    return answers.extended(PlayableAlternative, _put(page, db, kept), **more)
