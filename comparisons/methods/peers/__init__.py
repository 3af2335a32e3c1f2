"""Solvers of other people, on our grids and on meshes of their own."""
