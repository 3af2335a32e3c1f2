"""What the user says: a scene, its tables and its units."""
