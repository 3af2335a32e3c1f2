"""Files of measured heights: a file per family of formats, opened and checked in `heights`."""
