"""Diagrams: players on a ground, and what each of them does, as on a coach's board.

A circle is a player. An element is a verb of the grammar (:mod:`.activity`), perhaps with a curve,
with another player or a place. The paper leaves time to the drawing. Here every element has a step,
and what is given has a second one at which it is caught. Elements of lower steps come first; a
player's elements of one step come in the order of the file.

The ground is seen from above: x points to the right and z down the page, in metres. The grammar
says where its origin is.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import permutations

from motiondb.scene.language.activity import (
    OPPONENT,
    PARTNER,
    PLAYER,
    RECEIVER,
    TARGET,
    Activity,
    Answers,
    Ground,
    Step,
    Verb,
)
from motiondb.scene.language.semantic_rules import Spot, bounds_text

BODY_WIDTH = 0.5
"""Smallest distance between two players, m: about the width of a body. Nearer players touch."""


@dataclass(frozen=True)
class Player:
    """A player at the beginning of the play."""

    name: str
    team: str
    at: Spot  # Position of the player
    guards: str = ""  # Name of whom the player guards or follows; "" if none is named
    line: int = 0  # Line of the file


@dataclass(frozen=True)
class Element:
    """An action of a player in a diagram."""

    kind: str  # A verb of the grammar, or DOES
    step: int  # When it begins, from 1
    player: str  # The player who acts
    other: str = ""  # The other player whom it is about, or ""
    via: tuple[Spot, ...] = ()  # Points that the player's curve passes
    to: Spot | None = None  # End of the curve; None if the player stays
    caught: int = 0  # The step at which what is given arrives; 0 for the same as ``step``
    line: int = 0  # Line of the file
    target: str = ""  # The place that it is aimed at, or ""
    link: str = ""  # The word before the other player or the place
    steps: tuple[Step, ...] = ()  # What DOES asks for

    def __str__(self) -> str:
        """Return the element in words, for messages."""
        about = self.other or self.target
        return f"{self.kind} {self.player}" + f" {self.link or 'on'} {about}" * bool(about)


DOES = "does"  # The kind of an element that spells out a string of actions


@dataclass(frozen=True)
class Act:
    """An element from the side of one player who takes part in it."""

    element: int  # Index of the element
    part: tuple[
        str, ...
    ] = ()  # Actions of which the other player does one; () for the player's own


@dataclass(frozen=True)
class Stretch:
    """What a player keeps up from one step to another: a distance to somebody, or moving."""

    player: str
    other: str = ""  # "" for moving
    near: float = 0.0
    far: float = float("inf")
    first: int = 0  # 0 for the beginning
    last: int = 0  # 0 for the end
    line: int = 0

    def __str__(self) -> str:
        """Return the stretch as it is written."""
        what = f"{bounds_text(self.near, self.far)} to {self.other}" if self.other else "moving"
        return f"{self.player} keeps {what}" + f" from {self.first} to {self.last}" * bool(
            self.last
        )


@dataclass(frozen=True)
class Diagram:
    """A play."""

    name: str
    players: tuple[Player, ...]
    elements: tuple[Element, ...]
    grammar: str = "basketball"  # Name of the grammar that the play follows
    ground: Ground | None = None  # None for that of the grammar
    # Names and positions of places that rules may refer to, beside those of the grammar
    own_places: tuple[tuple[str, Spot], ...] = ()
    ball: str = ""  # Name of who has the object at first; "" if the file does not say
    stretches: tuple[Stretch, ...] = ()
    times: tuple[tuple[int, float, int], ...] = ()  # Step, seconds after, an earlier step
    activity: Activity = field(default_factory=Activity)  # That of the grammar

    @property
    def court(self) -> Ground:
        """The ground of the play."""
        return self.ground or self.activity.ground

    @cached_property
    def places(self) -> tuple[tuple[str, Spot], ...]:
        """Places by name, those of the grammar first; the diagram's own count."""
        known = {place.name: place.at for place in self.activity.places if place.at}
        return tuple((known | dict(self.own_places)).items())

    @cached_property
    def player(self) -> dict[str, Player]:
        """Players by name."""
        return {player.name: player for player in self.players}

    def verb(self, element: Element, holds: bool = False) -> Verb:
        """Return what an element asks for of somebody who ``holds`` the object, or not."""
        if element.kind == DOES:
            return Verb(DOES, element.steps)
        return self.activity.verb(element.kind, holds)

    def forms(self, element: Element) -> tuple[Verb, ...]:
        """Return all that an element may ask for, with the object and without it."""
        return self.activity.verbs.get(element.kind, (self.verb(element),))

    @cached_property
    def acts(self) -> dict[str, tuple[Act, ...]]:
        """Acts of each player in the order of time; players are in the order of the file.

        The other player of a pass catches, by the rules of the grammar, and who is attacked
        answers. Who has an element that does what is asked, such as the shot that is blocked, does
        not do it once more.
        """
        rows: dict[str, list[tuple[int, int, Act]]] = {player.name: [] for player in self.players}
        for number, element in enumerate(self.elements):
            if element.player in rows:
                rows[element.player].append((element.step, number, Act(number)))
            for part in self._parts(element):
                step = element.caught or element.step
                rows[element.other].append((step, number, Act(number, part)))
        for number, part, name in self._undrawn_answers():
            rows[name].append((self.elements[number].step, number, Act(number, part)))
        return {
            name: tuple(act for _, _, act in sorted(acts, key=lambda row: row[:2]))
            for name, acts in rows.items()
        }

    def _parts(self, element: Element) -> tuple[tuple[str, ...], ...]:
        """Return what the other player of an element must do, unless they do it already."""
        if element.other not in self.player:
            return ()
        parts = self.activity.partners_act(self.verb(element, True).last)
        own = {
            action
            for one in self.elements
            if one.player == element.other
            for step in self.verb(one).steps
            for action in step.actions
        }
        return tuple(part for part in parts if not set(part) & own)[:1]

    def _undrawn_answers(self) -> Iterator[tuple[int, tuple[str, ...], str]]:
        """Yield every element whose answer is not drawn, the answers of the grammar, and whose."""
        names = list(self.player)
        for said in self.activity.answers:
            acts, replies = (
                [self._drawn(actions, name) for name in names]
                for actions in (said.acts, said.answers)
            )
            for (_, number), (other, reply) in answered(said, acts, replies):
                if number >= 0 > reply:
                    yield number, said.answers, names[other]

    def _drawn(self, actions: Sequence[str], name: str) -> list[Directed]:
        """Return the elements of a player that ask for one of these, in the order of steps."""
        order = {name: number for number, name in enumerate(self.player)}
        found = [
            (number, one.step, order.get(self.faced(one), -1))
            for number, one in enumerate(self.elements)
            if one.player == name and self._does(one, actions)
        ]
        return sorted(found, key=lambda directed: directed[1])

    def place_at(self, name: str, step: int) -> Spot:
        """Return where a player is drawn at a step of the diagram, or after it."""
        drawn = [(one.step, one.to) for one in self.elements if one.player == name]
        ways = [(when, to) for when, to in drawn if to and when <= step]
        return max(ways, key=lambda way: way[0])[1] if ways else self.player[name].at

    def faced(self, one: Element) -> str:
        """Return whom an act or an answer is to: who answers or acts in its step, or is named.

        Else it is to the partner of its player.
        """
        for said in self.activity.answers:
            if met := self._answering(one, said):
                return met
            if not one.other and self._does(one, said.answers):
                for act in self.elements:
                    if act.step == one.step and self._answering(act, said) == one.player:
                        return act.player
        return one.other or self.partner_of(one.player)

    def _answering(self, act: Element, said: Answers) -> str:
        """Return who answers an act in its step: who is named, if others are not drawn to; or "".

        A batter swings at what the pitcher throws to the catcher.
        """
        there = [e for e in self.elements if e.step == act.step and e.player != act.player]
        named = {e.other for e in there if act.other}
        met = [
            e.player
            for e in there
            if self._does(e, said.answers)
            if e.other == act.player or not (e.other or e.player in named)
        ]
        if not self._does(act, said.acts):
            return ""
        return act.other if act.other in met or not met else met[0]

    def _does(self, one: Element, actions: Sequence[str]) -> bool:
        """Return whether an element ends with one of these actions."""
        return set(self.verb(one, True).last) <= set(actions)

    def opponent_of(self, name: str) -> str:
        """Return a player's opponent: by ``guards``, else the nearest of another role, or ""."""
        player = self.player[name]
        if player.guards:
            return player.guards
        guarded = [other.name for other in self.players if other.guards == name]
        if guarded:
            return guarded[0]
        if player.team == PLAYER:
            return ""
        others = [other for other in self.players if other.team not in (player.team, PLAYER)]
        return self._nearest(player, others)

    def partner_of(self, name: str) -> str:
        """Return whom a player acts with: who leads, else the opponent, else the nearest."""
        player = self.player[name]
        leader = self.activity.leader_of(player.team)
        for team in (leader, *(role for role, of in self.activity.roles if of == player.team)):
            led = self._nearest(player, [p for p in self.players if p.team == team != ""])
            if led and not player.guards:
                return led
        others = [other for other in self.players if other.name != name]
        return self.opponent_of(name) or self._nearest(player, others)

    def filled(self, role: str, name: str) -> str:
        """Return the player who fills a role for another where no element says, or ""."""
        if role in (TARGET, RECEIVER):
            return ""
        if role == OPPONENT:
            return self.opponent_of(name)
        if role == PARTNER:
            return self.partner_of(name)
        here = self.player[name]
        return self._nearest(here, [p for p in self.players if p.team == role and p != here])

    def _nearest(self, player: Player, others: list[Player]) -> str:
        near = min(others, key=lambda other: _apart(other.at, player.at), default=None)
        return near.name if near else ""


