"""The progress of a whole job."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from motiondb.page.jobs import WholeProgress

STEPS = [
    "features",
    "symbols compete",
    "cutting anew",
    "words",
    "saving",
    "captures changed, again",
]


@given(st.lists(st.tuples(st.sampled_from(STEPS), st.floats(0.0, 1.0))))
def test_progress_never_falls_and_stays_between_its_ends(told: list[tuple[str, float]]) -> None:
    progress, shares = WholeProgress("learn"), [0.0]
    for step, share in told:
        progress.tell(step, share)
        assert progress.share is not None
        shares.append(progress.share)
    assert shares == sorted(shares)
    assert 0.0 <= shares[-1] <= 1.0


def test_batches_go_on_by_turns_and_a_left_out_step_is_over() -> None:
    add = WholeProgress("add")
    for step, share in (("reading captures", 0.5), ("saving captures", 0.25)):
        add.tell(step, share)
    assert add.share == 0.6 * 0.5 + 0.4 * 0.25
    learn = WholeProgress("learn")
    learn.tell("words", 0.0)
    assert learn.share is not None
    assert abs(learn.share - 0.48) < 1e-9
    assert learn.left(48.0) == 52.0
    assert WholeProgress("scene").share is None
