"""Three-dimensional shapes as equivalent one-dimensional profiles."""