def _apart(one: Spot, other: Spot) -> float:
    return float(((one.x - other.x) ** 2 + (one.z - other.z) ** 2) ** 0.5)


Directed = tuple[int, int, int]
"""The number of an act or an answer, its step (-1: not drawn), and the player it is to, or -1."""


def answered(
    said: Answers, acts: Sequence[Sequence[Directed]], replies: Sequence[Sequence[Directed]]
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield who acts and the act, and who answers and the answer; -1 for one that is missing.

    An answer is to who acted, unless it is an act, too: in a rally the ball is hit on to anybody.
    """
    rally, everybody = not set(said.acts).isdisjoint(said.answers), range(len(acts))
    groups = (
        [(everybody, n) for n in everybody]
        if rally
        else [(range(one, one + 1), other) for one, other in permutations(everybody, 2)]
    )
    for by, other in groups:
        asked = [(k, step, one) for one in by for k, step, to in acts[one] if to == other]
        asked.sort(key=lambda act: act[1])
        to = {m: who for m, _, who in replies[other]}
        given = [(m, step) for m, step, who in replies[other] if rally or who in by]
        for i, reply in aligned([(i, act[1]) for i, act in enumerate(asked)], given):
            yield (asked[i][2], asked[i][0]) if i >= 0 else (to[reply], -1), (other, reply)


def aligned(
    acts: Sequence[tuple[int, int]], replies: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return pairs of acts and answers in order, as many as possible, of the same step if possible.

    Acts and answers are given by number and step. -1 stands for one that is missing.

    >>> aligned([(0, 1), (3, 2)], [(1, 2)])
    [(0, -1), (3, 1)]
    """
    numbers = [[*(number for number, _ in of), -1] for of in (acts, replies)]
    worth = [[1.0 + 0.5 * (step == their) for _, their in replies] for _, step in acts]
    return [(numbers[0][k], numbers[1][m]) for k, m in paired(worth, len(replies))]


def paired(worth: Sequence[Sequence[float]], n_columns: int) -> list[tuple[int, int]]:
    """Return pairs of rows and columns, both in order, of the largest sum of their worth.

    -1 stands for what a row or a column is missing. What is worth less than 0 is no pair.

    >>> paired([[-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]], 3)
    [(-1, 0), (0, 1), (1, -1), (2, 2)]
    """
    best: list[list[tuple[float, list[tuple[int, int]]]]]
    best = [[(0.0, [(-1, m) for m in range(j)]) for j in range(n_columns + 1)]]
    for k, columns in enumerate(worth):
        row = [(best[k][0][0], [*best[k][0][1], (k, -1)])]
        for m, value in enumerate(columns):
            (left, one), (up, two), (both, three) = row[m], best[k][m + 1], best[k][m]
            row.append(
                max(
                    (up, [*two, (k, -1)]),  # the earliest of several that are as good
                    (left, [*one, (-1, m)]),
                    (both + value, [*three, (k, m)]),
                    key=lambda found: found[0],
                )
            )
        best.append(row)
    return best[-1][-1][1]
