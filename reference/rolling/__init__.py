"""Steady rolling of a rigid roller with Coulomb friction and creep, seen from the contact.

- `tractions`: stick, slip and its direction at given bounds, on any elastic surface;
- `contact.roll`: pressed and rolled, with the coupling of both;
- `plane`: the plane half-space;
- `coefficients`: the limit of small creep;
- `transient`: step by step, from any state, and rough rollers;
- `theories`: Kalker's linear theory and FASTSIM.
"""
