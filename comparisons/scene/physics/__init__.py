"""Physics beyond frictionless elastic contact; scenes without its tables do not use them."""
