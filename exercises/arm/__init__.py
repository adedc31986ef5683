"""The arm: a DH table, its kinematics by two routes, and where it is singular."""
