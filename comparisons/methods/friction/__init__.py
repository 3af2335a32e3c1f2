"""Coulomb friction under tangential loads."""
