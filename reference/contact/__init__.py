"""Unilateral contact of a rigid shape on any elastic body that is linear in its pressures."""
