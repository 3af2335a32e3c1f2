"""Claims: statements about the reduced model with a tolerance, and their verdicts."""
