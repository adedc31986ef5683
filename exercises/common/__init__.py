"""General helpers for every part of qdot, independent of robots: errors, files, processes, the terminal.

This package imports nothing from the rest of qdot.

    errors                      the one exception that users are meant to read
    extras                      how qdot is installed; optional libraries
    variation                   how much arms may differ from the chapter's: axes, and steps (sets of axes)
    files, input_file           atomic writing of files; input files, with error messages that name the line
    json_form                   conversion of dataclasses to JSON and back
    stream                      the random stream behind every problem (SHAKE-256)
    console, parallel           results, notes and progress; a function applied to many items on several processes
    time_limit                  a limit of processor time
    notebook_limits             the limits of a notebook while it is graded
"""
