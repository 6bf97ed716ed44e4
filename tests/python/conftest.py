"""Hypothesis for all tests here: no deadline, which a busy machine would miss, and no folder of found examples: a test
prints how to repeat a failure."""

from hypothesis import settings

settings.register_profile("tilecast", deadline=None, database=None, print_blob=True)
settings.load_profile("tilecast")
