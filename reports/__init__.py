"""The face: command line, HTML report, figures and pictures."""
