"""The 3-D ground truth: closed forms, half-space and finite-element contact solvers."""
