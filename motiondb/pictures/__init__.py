"""Pictures of motions, symbols and answers: PNG, and animations as GIF.

``motiondb.pictures.NAME`` imports the module of a name when it is first used: a command that draws
nothing does not wait for matplotlib.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
