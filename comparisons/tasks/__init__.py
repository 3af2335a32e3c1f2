"""A task, what comes back from it, and how it is kept."""
