"""Planning and execution of solves, cached answers, executors."""
