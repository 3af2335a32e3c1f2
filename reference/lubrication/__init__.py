"""Lubricating films: Reynolds' equation with mass-conserving cavitation, on an elastic half-space.

- `cells`: equal cells where bodies deform, wider ones around them;
- `reynolds`: the balance of mass in the cells;
- `transport`: entrainment by moving surfaces, or approach;
- `surface`: what gives way under the film;
- `loaded`: all of it under a load, by Newton's method;
- `point`: a ball; `line`: a rigid cylinder;
- `plane`: oil that flows between nominally flat rough bodies;
- `formulas`: closed forms, and fits.
"""
