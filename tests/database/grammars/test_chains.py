"""Sentences that follow one another for a wanted time, and where sequences begin and end."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import motiondb
from motiondb import store
from motiondb.database import MotionDB
from motiondb.errors import QueryError
from motiondb.grammar.cfg.parse import accepts


def test_a_chain_is_as_long_as_wanted_and_each_part_is_a_sentence(asked_dances: MotionDB) -> None:
    learned = asked_dances.grammars.load("dance")
    one = asked_dances.grammars.generate("dance", 0).motion.n_frames / 30
    longest = max(
        float((learned.terminals.ends - learned.terminals.starts)[a:b].sum()) / 30
        for a, b in learned.sentences
    )
    made = asked_dances.grammars.chain("dance", 40.0, 2)
    assert len(made.trees) > 1
    assert all(accepts(learned.grammar, tree.leaves()) for tree in made.trees)
    assert made.string == tuple(name for tree in made.trees for name in tree.leaves())
    seconds = made.motion.n_frames / 30
    assert abs(seconds - 40.0) < max(one, longest)
    again = asked_dances.grammars.chain("dance", 40.0, 2)
    assert again.motion.local_rotations.tobytes() == made.motion.local_rotations.tobytes()
    facts = asked_dances.grammars.facts(made, 2)
    json.dumps(motiondb.to_json(facts))
    assert facts.sentences == len(made.trees)
    assert facts.tree == " ".join(map(str, made.trees))


def test_a_sequence_begins_and_ends_as_sentences_of_the_takes_do(asked_dances: MotionDB) -> None:
    learned = asked_dances.grammars.load("dance")
    labels, names = learned.terminals.labels, learned.terminals.names
    firsts, lasts = (
        set(learned.sentences[:, 0].tolist()),
        set((learned.sentences[:, 1] - 1).tolist()),
    )
    begins, ends = ({names[labels[clip]] for clip in clips} for clips in (firsts, lasts))
    for seed in range(4):
        made = asked_dances.grammars.generate("dance", seed)
        assert made.choice.clips[0] in firsts or made.string[0] not in begins
        assert made.choice.clips[-1] in lasts or made.string[-1] not in ends
        assert made.string[0] in begins  # a grammar of these sentences begins as they do


def test_a_chain_is_kept_without_a_derivation(dances: MotionDB, tmp_path: Path) -> None:
    made = dances.grammars.chain("dance", 30.0, 1)
    dances.grammars.save("new/chain", made, 1, {"seconds": 30.0})
    info = store.load_capture(dances.store, "new/chain")
    assert store.load_derivation(dances.store, info.capture_id) is None
    with pytest.raises(QueryError, match="found no such capture \\(or it is a chain of sentences"):
        dances.grammars.edit("dance", "new/chain", 0)
    with pytest.raises(QueryError, match=f"expected one sentence, found {len(made.trees)}"):
        dances.grammars.edit("dance", made, 0)
    dances.grammars.write(made, tmp_path / "chain.bvh", 1)
    assert (tmp_path / "chain.bvh").stat().st_size > 1000
    assert dances.check() == []


@pytest.mark.parametrize("seconds", [0.0, -1.0, 601.0])
def test_a_time_that_cannot_be_is_refused(asked_dances: MotionDB, seconds: float) -> None:
    with pytest.raises(QueryError, match="seconds: expected more than 0 and at most 600, found"):
        asked_dances.grammars.chain("dance", seconds)
