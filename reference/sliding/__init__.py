"""Steady sliding of rigid rough bodies over a viscoelastic half-space, in three dimensions.

- `kernels`: Love's coefficients for travelling pressure, and the periodic transfer function;
- `operators.Travelling`: the half-space on a grid;
- `contact.solve`: the contact, whose operator is not symmetric;
- `studies`: a paraboloid on fitted grids, and grid studies with an error bar.
"""
