"""What is asked: robots, problems, their reference solutions, and every form they are handed out in."""

ENGINE = 1
"""Version of the problem generator: any change of what an id regenerates raises it."""

__all__ = ["ENGINE"]
