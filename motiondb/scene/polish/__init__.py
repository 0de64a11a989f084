"""A sampled scene made into motions: time, paths and bodies edited."""
