"""Springs whose edges hold (Hess' rule)."""
