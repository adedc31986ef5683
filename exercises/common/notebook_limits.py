"""The limits of a notebook while it is graded; the notebook states them, and the grader sets them."""

NOTEBOOK_SECONDS, CELL_SECONDS = 180.0, 90.0
"""The processor time in seconds that a notebook and each of its cells may take."""
MEMORY_GIGABYTES = 3
"""The memory that a notebook may take."""
