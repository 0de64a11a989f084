"""The answers of the verbs as JSON shows them: one dataclass for each, its fields the keys.

The commands print them with ``--json``, the page's routes answer with them, and the types of the
page's TypeScript are made from them. Times are in seconds. ``motiondb.answers.NAME`` imports the
module of a name when it is first used, so that the command line starts fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.answers.catalogue import *  # noqa: F403
    from motiondb.answers.changes import *  # noqa: F403
    from motiondb.answers.database import *  # noqa: F403
    from motiondb.answers.grammars import *  # noqa: F403
    from motiondb.answers.knowledge import *  # noqa: F403
    from motiondb.answers.learning import *  # noqa: F403
    from motiondb.answers.making import *  # noqa: F403
    from motiondb.answers.plain import *  # noqa: F403
    from motiondb.answers.questions import *  # noqa: F403
    from motiondb.answers.scenes import *  # noqa: F403

_MODULES = (  # Those that load least come first
    *("plain", "knowledge", "database", "catalogue", "changes", "learning"),
    *("questions", "making", "grammars", "scenes"),
)


def __getattr__(name: str) -> object:
    """Import the module that has a name."""
    for each in () if name.startswith("_") or name in _MODULES else _MODULES:
        module = import_module(f"{__name__}.{each}")
        if hasattr(module, name):
            return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
