"""Download public captures, for users who have a network, into a folder that ``add`` reads."""

from motiondb.fetch.cmu import (
    CMU_TERMS,
    CMU_URL,
    FetchProgress,
    FetchReport,
    FetchSettings,
    fetch_cmu,
)
from motiondb.fetch.limits import FetchLimits, Patience

__all__ = [
    "CMU_TERMS",
    "CMU_URL",
    "FetchLimits",
    "FetchProgress",
    "FetchReport",
    "FetchSettings",
    "Patience",
    "fetch_cmu",
]
