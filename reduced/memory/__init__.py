"""Viscoelastic springs: materials, histories of load, impacts."""
