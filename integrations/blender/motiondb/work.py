"""Work outside the thread of Blender's interface.

A job runs in a thread and may not touch Blender's data. What it returns is given to a function that
a timer of Blender calls, so that runs in the interface's thread.
"""

from __future__ import annotations

import queue
import threading
import traceback
from collections.abc import Callable
from typing import Any

import bpy

from .client import ServerError
from .skeletons import ArmatureError

_EVERY = 0.1  # Seconds between two looks at what is done
_done: queue.Queue[tuple[int, Callable[[Any], None], Any]] = queue.Queue()
_latest = 0  # Number of the job that was started last; answers of earlier ones are dropped


def start(says: str, job: Callable[[], Any], then: Callable[[Any], None]) -> threading.Thread:
    """Start a job; ``then`` gets what it returns, unless another one was started meanwhile."""
    global _latest
    _latest += 1
    number, state = _latest, bpy.context.window_manager.motiondb
    state.busy, state.error = says, ""

    def run() -> None:
        try:
            result = job()
        except ServerError as error:
            result = error
        except Exception as error:
            traceback.print_exc()
            result = ServerError(f"extension: expected an answer, found a fault: {error!r}.")
        _done.put((number, then, result))

    thread = threading.Thread(target=run, name="motiondb", daemon=True)
    thread.start()
    if not bpy.app.timers.is_registered(look):
        bpy.app.timers.register(look, first_interval=_EVERY)
    return thread


def look() -> float | None:
    """Pass on what is done; return the seconds to the next look, None if nothing is under way."""
    state = bpy.context.window_manager.motiondb
    while True:
        try:
            number, then, result = _done.get_nowait()
        except queue.Empty:
            break
        if number != _latest:
            continue
        state.busy = ""
        try:
            if isinstance(result, Exception):
                raise result
            then(result)
        except (ServerError, ArmatureError) as error:
            state.error = str(error)
        except Exception as error:  # shown, since a timer's error is only on the console
            traceback.print_exc()
            state.error = f"an error of the extension: {error!r}. The console has the details."
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()
    return _EVERY if state.busy else None


def forget() -> None:
    """Drop the answer that is awaited."""
    global _latest
    _latest += 1
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
