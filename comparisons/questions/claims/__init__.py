"""Claims: statements about the reduced model with a tolerance, and the verdict on each."""
