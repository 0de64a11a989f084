"""Tactics diagrams: players of two teams on a court, and their actions with and without the ball.

The elements are those of a coach's board: a circle is a player, a solid curve a move, a dashed
arrow a pass, a solid arrow to the rim a shot, a zigzag a feint, fake or pivot, and a curve with a T
at its end a screen. The paper leaves time to the drawing. Here every element has a step, and a pass
has a second one at which it is caught. Elements of lower steps come first; a player's elements of
one step come in the order of the file.

The ground is the court seen from above with the rim at the top. The origin is below the middle of
the rim, x points to the right and z away from the baseline, in metres. The half court is that of
FIBA: 15 m wide, 14 m long, the middle of the rim 1.575 m from the baseline.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from motiondb.scene.language.semantic_rules import Spot

ATTACK, DEFENCE, PLAYER = "attack", "defence", "player"
TEAMS = (ATTACK, DEFENCE, PLAYER)  # Teams of players; ``player`` is for people without a team

MOVES = ("move", "walk", "run", "cut", "dribble")
SHOTS = ("shoot", "layup")
FEINTS = ("feint", "fake", "pivot_left", "pivot_right")
STANDS = ("guard", "block")
KINDS = (*MOVES, "pass", *SHOTS, "screen", *FEINTS, *STANDS)
"""Kinds of elements. A move is a dribble for the player with the ball; a cut is a run."""

BODY_WIDTH = 0.5
"""Smallest distance between two players, m: about the width of a body. Nearer players touch."""

WITH_BALL = ("dribble", "pass", *SHOTS, "fake", "pivot_left", "pivot_right")
WITHOUT_BALL = ("walk", "run", "cut", "screen", "feint")


@dataclass(frozen=True)
class Court:
    """The ground that may be used."""

    width: float = 15.0
    length: float = 14.0
    behind_rim: float = 1.575  # Distance from the baseline to the origin
    lines: bool = True  # Whether the lines of basketball are drawn

    def holds(self, spot: Spot) -> bool:
        """Return whether a point is on the court, its edge included."""
        across = abs(spot.x) <= self.width / 2
        return across and -self.behind_rim <= spot.z <= self.length - self.behind_rim


@dataclass(frozen=True)
class Player:
    """A player at the beginning of the play."""

    name: str
    team: str
    at: Spot  # Position of the player
    guards: str = ""  # Name of the guarded opponent; "" if none is named
    line: int = 0  # Line of the file


@dataclass(frozen=True)
class Element:
    """An action of a player in a diagram."""

    kind: str
    step: int  # When it begins, from 1
    player: str  # The player who acts
    # Receiver of a pass, or the player who is screened, guarded, blocked or run at; or ""
    other: str = ""
    via: tuple[Spot, ...] = ()  # Points that the player's curve passes
    to: Spot | None = None  # End of the curve; None if the player stays
    caught: int = 0  # The step at which a pass arrives; 0 for the same as ``step``
    line: int = 0  # Line of the file

    def __str__(self) -> str:
        """Return the element in words, for messages."""
        link = " to " if self.kind == "pass" else " on "
        return f"{self.kind} {self.player}{link if self.other else ''}{self.other}"


@dataclass(frozen=True)
class Act:
    """An element from the side of one player who takes part in it."""

    element: int  # Index of the element
    part: str = "own"  # "own", "catch" or "push"


@dataclass(frozen=True)
class Diagram:
    """A play."""

    name: str
    players: tuple[Player, ...]
    elements: tuple[Element, ...]
    grammar: str = "basketball"  # Name of the grammar that the play follows
    court: Court = field(default_factory=Court)
    # Names and positions of places that rules may refer to
    places: tuple[tuple[str, Spot], ...] = (("rim", Spot(0.0, 0.0)),)
    ball: str = ""  # Name of the first holder of the ball; "" if the file does not say

    @cached_property
    def player(self) -> dict[str, Player]:
        """Players by name."""
        return {player.name: player for player in self.players}

    @cached_property
    def acts(self) -> dict[str, tuple[Act, ...]]:
        """Acts of each player in the order of time; players are in the order of the file."""
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
        """Return a player's opponent: by ``guards``, else the nearest of the other team, or ""."""
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
