"""The answers of the verbs as JSON shows them: one dataclass for each, its fields the keys.

The commands print them with ``--json``, the page's routes answer with them, and the types of the
page's TypeScript are made from them. Times are in seconds. ``motiondb.answers.NAME`` imports the
module of a name when it is first used, so that the command line starts fast.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
