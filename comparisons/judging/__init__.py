"""The truth, its bar, errors and verdicts."""
