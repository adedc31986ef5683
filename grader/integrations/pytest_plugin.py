"""Stand in for the removed pytest plugin, which older installations of qdot still name; it does nothing."""
