"""The records of a scene's report; :mod:`.scene_report` measures them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RuleReport:
    """The report of one rule.

    Attributes
    ----------
    player : str
        Whose rule it is.
    action : str
        The first action that it is about.
    token : int
        Index of this action in the player's string.
    last : int
        Index after the last action.
    kind : str
        The kind of rule.
    about : str
        The player or place that it refers to, in words.
    unit : str
        Unit of the values.
    threshold : float
        Largest accepted value.
    frame : int
        Frame of the polished scene where it fails most.
    start : int
        First frame that was evaluated.
    end : int
        Frame after the last one.
    before : float
        Value before polishing.
    after : float
        Value after polishing.
    kept : bool
        Whether ``after`` is at most the threshold.
    unmet : bool
        Whether nobody fills its role; such a rule is never kept.
    """

    player: str
    action: str
    token: int
    last: int
    kind: str
    about: str
    unit: str
    threshold: float
    frame: int
    start: int
    end: int
    before: float
    after: float
    kept: bool
    unmet: bool = False


@dataclass(frozen=True)
class FeetReport:
    """Mean speed of feet on the ground, m/s.

    Attributes
    ----------
    player : str
        Name.
    slip : float
        In the scene.
    source_slip : float
        In its captures.
    """

    player: str
    slip: float
    source_slip: float


@dataclass(frozen=True)
class PaceReport:
    """Highest speed of a player's pelvis on the ground, m/s.

    Attributes
    ----------
    player : str
        Name.
    before : float
        Before polishing.
    after : float
        After polishing.
    """

    player: str
    before: float
    after: float


@dataclass(frozen=True)
class SourceRun:
    """Consecutive frames of a player from one source with the same edits.

    Attributes
    ----------
    player : str
        Name.
    start : int
        First frame of the scene.
    end : int
        Frame after the last one.
    capture : str
        Name of the capture.
    source_start : float
        Its frame at ``start``.
    source_end : float
        Its frame at the last frame.
    edit : str
        What was done.
    licence : str
        Licence of the capture.
    """

    player: str
    start: int
    end: int
    capture: str
    source_start: float
    source_end: float
    edit: str
    licence: str


@dataclass(frozen=True)
class Collision:
    """Two players overlap.

    Attributes
    ----------
    players : tuple[str, str]
        Their names.
    start : int
        First frame.
    end : int
        Frame after the last one.
    depth : float, m
        Largest overlap of their discs.
    """

    players: tuple[str, str]
    start: int
    end: int
    depth: float


@dataclass(frozen=True)
class ImpossibleMotion:
    """Frames of a motion that is impossible, or does not occur in this action.

    Attributes
    ----------
    kind : str
        "airborne": both feet in the air for too long; "speed": travelling too fast; "step": feet
        too far apart; "foot jump": a planted foot is displaced; "limbs": limbs of two players pass
        through one another.
    players : tuple of str
        The player, or two for limbs.
    action : str
        The action; "waiting" between actions; "" for limbs.
    start : int
        First frame.
    end : int
        Frame after the last one.
    frame : int
        The worst frame.
    value : float
        The largest value (for limbs the least distance).
    limit : float
        The accepted value.
    unit : str
        Unit of both.
    """

    kind: str
    players: tuple[str, ...]
    action: str
    start: int
    end: int
    frame: int
    value: float
    limit: float
    unit: str


@dataclass(frozen=True)
class JumpReport:
    """The largest displacement of a planted foot of a player within 2 to 9 frames.

    Attributes
    ----------
    player : str
        Name.
    foot : str
        "left" or "right"; "" if no foot was ever planted.
    metres : float, m
        The displacement.
    start : int
        First frame of it.
    end : int
        Its last frame.
    source_metres : float, m
        The largest one in the player's captures.
    """

    player: str
    foot: str
    metres: float
    start: int
    end: int
    source_metres: float


@dataclass(frozen=True)
class LimbReport:
    """The smallest distance of the limbs of two players.

    Attributes
    ----------
    players : tuple of str
        Their names.
    metres : float, m
        Least distance between the axes of their bones.
    frame : int
        The frame of it.
    n_frames : int
        Number of frames in which it is less than 5 cm.
    """

    players: tuple[str, str]
    metres: float
    frame: int
    n_frames: int


@dataclass(frozen=True)
class GuardReport:
    """The distance of a guard to the guarded player, over all frames of the scene.

    The rule itself looks at the frames of guarding only.

    Attributes
    ----------
    player : str
        The guard.
    target : str
        The guarded player.
    near : float, m
        Least distance of the rule.
    far : float, m
        Largest distance of the rule.
    n_frames : int
        Frames in which the rule looks.
    outside : float
        Fraction of all frames of the scene in which the distance is outside these bounds.
    farthest : float, m
        The largest distance.
    frame : int
        The frame of it.
    """

    player: str
    target: str
    near: float
    far: float
    n_frames: int
    outside: float
    farthest: float
    frame: int


@dataclass(frozen=True, eq=False)
class SceneReport:
    """The report of a scene.

    Attributes
    ----------
    n_characters : int
        Number of players.
    n_instances : int
        Number of clips.
    n_frames : int
        Number of frames.
    rules : tuple of RuleReport
        The rules.
    collisions_before : tuple of Collision
        Collisions before polishing.
    collisions : tuple of Collision
        Collisions after polishing.
    feet : tuple of FeetReport
        Speeds of feet on the ground.
    paces : tuple of PaceReport
        Speeds of the players; a rule that was made true by inhuman speed shows here.
    bone_error : float, m
        Largest difference of a bone from its length in the body.
    ball_gap : float, m
        Largest distance from the ball's centre to the nearest palm while it is held; NaN without a
        ball.
    sources : tuple of SourceRun
        Origin of the frames.
    impossible : tuple of ImpossibleMotion
        Motion that people cannot do, or never do in an action.
    jumps : tuple of JumpReport
        The largest displacements of planted feet.
    limbs : tuple of LimbReport
        Pairs of players whose limbs come close.
    guards : tuple of GuardReport
        Distances of guards over all frames.
    """

    n_characters: int
    n_instances: int
    n_frames: int
    rules: tuple[RuleReport, ...]
    collisions_before: tuple[Collision, ...]
    collisions: tuple[Collision, ...]
    feet: tuple[FeetReport, ...]
    paces: tuple[PaceReport, ...]
    bone_error: float
    ball_gap: float
    sources: tuple[SourceRun, ...]
    impossible: tuple[ImpossibleMotion, ...] = ()
    jumps: tuple[JumpReport, ...] = ()
    limbs: tuple[LimbReport, ...] = ()
    guards: tuple[GuardReport, ...] = ()

    @property
    def broken(self) -> tuple[RuleReport, ...]:
        """The rules that do not hold."""
        return tuple(rule for rule in self.rules if not rule.kept)

    @property
    def clean(self) -> bool:
        """Whether every rule holds, no players overlap, and no motion is impossible."""
        return not self.broken and not self.collisions and not self.impossible
