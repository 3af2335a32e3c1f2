"""Finite elements, a file for what is meshed.

Under a rigid indenter, a user's body, two elastic bodies, a rough patch; their load step.
"""
