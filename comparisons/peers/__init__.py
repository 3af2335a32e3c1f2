"""Third-party solvers, run on the same problems in processes of their own, which import them."""
