"""Finds and unpacks the files that students submit, splits them into cells, and locates the answers.

It imports the sandbox and judging.

    cells, archives     a file as cells; zip and tar archives, within limits
    layouts, roster     how platforms name submissions; which student submitted them
    submission          the files of each student, the one to grade first
    answer_locator      the cell with the answer to each part
"""
