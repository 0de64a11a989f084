"""Public captures for users who have a network: from a site to a folder that ``add`` reads."""

from motiondb.fetch.cmu import CMU_TERMS, CMU_URL, FetchProgress, FetchReport, fetch_cmu

__all__ = ["CMU_TERMS", "CMU_URL", "FetchProgress", "FetchReport", "fetch_cmu"]
