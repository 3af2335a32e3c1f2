"""Lubricating films: Reynolds' equation with mass-conserving cavitation, on elastic bodies.

- `reynolds`: cells, and the balance of mass in them, entrained or squeezed; a rigid cylinder;
- `loaded`: film and elastic half-space under a load, by Newton's method;
- `point`: a ball, smooth or rough;
- `formulas`: closed forms, and fits.
"""
