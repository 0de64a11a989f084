"""The places of the captions' actions in their takes, by segments and by frames."""
