"""The results folder: what is written, read, checked, compared."""
