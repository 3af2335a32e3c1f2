"""Facts about methods and quantities, one row each, without importing any solver."""
