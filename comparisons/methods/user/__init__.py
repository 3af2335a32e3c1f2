"""Methods from outside, of files and installed packages: each runs in a process of its own."""
