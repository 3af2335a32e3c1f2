"""Contact quantities between bounds that theorems prove, for what has no closed form."""
