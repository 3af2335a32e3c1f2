"""Third-party code in separate processes."""
