"""What students hand in: found, unpacked, and read as cells; whose it is, and where the answers are.

It imports the sandbox, which reads large files, and judging, which knows what an answer is.

    cells, archives             a file as cells; zip and tar archives, within limits
    layouts, roster             how platforms name what was handed in; whose it is
    submission                  what may be graded, the best first
    answer_locator, uncounted   the cell in which the answer to each part is; which cells need not be run
"""
