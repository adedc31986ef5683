"""Find and unpack the files that students submit, split them into cells, and locate the answers.

This package imports the sandbox and the problems; the package grading imports this package.

    cells, archives     split a file into cells; unpack zip and tar archives, within limits
    layouts, roster     recognise how platforms name submissions; find the student who submitted them
    submission          list the files of each student, and read the notebook to grade
    answer_locator      find the answer to each part in the cells
"""
