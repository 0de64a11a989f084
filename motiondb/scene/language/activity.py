"""What an activity is made of: verbs, roles, an object, places, ground and rest.

The grammar says all of it. A diagram draws **verbs**. Every action of the grammar is one; a line
``verb move = walk | run`` declares others. A **role** is what players are called (attack, leader).
One **object** (a ball, a cup) is taken, kept, given, sent or put down by actions. A **place** has a
height and a size if something is aimed at it (a ring, a goal). The **ground** has a size and marks.
**Rest** is what somebody does who has nothing to do. Nothing here knows any activity by name.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4, where all of this is basketball's.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.scene.language.semantic_rules import Spot

PLAYER = "player"  # The role of people without one
RECEIVER, OPPONENT, PARTNER, TARGET = "receiver", "opponent", "partner", "target"
ROLES = (RECEIVER, OPPONENT, PARTNER, TARGET)
"""Roles that every grammar's rules may name: the player or place that an element names (receiver,
target), the nearest player of another role (opponent), and whoever one acts with (partner)."""

TAKE, KEEP, BOUNCE, GIVE, SEND, PUT = "take", "keep", "bounce", "give", "send", "put"
STRIKE = "strike"  # Sends it from where it lies, without a hand
DEEDS = (TAKE, KEEP, BOUNCE, GIVE, SEND, PUT, STRIKE)
"""What an action does with the object: at its event, or, for keep and bounce, all the time."""
KEEPING = (KEEP, BOUNCE)
LOSING = (GIVE, SEND, PUT)
_OVERHEAD = 2.0  # Height, m, from which on people walk below a level place
_SHORT, _LONG = 15, 30  # Frames to which resting may be cut, and resting that belongs to an action


@dataclass(frozen=True)
class Place:
    """A place that rules and flights may name."""

    name: str
    at: Spot | None = None  # None if a diagram must say it
    height: float = 0.0  # Of its middle, m
    width: float = 0.0  # m; 0 for a mere place
    tall: float = (
        0.0  # Height of an upright rectangle, m; 0 for a level disc, such as a ring or seat
    )

    @property
    def is_upright(self) -> bool:
        """Whether it is a rectangle like a goal, which things enter from the front."""
        return self.tall > 0.0

    @property
    def is_in_the_way(self) -> bool:
        """Whether it stands on the ground as a table does, so that nobody walks through it."""
        return not self.is_upright and 0.0 < self.height < _OVERHEAD

    def leading_into(self, rows: NDArray[np.void]) -> NDArray[np.bool_]:
        """Return which rows of a table of rules lead into it, as onto a chair."""
        at = self.at or Spot(math.nan, math.nan)
        here = (rows["target"] < 0) & (rows["x"] == at.x) & (rows["z"] == at.z)
        return np.asarray(here & (rows["far"] < self.width / 2.0 + 0.1))


@dataclass(frozen=True)
class Ground:
    """The ground that may be used, and what is drawn on it."""

    name: str = ""  # What diagrams call it
    width: float = 20.0
    length: float = 20.0
    left: float = -10.0  # Least x
    back: float = -10.0  # Least z
    # Lines through points (x, height, z), m
    marks: tuple[tuple[tuple[float, float, float], ...], ...] = ()

    @classmethod
    def field(cls, width: float, length: float) -> Ground:
        """Return a ground without marks whose origin is its middle."""
        return cls("", width, length, -width / 2, -length / 2)

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Least and largest x, least and largest z."""
        return self.left, self.left + self.width, self.back, self.back + self.length

    def holds(self, spot: Spot) -> bool:
        """Return whether a point is on the ground, its edge included."""
        left, right, back, front = self.corners
        return left <= spot.x <= right and back <= spot.z <= front


@dataclass(frozen=True)
class Step:
    """One class of actions of a verb."""

    actions: tuple[str, ...]
    repeated: bool | None = None  # None: if it leads somewhere


@dataclass(frozen=True)
class Verb:
    """What an element of a diagram may ask of a player."""

    name: str
    steps: tuple[Step, ...]
    link: str = ""  # The word before the other player or place; "" if none is needed
    role: str = ""  # Who is meant: a role, or a place
    goes: bool = False  # Whether it ends at a point of the ground
    with_object: bool = False  # Whether it is for who has the object
    declared: bool = True

    @property
    def last(self) -> tuple[str, ...]:
        """The actions of its last class, which are linked with others."""
        return self.steps[-1].actions

    @property
    def must_go(self) -> bool:
        """Whether an element without an end is incomplete."""
        return self.goes and len(self.steps) == 1 and self.steps[0].repeated is not False


@dataclass(frozen=True)
class Rest:
    """What somebody does who has nothing to do."""

    action: str
    with_object: bool = False  # Only for who has the object
    doing: tuple[str, ...] = ()  # Only for players who do one of these at any time
    after: tuple[str, ...] = ()  # Only after one of these


@dataclass(frozen=True)
class Answers:
    """Actions that answer others one to one and in order."""

    answers: tuple[str, ...]
    acts: tuple[str, ...]
    lag: float = 0.0  # Seconds from the event of the act to that of the answer


@dataclass(frozen=True)
class Thing:
    """The object of an activity."""

    name: str
    size: float = 0.24  # Diameter, m
    at: str = ""  # The place where it lies at first; "" if somebody has it


