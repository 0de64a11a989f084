"""Steps of different players whose order nothing ensures but the drawing.

Nobody begins a step when another player has ended a later one. Mostly that follows: a player's acts
come one after another, what is caught was given before, and what is linked happens at one time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations

from motiondb.scene.language.activity import TAKE
from motiondb.scene.language.expressions import Item
from motiondb.scene.language.tactics import Diagram

Items = Sequence[Sequence[Item]]
"""The expression of every player, in the order of the diagram."""


def step_of(diagram: Diagram, player: str, item: Item) -> int:
    """Return the step of an item of a player, 0 if it is not drawn."""
    if item.element < 0:
        return 0
    element = diagram.elements[item.element]
    caught = element.caught if element.player != player else 0
    return caught or element.step


def unlinked_orders(diagram: Diagram, items: Items) -> Iterator[tuple[int, int, int, int]]:
    """Yield player, item, other player, item of a later step, if no links ensure their order.

    Of several that say the same the narrowest is enough.
    """
    names = [player.name for player in diagram.players]
    for one, other in permutations(range(len(items)), 2):
        before: dict[int, int] = {}
        for m, later in enumerate(items[other]):
            until = step_of(diagram, names[other], later)
            steps = (step_of(diagram, names[one], item) for item in items[one])
            begins = [k for k, step in enumerate(steps) if 0 < step < until]
            if begins:
                before.setdefault(begins[-1], m)
        for k, m in before.items():
            if (other, m) not in _linked_after(diagram, items, (one, k)):
                yield one, k, other, m


def _linked_after(diagram: Diagram, items: Items, here: tuple[int, int]) -> set[tuple[int, int]]:
    """Return the items (player, number) that come after one, or with it, by links of players."""
    number = {player.name: n for n, player in enumerate(diagram.players)}
    done, waiting = set[tuple[int, int]](), [here]
    while waiting:
        player, k = waiting.pop()
        if (player, k) in done or k >= len(items[player]):
            continue
        done.add((player, k))
        waiting.append((player, k + 1))
        item = items[player][k]
        taken = any(diagram.activity.deed(action) == TAKE for action in item.actions)
        if item.other_item >= 0 and not taken:  # what is taken was given before
            waiting.append((number[item.other], item.other_item))
    return done
