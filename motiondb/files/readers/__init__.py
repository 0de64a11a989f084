"""Readers: bytes of one format to a clip, or every fault with its line."""
