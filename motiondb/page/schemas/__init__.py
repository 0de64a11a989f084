"""Schemas of the answers, for the OpenAPI description.

The routes answer with the dictionaries of :mod:`motiondb.page.facts`; these models only describe
them. Tests check that the answers fit the models.
"""
