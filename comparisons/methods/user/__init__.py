"""User-supplied methods: files, functions, classes."""
