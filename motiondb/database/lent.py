"""A database that is open only while it is used, so that other processes can use it as well."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

Opened = TypeVar("Opened")


class Lent(Generic[Opened]):
    """A database or session that is released when the last of those who use it has ended.

    `release`: Closes its file until the next use, which opens it again.
    """

    def __init__(self, opened: Opened, release: Callable[[], None]) -> None:
        self.opened, self._release = opened, release
        self._lock = threading.Lock()
        self._users = 0
        release()

    @contextmanager
    def use(self) -> Iterator[Opened]:
        """Yield it; its file stays open for the length of the ``with`` block."""
        with self._lock:
            self._users += 1
        try:
            yield self.opened
        finally:
            with self._lock:
                self._users -= 1
                if not self._users:
                    self._release()

    @property
    def is_used(self) -> bool:
        """Whether anybody uses it now."""
        return self._users > 0
