"""Indenters on a half-space that yields, under a path of loads."""
