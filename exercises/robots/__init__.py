"""Read arms from files: a user's own, or the library's, of which each robot is a file in this folder.

Each module uses only modules above it in this list:

    entry               parser for one entry of a table
    urdf, robot_file    readers of a user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text          writer of an arm as ROBOT.toml
    library             the library of real robots
"""
