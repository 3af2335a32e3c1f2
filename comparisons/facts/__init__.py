"""What is known of methods and quantities, a row for each; light enough to list."""
