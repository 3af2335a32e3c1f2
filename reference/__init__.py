"""The 3-D ground truth: closed forms, half-space and finite-element contact solvers.

Inputs and outputs are arrays and numbers in consistent units; the package uses no files or scenes.
Arguments out of range are refused with one ValueError that names all of them; solvers that find no
answer raise `errors.ConvergenceError`.
"""
