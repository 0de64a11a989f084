"""Parameters and replies that routes share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from fastapi import Query
from pydantic import BaseModel, ConfigDict, Field

LONGEST_TEXT = 2000  # Most characters of a question or a name in a request
MOST_SECONDS = 1e7  # Largest time, seconds: longer than any capture; excludes infinity
LARGEST_SEED = 2**63 - 1  # Largest integer of 64 bits

Start = Annotated[
    float | None, Query(ge=0.0, le=MOST_SECONDS, allow_inf_nan=False, description="Seconds.")
]
End = Start
Where = Annotated[
    str, Query(max_length=20_000, description="Filter, such as performer in (14, 16).")
]
Limit = Annotated[int, Query(ge=1, le=100, description="Largest number of answers.")]
RefText = Annotated[
    str, Query(min_length=1, max_length=LONGEST_TEXT, description="Such as capture:ana/walk_1.")
]
Name = Annotated[str, Query(min_length=1, max_length=LONGEST_TEXT, description="A name.")]
Seconds = Annotated[float, Field(ge=0.0, le=MOST_SECONDS, allow_inf_nan=False)]
Seed = Annotated[int, Field(ge=0, le=LARGEST_SEED)]
Text = Annotated[str, Field(max_length=LONGEST_TEXT)]


class Body(BaseModel):
    """The JSON body of a request; unknown keys are refused, so that typing errors are noticed."""

    model_config = ConfigDict(extra="forbid")


class Part(Body):
    """A ref, or a part of it."""

    ref: Annotated[str, Field(min_length=1, max_length=LONGEST_TEXT)]
    start: Seconds | None = None
    end: Seconds | None = None


class SaveBody(Body):
    """The motion to save, and the name of the new capture."""

    id: Text
    name: Annotated[str, Field(min_length=1, max_length=200)]


@dataclass(frozen=True)
class Saved:
    """The capture under which a motion was saved."""

    capture: str
    ref: str
