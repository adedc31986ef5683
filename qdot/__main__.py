"""`python -m qdot`: the command line."""

from qdot.grader.cli import run

run()
