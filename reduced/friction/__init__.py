"""Springs that stick and slip."""
