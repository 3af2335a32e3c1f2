"""Other people's code in processes of its own."""
