"""Springs that yield: caps on their force from the chapter's stress rule, and Zunker & Kamrin."""
