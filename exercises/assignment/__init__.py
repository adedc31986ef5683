"""An instructor's folder: read, checked, and its notebooks written for a class.

It imports what makes a problem and its notebook; exports and the site are above it.

    assignment                  assignment.toml, roster.csv and the secret, as one object
    decimals, lateness          what decimals may be off, and what late work loses
    attempt_policy              which of several notebooks count
    gradebook                   Canvas's and Moodle's own exports as rosters
    redrawn, draws              whose problems were drawn anew; problems drawn until one passes its certificate
    sets, release               ready-made sets of problems; an assignment made, its notebooks written
    store                       what was worked out, kept for grading
"""
