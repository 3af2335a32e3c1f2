"""Figures and tables for papers: matplotlib, LaTeX and Markdown, reproducible to the byte.

matplotlib is an optional extra, so this package is imported only when needed.
"""
