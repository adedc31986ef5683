"""Read arms from files: a user's own arm, or a robot of the library, whose files are in this folder.

Each module uses only modules above it in this list:

    entry               parser for one entry of a table
    urdf, robot_file    readers of a user's own arm: a URDF; a ROBOT.toml in any convention
    robot_text          writer of an arm as ROBOT.toml
    library             the library of real robots
"""
