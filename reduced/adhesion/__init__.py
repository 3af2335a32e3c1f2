"""Adhesive springs (Hess' rule)."""
