"""The answers of the verbs as JSON shows them: one dataclass for each, its fields the keys.

The commands print them with ``--json``, the page's routes answer with them, and the types of the
page's TypeScript are made from them. Times are in seconds.
"""
