"""Figures and tables for papers: matplotlib, LaTeX and Markdown, the same digits every time.

Nothing here is imported before it is asked for: matplotlib is an extra.
"""
