"""Springs whose profile wears."""
