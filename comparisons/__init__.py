"""Scenes, plans, methods and studies: the reduced model against the ground truth."""

from comparisons import code_cache

code_cache.choose_folder()
