"""A single contact on independent springs, and the stress that they stand for."""
