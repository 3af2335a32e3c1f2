"""Springs that relax: materials, histories of load, impacts."""
