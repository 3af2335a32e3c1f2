"""From a plan to solutions: planning, execution, kept solves, executors."""
