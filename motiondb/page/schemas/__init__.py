"""Schemas of the answers, for the OpenAPI description.

The routes answer with what the facts give; nothing is computed from these models. Tests check that
the answers fit them.
"""
