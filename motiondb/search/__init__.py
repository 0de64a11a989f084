"""Search: intervals of captures by words or by an example, with reasons and probabilities."""
