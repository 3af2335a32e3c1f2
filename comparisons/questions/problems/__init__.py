"""Numbered problems that anyone's solver can enter, and how entries are judged."""
