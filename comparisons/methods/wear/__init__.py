"""Rigid bodies that wear on an elastic half-space, in sliding or in fretting."""
