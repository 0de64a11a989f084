"""The store: one DuckDB file. The only part of motiondb that knows DuckDB.

Open it with :func:`open_store`; functions ``load_...`` and ``save_...`` take the open store first.
``schema.sql`` in ``motiondb.schema`` describes the tables. A module is imported when one of its
names is first used, so that the command line starts fast.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
