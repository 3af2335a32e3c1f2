"""Rough lines on springs: their spectra, the walk down their heights, ensembles."""
