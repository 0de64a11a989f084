"""Facts of generated motion: motions from sentences, sequences of grammars."""

from __future__ import annotations

from typing import Any

from motiondb.database import MotionDB
from motiondb.database.generating import Generated
from motiondb.database.grammars.grammar_facts import PATH_STEP, root_path, tree_nodes
from motiondb.database.grammars.grammar_sequences import GrammarSequence
from motiondb.page.facts.answer_facts import taken_facts
from motiondb.page.facts.capture_facts import description_facts, source_facts, stretch_facts
from motiondb.records import MOTION_FPS


def sentence_facts(made: Generated) -> dict[str, Any]:
    """Return how a sentence was understood."""
    takings = (*made.taken.values(), *made.suggested.values())
    return {
        "question": made.question.facts(made.not_used),
        "taken": taken_facts(made.taken),
        "suggested": taken_facts(made.suggested),
        "unknown": {word: list(near) for word, near in made.unknown.items()},
        "sentences": [taking.sentence() for taking in takings],
    }


def made_facts(db: MotionDB, made: Generated, made_id: str, saved: str) -> dict[str, Any]:
    """Return the facts of a generated motion."""
    facts = made.facts()
    actions = [
        {
            "text": " ".join(action.words),
            "start": round(action.start / MOTION_FPS, 3),
            "end": round(action.end / MOTION_FPS, 3),
            "probability": action.probability,
            "shown": action.shown,
            "reason": action.reason or None,
        }
        for action in made.shown
    ]
    return {
        **{key: facts[key] for key in ("words", "seed", "method", "seconds", "actions", "symbols")},
        "id": made_id,
        "ref": f"made:{made_id}",
        "recognised": facts["recognised"],
        "decodings": facts["decodings"],
        "spans": [{"words": a["text"], "start": a["start"], "end": a["end"]} for a in actions],
        "recognised_words": description_facts(db.describe(made.motion)),
        "shown": actions,
        "not_shown": [{"text": left.text, "reason": left.reason} for left in made.not_used],
        "sources": source_facts(made.provenance),
        "stretches": stretch_facts(made.provenance),
        "saved": saved or None,
    }


def sequence_facts(db: MotionDB, sequence: GrammarSequence, seed: int) -> dict[str, Any]:
    """Return the facts of a sequence of a grammar."""
    facts = db.grammars.facts(sequence, seed)
    meanings = db.grammars.meanings(sequence.grammar)
    names = db.grammars.load(sequence.grammar).terminals.names
    words = {name: [w for w, _ in meaning.words] for name, meaning in zip(names, meanings)}
    return {
        **{key: value for key, value in facts.items() if key not in ("tree", "spans")},
        "strip": [
            {
                "at": at,
                "terminal": each.terminal,
                "nonterminal": each.nonterminal,
                "start": round(each.start, 3),
                "end": round(each.end, 3),
                "words": words.get(each.terminal, []),
                "capture": each.capture,
                "source_start": round(each.source_start, 3),
                "source_end": round(each.source_end, 3),
            }
            for at, each in enumerate(db.grammars.strip(sequence))
        ],
        "path": {
            "fps": MOTION_FPS / PATH_STEP,
            "points": root_path(sequence).round(3).tolist(),
        },
        "tree": [
            {
                "symbol": node.symbol,
                "parent": node.parent,
                "start": node.start,
                "end": node.end,
                "terminal": node.is_terminal,
            }
            for node in tree_nodes(sequence.tree)
        ],
        "tree_text": facts["tree"],
        "stretches": stretch_facts(sequence.provenance),
    }
