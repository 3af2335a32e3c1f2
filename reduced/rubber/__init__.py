"""A rough line that slides over relaxing springs."""
