"""Rendered pictures of bodies and surfaces."""
