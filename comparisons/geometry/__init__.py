"""Indenters, measured maps and bodies, prepared once per scene."""
