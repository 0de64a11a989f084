"""Download public captures, for users who have a network, into a folder that ``add`` reads."""

from motiondb.fetch.cmu import CMU_TERMS, CMU_URL, FetchSettings, fetch_cmu
from motiondb.fetch.download import FetchLimits

__all__ = ["CMU_TERMS", "CMU_URL", "FetchLimits", "FetchSettings", "fetch_cmu"]
