"""Captions as evidence for an action of several words."""

from pathlib import Path

import motiondb


def written_of(db: motiondb.MotionDB, question: str, capture: str) -> dict[str, float]:
    """What captions of a capture add for every word of a question."""
    answer = db.search(question, where=f"name={capture}", limit=1)
    (explained,) = answer.explanations
    return {word.word: word.written for word in explained.words}


def test_words_of_different_actions_are_not_written_together(learned_file: Path) -> None:
    """The caption says "walk forward, catch ball, pivot left"."""
    with motiondb.open(learned_file, read_only=True) as db:
        captures = [
            info.name
            for capture, info in db.learned.captures.items()
            for caption in db.learned.captions.get(capture, ())
            if "walk forward, catch ball, pivot left" in caption.words and caption.start is None
        ]
        name = captures[0]
        assert written_of(db, "pivot left", name)["left"] > 0.0
        walking = written_of(db, "walk left", name)
        assert walking["walk"] > 0.0
        assert walking["left"] == 0.0
        assert written_of(db, "walk, not walk left", name)  # what is excluded keeps its evidence
