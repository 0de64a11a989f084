"""The records of a scene's report; :mod:`.scene_report` measures them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RuleReport:
    """The report of one rule."""

    player: str  # Whose rule it is
    action: str  # The first action that it is about
    token: int  # Index of this action in the player's string
    last: int  # Index after the last action
    kind: str  # The kind of rule
    about: str  # The player or place that it refers to, in words
    unit: str  # Unit of the values
    threshold: float
    frame: int  # Frame of the polished scene where it fails most
    start: int  # First frame that was evaluated
    end: int  # Frame after the last one
    before: float
    after: float
    kept: bool  # Whether ``after`` is at most the threshold
    unmet: bool = False  # Whether nobody fills its role; such a rule is never kept


@dataclass(frozen=True)
class FeetReport:
    """Mean speed of feet on the ground, m/s."""

    player: str
    slip: float
    source_slip: float


@dataclass(frozen=True)
class PaceReport:
    """Highest speed of a player's pelvis on the ground, m/s."""

    player: str
    before: float
    after: float


@dataclass(frozen=True)
class SourceRun:
    """Consecutive frames of a player from one source with the same edits."""

    player: str
    start: int  # First frame of the scene
    end: int  # Frame after the last one
    capture: str  # Name of the capture
    source_start: float  # Its frame at ``start``
    source_end: float  # Its frame at the last frame
    edit: str
    licence: str  # Licence of the capture


@dataclass(frozen=True)
class Collision:
    """Two players overlap."""

    players: tuple[str, str]
    start: int
    end: int  # Frame after the last one
    depth: float  # Largest overlap of their discs


@dataclass(frozen=True)
class ImpossibleMotion:
    """Frames of a motion that is impossible, or does not occur in this action."""

    # "airborne": both feet in the air for too long; "speed": travelling too fast; "step": feet too
    # far apart; "foot jump": a planted foot is displaced; "limbs": limbs of two players pass
    # through one another
    kind: str
    players: tuple[str, ...]  # The player, or two for limbs
    action: str  # The action; "waiting" between actions; "" for limbs
    start: int
    end: int  # Frame after the last one
    frame: int
    value: float  # The largest value (for limbs the least distance)
    limit: float
    unit: str


@dataclass(frozen=True)
class JumpReport:
    """The largest displacement of a planted foot of a player within 2 to 9 frames."""

    player: str
    foot: str  # "left" or "right"; "" if no foot was ever planted
    metres: float
    start: int  # First frame of it
    end: int
    source_metres: float  # The largest one in the player's captures


@dataclass(frozen=True)
class LimbReport:
    """The smallest distance of the limbs of two players."""

    players: tuple[str, str]
    metres: float  # Least distance between the axes of their bones
    frame: int  # The frame of it
    n_frames: int  # Number of frames in which it is less than 5 cm


@dataclass(frozen=True)
class SeenFault:
    """Something that a viewer sees at once although no rule is about it."""

    # "guard": a declared guard is too far away; "stands": somebody stands for most of the scene;
    # "held pose": nothing moves; "misses": what is sent does not reach its target; "object": it
    # passes through somebody; "reach": it is not where somebody takes it; "order": a step comes
    # after a later one; "place": somebody goes through a table or the like; "limbs": those of two
    # touch; "leap": an action follows another although no clip of it begins like that
    kind: str
    players: tuple[str, ...]  # The player, and whom or what it is about
    start: int
    end: int  # Frame after the last one
    value: float
    unit: str


@dataclass(frozen=True)
class GuardReport:
    """The distance of a declared guard to the guarded player, over all frames of the scene.

    The grammar's rule itself looks at the frames of guarding only.
    """

    player: str
    target: str
    near: float  # Least distance of the rule
    far: float | None  # Largest distance of the rule; None where it has none
    n_frames: int  # Frames in which the rule looks
    # Fraction of all frames of the scene in which the distance is outside these bounds
    outside: float
    farthest: float
    frame: int  # The frame of it


@dataclass(frozen=True, eq=False)
class SceneReport:
    """The report of a scene."""

    n_characters: int
    n_instances: int
    n_frames: int
    rules: tuple[RuleReport, ...]
    collisions_before: tuple[Collision, ...]
    collisions: tuple[Collision, ...]
    feet: tuple[FeetReport, ...]  # Speeds of feet on the ground
    # Speeds of the players; a rule that was made true by inhuman speed shows here
    paces: tuple[PaceReport, ...]
    bone_error: float  # Largest difference of a bone from its length in the body
    # Largest distance from the ball's centre to the nearest palm while it is held; NaN without a
    # ball
    ball_gap: float
    sources: tuple[SourceRun, ...]  # Origin of the frames
    # Motion that people cannot do, or never do in an action
    impossible: tuple[ImpossibleMotion, ...] = ()
    jumps: tuple[JumpReport, ...] = ()  # The largest displacements of planted feet
    limbs: tuple[LimbReport, ...] = ()  # Pairs of players whose limbs come close
    guards: tuple[GuardReport, ...] = ()  # Distances of guards over all frames
    seen: tuple[SeenFault, ...] = ()  # What a viewer sees at once

    @property
    def broken(self) -> tuple[RuleReport, ...]:
        """The rules that do not hold."""
        return tuple(rule for rule in self.rules if not rule.kept)

    @property
    def clean(self) -> bool:
        """Whether every rule holds, no players overlap, and no motion is impossible."""
        return not self.broken and not self.collisions and not self.impossible
