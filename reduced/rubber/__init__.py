"""A rough line sliding over viscoelastic springs."""
