"""Generated motions and sequences that the server keeps for a while, each under an id.

A value that is requested counts as new again, so that values in use are not dropped.

Ids are random, so that a page that was loaded before a restart of the server does not get a wrong
value.
"""

from __future__ import annotations

import secrets
import threading
from collections import OrderedDict
from typing import Generic, TypeVar

from motiondb.page.answers import unknown

T = TypeVar("T")


class Shelf(Generic[T]):
    """The most recently used values of one kind, by id."""

    def __init__(self, prefix: str, what: str, most: int = 200) -> None:
        self._prefix, self._what, self._most = prefix, what, most
        self._values: OrderedDict[str, T] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, value: T) -> str:
        """Keep a value, and return its id."""
        with self._lock:
            name = f"{self._prefix}{secrets.token_hex(5)}"
            self._values[name] = value
            while len(self._values) > self._most:
                self._values.popitem(last=False)
            return name

    def find(self, name: str) -> T | None:
        """Return the value of an id, or None. It counts as new again."""
        with self._lock:
            if name in self._values:
                self._values.move_to_end(name)
            return self._values.get(name)

    def get(self, name: str) -> T:
        """Return the value of an id. It counts as new again."""
        value = self.find(name)
        if value is None:
            raise unknown(
                self._what, name, f"The server keeps the newest {self._most}. Make it again."
            )
        return value

    def replace(self, name: str, value: T) -> None:
        """Replace the value of an id, if it is still there."""
        with self._lock:
            if name in self._values:
                self._values[name] = value

    def names(self) -> list[str]:
        """Return the ids, most recently used first."""
        with self._lock:
            return list(reversed(self._values))
