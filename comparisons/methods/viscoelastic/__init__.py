"""Relaxing bodies: pressed in time, and sliding steadily."""
