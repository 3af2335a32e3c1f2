"""Steady sliding of rigid rough bodies over a viscoelastic half-space, in three dimensions.

- `travelling`: the half-space under pressure that travels, on a grid;
- `rubber.slide_on_rubber`: the contact, whose operator is not symmetric;
- `studies`: a paraboloid on fitted grids, and grid studies with an error bar.
"""
