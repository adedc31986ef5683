"""Reports on graded work: one module an outlet, all made from the same results."""
