"""The results folder: writing, reading, checking and comparing results."""
