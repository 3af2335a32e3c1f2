"""Masses that collide: elastic, viscoelastic, or by the static load curve."""
