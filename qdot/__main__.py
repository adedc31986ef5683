"""`python -m qdot`: the command line."""

from qdot.grader.cli.main import run

run()
