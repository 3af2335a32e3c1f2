"""Springs with stick and slip."""
