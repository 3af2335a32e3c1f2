"""Tasks, their solutions, and storage on disk."""
