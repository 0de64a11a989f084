"""Hidden places of listed actions, found in made-up takes; regression without a take by refits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_takes import fit_places, map_places, weights_of

from motiondb.meaning import place_map
from motiondb.meaning.place_map import ListedTakes, find_shown
from motiondb.meaning.score_vectors import unit
from motiondb.records import FloatArray

N_COLUMNS, N_WORDS = 12, 5


def made_up(seed: int, n_takes: int, listed: int) -> tuple[ListedTakes, FloatArray]:
    """Takes whose segments show one word each, in the order that their captions list; the truth."""
    rng = np.random.default_rng(seed)
    centres = rng.normal(size=(N_WORDS, N_COLUMNS))
    vectors, seconds, owners, actions, truth = [], [], [], [], []
    for take in range(n_takes):
        order = rng.permutation(N_WORDS)[:listed]
        for word in order:
            for _ in range(int(rng.integers(2, 5))):
                vectors.append(centres[word] + 0.4 * rng.normal(size=N_COLUMNS))
                seconds.append(rng.uniform(1.0, 3.0))
                owners.append(take)
                truth.append(word)
        actions.append([[int(word)] for word in order])
    return (
        ListedTakes(
            unit(np.array(vectors)), np.array(seconds), np.array(owners), actions,
            [()] * n_takes, N_WORDS,
        ),
        np.array(truth),
    )  # fmt: skip


def test_places_of_listed_actions_are_found() -> None:
    takes, truth = made_up(1, 20, 3)
    shown = find_shown(takes)
    assert (shown.argmax(axis=1) == truth).mean() > 0.9
    unseen, answers = made_up(1, 30, 3)
    unseen_rows = unseen.owners >= 20
    actual = (
        map_places(takes.vectors, shown, weights_of(takes))
        .evidence(unseen.vectors[unseen_rows])
        .argmax(axis=1)
    )
    assert (actual == answers[unseen_rows]).mean() > 0.9


def test_without_their_order_listed_actions_are_found_less_often() -> None:
    takes, truth = made_up(2, 12, 4)
    rng = np.random.default_rng(0)
    shuffled = [[actions[i] for i in rng.permutation(len(actions))] for actions in takes.actions]
    wrong = ListedTakes(
        takes.vectors, takes.seconds, takes.owners, shuffled, takes.further, N_WORDS
    )
    right = (find_shown(takes).argmax(axis=1) == truth).mean()
    assert right > (find_shown(wrong).argmax(axis=1) == truth).mean()


def test_a_caption_of_one_action_describes_all_of_its_take() -> None:
    takes, _ = made_up(3, 6, 1)
    shown = find_shown(takes)
    for inside, actions in zip(takes.rows(), takes.actions):
        assert shown[inside, actions[0][0]] == pytest.approx(1.0)


def test_further_words_keep_an_even_share() -> None:
    takes, _ = made_up(4, 6, 2)
    spare = [
        sorted(set(range(N_WORDS)) - {w for action in actions for w in action})[:1]
        for actions in takes.actions
    ]
    with_further = ListedTakes(
        takes.vectors, takes.seconds, takes.owners, takes.actions, spare, N_WORDS
    )
    shown = find_shown(with_further)
    for inside, words in zip(takes.rows(), spare):
        assert shown[inside, words] == pytest.approx(0.5)


def without_rows(
    takes: ListedTakes, shown: FloatArray, left: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The weighted ridge regression on some rows alone, and what it says of all; centres of all."""
    weights = weights_of(takes)
    centre, mean = weights @ takes.vectors / weights.sum(), weights @ shown / weights.sum()
    root = np.sqrt(weights[left])[:, None]
    x, y = (takes.vectors[left] - centre) * root, (shown[left] - mean) * root
    slopes = np.linalg.solve(x.T @ x + place_map.RIDGE * np.eye(N_COLUMNS), x.T @ y)
    return slopes, (takes.vectors - centre) @ slopes + mean


def test_left_out_predictions_are_those_of_a_fit_without_the_take() -> None:
    takes, _ = made_up(5, 5, 2)
    shown = np.random.default_rng(5).uniform(size=(len(takes.vectors), N_WORDS))
    weights = weights_of(takes)
    mean = weights @ shown / weights.sum()
    evidence = fit_places(takes, shown).left_out(takes.rows())
    predicted = evidence * place_map.spreads_of(mean) / place_map.SHARPNESS + mean
    for inside in takes.rows():
        others = np.delete(np.arange(len(shown)), inside)
        expected = without_rows(takes, shown, others)[1]
        assert predicted[inside] == pytest.approx(expected[inside], abs=1e-8)


@pytest.mark.parametrize("n_taken", [0, 5, 40])
def test_a_map_without_rows_is_that_of_a_fit_without_them(n_taken: int) -> None:
    takes, _ = made_up(7, 12, 3)
    shown = np.random.default_rng(7).uniform(size=(len(takes.vectors), N_WORDS))
    slopes, told = without_rows(takes, shown, np.arange(n_taken, len(shown)))
    fit = fit_places(takes, shown).without(np.arange(n_taken))
    assert fit.weights == pytest.approx(slopes, abs=1e-8)
    weights = weights_of(takes)
    mean = weights @ shown / weights.sum()
    expected = place_map.SHARPNESS * (told - mean) / place_map.spreads_of(mean)
    assert fit.evidence(takes.vectors) == pytest.approx(expected, abs=1e-8)
    if not n_taken:
        whole = map_places(takes.vectors, shown, weights)
        assert whole.evidence(takes.vectors) == pytest.approx(expected, abs=1e-8)


def test_labels_hold_and_draw_the_action_to_their_place() -> None:
    takes, _ = made_up(8, 8, 3)
    labelled = np.full((len(takes.vectors), N_WORDS), np.nan)
    inside = takes.rows()[0]
    word = takes.actions[0][2][0]
    labelled[inside.start, word] = 1.0  # the last of the actions, at the first segment
    labelled[inside.start + 1, word] = 0.0
    said = ListedTakes(
        takes.vectors, takes.seconds, takes.owners, takes.actions, takes.further, N_WORDS, labelled
    )
    shown = find_shown(said)
    assert shown[inside.start, word] == 1.0
    assert shown[inside.start + 1, word] == 0.0
    first = takes.actions[0][0][0]
    assert shown[inside.start, first] < find_shown(takes)[inside.start, first]


def test_an_action_that_no_caption_lists_is_learned_from_one_label() -> None:
    takes, truth = made_up(9, 14, 4)
    word = N_WORDS - 1
    actions = [[a for a in listed if a != [word]] for listed in takes.actions]
    labelled = np.full((len(takes.vectors), N_WORDS), np.nan)
    first = next(rows for rows in takes.rows() if (truth[rows] == word).any())
    labelled[first, word] = truth[first] == word
    said = replace(takes, actions=actions, labelled=labelled)
    shown = find_shown(said)[first.stop :, word]
    is_word = truth[first.stop :] == word
    assert (shown[is_word] > 0.5).mean() > 0.9
    assert (shown[~is_word] < 0.5).mean() > 0.9


def test_a_take_of_one_action_shows_no_unlisted_one() -> None:
    takes, _ = made_up(3, 6, 1)
    labelled = np.full((len(takes.vectors), N_WORDS), np.nan)
    labelled[0, :2] = 1.0
    shown = find_shown(replace(takes, labelled=labelled))
    for inside, actions in zip(takes.rows()[1:], takes.actions[1:]):
        others = [word for word in range(N_WORDS) if [word] not in actions]
        assert (shown[inside][:, others] == 0.0).all()
