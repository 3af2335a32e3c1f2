"""Scene files: tables and units."""
