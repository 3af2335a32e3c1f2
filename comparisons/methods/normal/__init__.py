"""Pressed without friction: closed forms, springs and lines, the half-space on a grid."""
