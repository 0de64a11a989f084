"""motiondb: a motion-capture database that understands what is in it.

Open a database with :func:`open`; everything that the commands do is a method of the
:class:`MotionDB` that it gives, or a function here if it needs no open database. The commands
use nothing but these names.

>>> import motiondb
>>> [name for name in dir(motiondb) if name.startswith("write")]
['write_bvh', 'write_gltf', 'write_table']
"""

import lazy_loader

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
