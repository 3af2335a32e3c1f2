"""A single contact on independent springs, and its surface stress."""