@dataclass(frozen=True)
class Activity:
    """The part of a grammar that diagrams, flights and pictures need.

    Without ``actions`` any word is a verb: for texts whose grammar is not known.
    """

    actions: tuple[str, ...] = ()
    declared: tuple[Verb, ...] = ()
    roles: tuple[tuple[str, str], ...] = ()  # Each with the role that it belongs to, or ""
    thing: Thing | None = None
    deeds: tuple[tuple[str, str, str], ...] = ()  # Action, what it does with the object, to what
    rests: tuple[Rest, ...] = ()
    answers: tuple[Answers, ...] = ()
    # Action, role, actions: what the other player must do, by the grammar's synchronisations
    replies: tuple[tuple[str, str, tuple[str, ...]], ...] = ()
    places: tuple[Place, ...] = ()
    ground: Ground = field(default_factory=Ground)

    @cached_property
    def verbs(self) -> dict[str, tuple[Verb, ...]]:
        """The verbs by name: the declared ones, then the actions."""
        found: dict[str, tuple[Verb, ...]] = {}
        for verb in self.declared:
            found[verb.name] = (*found.get(verb.name, ()), verb)
        for action in self.actions:
            found.setdefault(action, (Verb(action, (Step((action,)),), declared=False),))
        return found

    def verb(self, name: str, holds: bool = False) -> Verb:
        """Return a verb as it is meant for somebody who ``holds`` the object, or not."""
        forms = self.verbs.get(name)
        if forms is None:
            return Verb(name, (Step((name,)),), declared=False)
        fit = [form for form in forms if form.with_object == holds]
        return (fit or list(forms))[0]

    @cached_property
    def place(self) -> dict[str, Place]:
        """The places by name."""
        return {place.name: place for place in self.places}

    @cached_property
    def teams(self) -> tuple[str, ...]:
        """The roles that a diagram may give to players."""
        return (*(name for name, _ in self.roles), PLAYER)

    def leader_of(self, role: str) -> str:
        """Return the role that a role belongs to (``follower of leader``), or ""."""
        return dict(self.roles).get(role, "")

    @cached_property
    def _deeds(self) -> dict[str, tuple[str, str]]:
        return {action: (deed, to) for action, deed, to in self.deeds}

    def deed(self, action: str) -> str:
        """Return what an action does with the object, or ""."""
        return self._deeds.get(action, ("", ""))[0]

    def aim(self, action: str) -> str:
        """Return the place that an action sends or puts the object to, by the grammar, or ""."""
        return self._deeds.get(action, ("", ""))[1]

    def doing(self, *deeds: str) -> tuple[str, ...]:
        """Return the actions that do one of these with the object."""
        return tuple(action for action, deed, _ in self.deeds if deed in deeds)

    def begins(self, verb: Verb, *deeds: str) -> bool:
        """Return whether the first step of a verb that does something with the object does this."""
        for step in verb.steps:
            done = {self.deed(action) for action in step.actions}
            if done != {""}:
                return done <= set(deeds)
        return False

    def free(self, verb: Verb) -> bool:
        """Return whether a verb can only be done without the object.

        The grammar must say which actions keep it; then all others are done with empty hands.
        """
        actions = [action for step in verb.steps for action in step.actions]
        return bool(self.doing(*KEEPING)) and not any(self.deed(action) for action in actions)

    def look(self, verb: str, holds: bool) -> str:
        """Return how an element is drawn for somebody who ``holds`` the object, or not.

        It is ``give``, ``send``, ``link`` (to another player who is near), ``wave`` (a way with the
        object), ``way``, or ``act`` (something done in place, or once on a way).
        """
        form = self.verb(verb, holds)
        deeds = {self.deed(action) for action in form.last}
        if deeds & {GIVE, SEND, STRIKE}:
            return GIVE if GIVE in deeds else SEND
        if form.link and not form.goes:
            return "link"
        if form.goes and form.steps[-1].repeated is not False:
            return "wave" if deeds & set(KEEPING) else "way"
        return "act"

    def first_rest(self) -> str:
        """Return what somebody does who has the object at first, or ""."""
        return next((rest.action for rest in self.rests if rest.with_object), "")

    def rests_of(self, played: Collection[str], holds: bool, before: str = "") -> tuple[str, ...]:
        """Return how somebody rests who does ``played``, after ``before``; best first."""
        sure = [rest.action for rest in self.rests if before in rest.after]
        if sure:  # nobody stands up to rest
            return tuple(sure)
        found = [rest.action for rest in self.rests if set(rest.doing) & set(played)][:1]
        plain = [rest for rest in self.rests if not rest.doing and not rest.after]
        plain.sort(key=lambda rest: rest.with_object != holds)
        return (*found, *(rest.action for rest in plain))

    def shortest_rest(self, action: str) -> int:
        """Return to how many frames a rest may be cut if nobody needs it; 0 for other actions."""
        rests = [rest for rest in self.rests if rest.action == action]
        return max((_LONG if rest.doing else _SHORT for rest in rests), default=0)

    def follows(self, action: str) -> bool:
        """Return whether somebody who does this attends to others while they wait, too."""
        return any(action in rest.doing for rest in self.rests)

    def partners_act(self, actions: Collection[str]) -> tuple[tuple[str, ...], ...]:
        """Return what the other player of an element must do: a class of actions each.

        What the other does with the object, such as the shot that is blocked, is drawn by itself.
        """
        own = self.doing(*KEEPING, *LOSING)
        classes = {
            to: None
            for action, _, to in self.replies
            if action in actions and not set(to) & set(own)
        }
        if not classes and any(self.deed(action) == GIVE for action in actions):
            return (self.doing(TAKE),) if self.doing(TAKE) else ()
        return tuple(classes)
