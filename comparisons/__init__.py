"""Scenes, plans, methods and studies: the reduced model against the ground truth."""
