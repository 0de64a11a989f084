"""Words of captures: vocabulary, association with motion symbols, decoding."""
