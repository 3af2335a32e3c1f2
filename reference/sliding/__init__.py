"""Steady sliding of rigid rough bodies over a viscoelastic half-space, in three dimensions.

- `kernels`: Love's coefficients for pressure that travels, and the periodic transfer function;
- `operators.Travelling`: the half-space on a grid;
- `contact.solve`: the contact, whose operator is not symmetric;
- `studies`: a paraboloid on grids of its own, and grid studies with an error bar.
"""
