"""Tactics diagrams: players of two teams on a court, and what they do with and without the ball.

The elements are those of a coach's board: a circle is a player, a solid curve a move, a dashed
arrow a pass, a solid arrow to the rim a shot, a zigzag a feint, fake or pivot, and a curve with a T
at its end a screen. Print leaves time to the drawing; here every element has a step, and a pass a
second one, at which it is caught. Elements of lower steps come first; of one step, a player's come
in the order of the file.

The ground is the court seen from above with the rim at the top: the origin below the middle of the
rim, x to the right, z away from the baseline, metres. The half court is FIBA's: 15 m wide, 14 m
long, the rim's middle 1.575 m from the baseline.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from motiondb.scene.language.semantic_rules import Spot

ATTACK, DEFENCE, PLAYER = "attack", "defence", "player"
TEAMS = (ATTACK, DEFENCE, PLAYER)
"""Attackers, defenders, and people of whom no team is said."""

MOVES = ("move", "walk", "run", "cut", "dribble")
SHOTS = ("shoot", "layup")
FEINTS = ("feint", "fake", "pivot_left", "pivot_right")
STANDS = ("guard", "block")
KINDS = (*MOVES, "pass", *SHOTS, "screen", *FEINTS, *STANDS)
"""What an element can be. A move is a dribble for who has the ball; a cut is a run."""

BODY_WIDTH = 0.5
"""Metres: two who stand nearer to one another touch."""

WITH_BALL = ("dribble", "pass", *SHOTS, "fake", "pivot_left", "pivot_right")
WITHOUT_BALL = ("walk", "run", "cut", "screen", "feint")


@dataclass(frozen=True)
class Court:
    """The ground that may be used, metres, and whether the lines of basketball are on it."""

    width: float = 15.0
    length: float = 14.0
    behind_rim: float = 1.575
    lines: bool = True

    def holds(self, spot: Spot) -> bool:
        """Whether a point is on the court, its edge included."""
        across = abs(spot.x) <= self.width / 2
        return across and -self.behind_rim <= spot.z <= self.length - self.behind_rim


@dataclass(frozen=True)
class Player:
    """Who stands where when the play begins, and whom they guard ("" where nobody is named)."""

    name: str
    team: str
    at: Spot
    guards: str = ""
    line: int = 0


@dataclass(frozen=True)
class Element:
    """A thing that a player does.

    Attributes
    ----------
    step : when it begins, from 1.
    other : receiver of a pass; who is screened, guarded, blocked or run at; "" where nobody is.
    via, to : points of its way; ``to`` None where it leads nowhere.
    caught : the step at which a pass arrives; else the same as ``step``.
    """

    kind: str
    step: int
    player: str
    other: str = ""
    via: tuple[Spot, ...] = ()
    to: Spot | None = None
    caught: int = 0
    line: int = 0

    def __str__(self) -> str:
        link = " to " if self.kind == "pass" else " on "
        return f"{self.kind} {self.player}{link if self.other else ''}{self.other}"


@dataclass(frozen=True)
class Act:
    """An element as one player takes part in it: ``part`` is "own", "catch" or "push"."""

    element: int
    part: str = "own"


@dataclass(frozen=True)
class Diagram:
    """A play. ``ball`` names who has the ball at first, "" where the file does not say."""

    name: str
    players: tuple[Player, ...]
    elements: tuple[Element, ...]
    grammar: str = "basketball"
    court: Court = field(default_factory=Court)
    places: tuple[tuple[str, Spot], ...] = (("rim", Spot(0.0, 0.0)),)
    ball: str = ""

    @cached_property
    def player(self) -> dict[str, Player]:
        """Players by name."""
        return {player.name: player for player in self.players}

    @cached_property
    def acts(self) -> dict[str, tuple[Act, ...]]:
        """What each player does, in the order of time; players of the file, in its order."""
        rows: dict[str, list[tuple[int, int, Act]]] = {player.name: [] for player in self.players}
        for number, element in enumerate(self.elements):
            if element.player in rows:
                rows[element.player].append((element.step, number, Act(number)))
            if element.kind == "pass" and element.other in rows:
                step = element.caught or element.step
                rows[element.other].append((step, number, Act(number, "catch")))
            if element.kind == "screen" and element.other in rows:
                rows[element.other].append((element.step, number, Act(number, "push")))
        return {
            name: tuple(act for _, _, act in sorted(acts, key=lambda row: row[:2]))
            for name, acts in rows.items()
        }

    def opponent_of(self, name: str) -> str:
        """Who plays against a player: by ``guards``, else the nearest of the other team; or ""."""
        player = self.player[name]
        if player.guards:
            return player.guards
        guarded = [other.name for other in self.players if other.guards == name]
        if guarded:
            return guarded[0]
        other_team = {ATTACK: DEFENCE, DEFENCE: ATTACK}.get(player.team, "")
        others = [other for other in self.players if other.team == other_team]
        near = min(others, key=lambda other: _apart(other.at, player.at), default=None)
        return near.name if near else ""


def _apart(one: Spot, other: Spot) -> float:
    return float(((one.x - other.x) ** 2 + (one.z - other.z) ** 2) ** 0.5)
