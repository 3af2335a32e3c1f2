"""Rough lines on springs: spectra, contacts at all loads, ensembles."""
