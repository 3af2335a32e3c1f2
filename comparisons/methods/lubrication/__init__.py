"""Lubricating films: entrained steadily, or squeezed."""
