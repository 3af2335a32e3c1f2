"""Regression of the reduced model: comparison with stored curves of model and references."""
