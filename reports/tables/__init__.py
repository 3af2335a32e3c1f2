"""Tables as data, one builder each, drawn for pages, terminals, papers and notebooks."""
