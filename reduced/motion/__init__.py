"""Rigid masses on springs, and blocks with the continuous friction law."""
