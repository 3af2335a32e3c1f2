"""Adhesion under a path of loads."""
