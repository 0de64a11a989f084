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
        Whom or what it is about, in words.
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
        Where the frames come from.
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

    @property
    def broken(self) -> tuple[RuleReport, ...]:
        """The rules that do not hold."""
        return tuple(rule for rule in self.rules if not rule.kept)

    @property
    def clean(self) -> bool:
        """Whether every rule holds and no players overlap."""
        return not self.broken and not self.collisions
