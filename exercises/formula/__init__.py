"""Formulas as people write them: read, evaluated, compared as functions and as sets of configurations."""
