"""Steady rolling with friction and creep."""
