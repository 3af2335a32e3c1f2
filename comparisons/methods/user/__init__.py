"""Methods that a user brings: files, functions, objects of a session."""
