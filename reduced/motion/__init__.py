"""Rigid masses on springs, and under the continuous friction law."""
