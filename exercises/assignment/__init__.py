"""An instructor's assignment folder: reads and checks it, and writes the notebooks of a class.

This package imports the packages that make problems and notebooks. The exports and the site import this package.

    assignment                  assignment.toml, roster.csv and the secret, as one object
    expected_forms              what is expected of each value, for error messages (expected_forms.toml)
    decimals, lateness          tolerances of decimals; penalties for late work
    attempt_policy              which of several notebooks count
    gradebook                   Canvas's and Moodle's own exports as rosters
    redrawn, draws              the record of replaced problems; problems regenerated until they pass their certificate
    sets, release               ready-made sets of problems; makes an assignment and writes its notebooks
    store                       results stored for grading
"""
