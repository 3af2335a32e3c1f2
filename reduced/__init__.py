"""The 1-D model under test: contact reduced to a line on independent springs."""
