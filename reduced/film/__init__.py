"""A lubricating film on the springs of the reduced model: entrained, or squeezed."""
